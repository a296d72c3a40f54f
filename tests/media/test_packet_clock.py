"""Jumps of a container's clock: bridged, reported, and the same for all streams."""

from __future__ import annotations

import os
import re
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from media import make_clip

import vidstyle
from vidstyle.media.read.packet_clock import PacketClock

FRAMES = 90
HOUR = 3600


def leaping(path: Path, hours: int, first: float, last: float) -> Path:
    """A Matroska film of 3 s whose clusters between two times, in seconds, are hours late.

    It begins at 20 hours, so that the time of each cluster has four bytes.
    """
    clip = make_clip(path.with_name("whole.mp4"), frames=FRAMES, audio_tracks=1, options={"bf": "2"})
    options = {"cluster_time_limit": "400"}
    with av.open(str(clip)) as given, av.open(str(path), "w", container_options=options) as made:
        streams = [made.add_stream_from_template(stream) for stream in given.streams]
        for packet in given.demux():
            if packet.size:
                offset = round(20 * HOUR / packet.time_base)
                packet.pts, packet.dts = packet.pts + offset, packet.dts + offset
                packet.stream = streams[packet.stream_index]
                made.mux(packet)
    content = bytearray(path.read_bytes())
    for found in re.finditer(rb"\xe7\x84(\x04[\x40-\x5f]..)", content, re.DOTALL):
        time = int.from_bytes(found[1])
        if first <= time / 1000 - 20 * HOUR < last:
            content[found.start(1) : found.end(1)] = (time + hours * HOUR * 1000).to_bytes(4)
    path.write_bytes(content)
    return path


def shown(path: Path, stream: str) -> list[float]:
    """The times of all packets in seconds, sorted."""
    with av.open(str(path)) as container:
        packets = container.demux(**{stream: 0})
        return sorted(float(packet.pts * packet.time_base) for packet in packets if packet.size)


@pytest.mark.parametrize("hours", [24, 100])
@pytest.mark.parametrize("ending", [".mp4", ".mov", ".mkv"])
def test_a_leap_of_hours_is_bridged_and_reported(tmp_path, hours, ending):
    source, target = leaping(tmp_path / "in.mkv", hours, 1, 9), tmp_path / f"out{ending}"
    summary = vidstyle.render(source, target, "plain")
    assert summary.exit_code == 4 and summary.damage.endswith("its clock jumps once (bridged)")
    times, whole = shown(target, "video"), shown(tmp_path / "whole.mp4", "video")
    assert times == pytest.approx(whole, abs=0.06), "the delay of B-frames may be off by a frame or two"
    assert shown(target, "audio") == pytest.approx(shown(tmp_path / "whole.mp4", "audio"), abs=0.06)


def test_a_clock_that_leaps_and_returns_is_itself_again(tmp_path):
    source, target = leaping(tmp_path / "in.mkv", 30, 1, 2), tmp_path / "out.mov"
    summary = vidstyle.render(source, target, "plain")
    assert summary.exit_code == 4 and len(shown(target, "video")) == FRAMES
    films = (target, tmp_path / "whole.mp4")
    pictures, sound = ([shown(film, stream)[-20:] for film in films] for stream in ("video", "audio"))
    offset = pictures[0][0] - pictures[1][0]
    assert -0.001 < offset < 0.03, "FFmpeg 8 moves the sound, which begins before zero"
    for late, whole in (pictures, sound):
        assert np.subtract(late, whole) == pytest.approx(offset, abs=0.002)


def test_a_gap_while_another_stream_goes_on_is_meant():
    """As in a recording of slides with a talk."""
    clock, talk = PacketClock(Fraction(0), broadcast=False), range(0, 3 * HOUR, 60)
    with av.open(os.devnull, "w", "null") as container:
        streams = [container.add_mux_stream("pcm_s16le"), container.add_mux_stream("mpeg4")]
        slides = [packet(streams[1], seconds) for seconds in (0, 1, 3 * HOUR)]
        for each in [*slides[:2], *(packet(streams[0], minute) for minute in talk), slides[2]]:
            clock.restamp(each)
    assert clock.jumps == 0 and slides[2].pts == 3 * HOUR * 1000


@pytest.mark.parametrize("broadcast", [True, False])
def test_a_first_time_far_from_the_start_is_bridged(broadcast):
    """The start of a film is the earliest time of any stream, which may come later in the file."""
    clock = PacketClock(Fraction(0), broadcast)
    with av.open(os.devnull, "w", "null") as container:
        streams = [container.add_mux_stream("pcm_s16le"), container.add_mux_stream("mpeg4")]
        sound = [packet(streams[0], 20 * HOUR + number) for number in range(3)]
        pictures = [packet(streams[1], number and 20 * HOUR + number) for number in range(3)]
        for each in [sound[0], pictures[0], sound[1], pictures[1], sound[2], pictures[2]]:
            clock.restamp(each)
    assert max(each.pts for each in (*sound, *pictures)) < 10_000 and clock.jumps == 1
    assert clock.forward_jumps == (not broadcast)


def test_a_first_time_after_a_seek_is_kept():
    clock = PacketClock(Fraction(0), broadcast=True)
    clock.reset(from_start=False)
    with av.open(os.devnull, "w", "null") as container:
        first = packet(container.add_mux_stream("mpeg4"), 20 * HOUR)
        clock.restamp(first)
    assert clock.jumps == 0 and first.pts == 20 * HOUR * 1000


def test_a_duration_of_hours_moves_no_later_packet():
    clock = PacketClock(Fraction(0), broadcast=False)
    with av.open(os.devnull, "w", "null") as container:
        stream = container.add_mux_stream("mpeg4")
        packets = [packet(stream, number) for number in range(5)]
        for each in packets:
            each.duration = 10**9
            clock.restamp(each)
    assert [each.pts for each in packets] == [0, 1000, 2000, 3000, 4000] and clock.jumps == 0


def packet(stream: av.stream.Stream, seconds: float) -> av.Packet:
    made = av.Packet(b"x")
    made.stream, made.time_base = stream, Fraction(1, 1000)
    made.pts = made.dts = round(seconds * 1000)
    return made


def test_sound_after_a_gap_that_the_container_cannot_hold_is_lost(tmp_path):
    """MP4 holds 13.5 hours between two packets of sound at 44.1 kHz; above that its muxer aborts."""
    source, target, rate = tmp_path / "in.mkv", tmp_path / "out.mp4", 44100
    with av.open(str(source), "w") as container:
        screen = container.add_stream("mpeg4", rate=1)
        screen.width, screen.height, screen.pix_fmt = 16, 16, "yuv420p"
        screen.codec_context.time_base = Fraction(1, 1000)
        speaker = container.add_stream("aac", rate=rate)
        packets = []
        for minute in range(14 * 60 + 2):
            frame = av.VideoFrame(16, 16, "yuv420p")
            frame.pts, frame.time_base = minute * 60_000, Fraction(1, 1000)
            packets += screen.encode(frame)
        for number in range(40):
            sound = av.AudioFrame.from_ndarray(np.zeros((2, 1024), np.float32), "fltp", "stereo")
            sound.pts, sound.sample_rate = 1024 * number + (number >= 20) * 14 * HOUR * rate, rate
            sound.time_base = Fraction(1, rate)
            packets += speaker.encode(sound)
        packets += screen.encode(None) + speaker.encode(None)
        for each in sorted(packets, key=lambda each: each.dts * each.time_base):
            container.mux(each)
    summary = vidstyle.render(source, target, "plain")
    assert summary.exit_code == 4 and "of stream 1 (audio) lost" in summary.damage
    assert len(shown(target, "video")) == 14 * 60 + 2 and 0 < len(shown(target, "audio")) < 40


def test_a_fine_time_base_leaves_room_for_a_gap_in_mp4(tmp_path):
    source, target, base = tmp_path / "in.nut", tmp_path / "out.mp4", Fraction(1, 10**9)
    clip = make_clip(tmp_path / "clip.mkv", frames=4, options={"bf": "0"})
    with av.open(str(clip)) as given, av.open(str(source), "w") as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        stream.time_base = base
        for number, each in enumerate(each for each in given.demux() if each.size):
            each.time_base, each.stream = base, stream
            each.pts = each.dts = (number + 3000 * (number >= 2)) * 10**9
            made.mux(each)
    assert vidstyle.render(source, target, "plain").exit_code == 0
    assert shown(target, "video") == pytest.approx([0, 1, 3002, 3003], abs=1e-4)


def spaced(path: Path, seconds: list[float]) -> Path:
    """A Matroska film with a frame at each of some times."""
    return make_clip(path, size=(64, 48), times=[Fraction(each) for each in seconds], options={"bf": "0"})


def test_a_gap_that_is_too_long_for_avi_is_divided(tmp_path):
    """Its muxer fills gaps with empty packets, and refuses to write more than 60,000."""
    gap = 3590
    source, target = spaced(tmp_path / "in.mkv", [0, 1, gap, gap + 1]), tmp_path / "out.avi"
    summary = vidstyle.render(source, target, "plain")
    times = shown(target, "video")
    assert (summary.exit_code, summary.frames) == (0, 4)
    assert times[-1] == pytest.approx(gap + 1, abs=0.1) and times[0] == 0


def test_avi_is_written_with_at_most_the_rate_that_it_holds(tmp_path):
    source = make_clip(tmp_path / "in.mov", size=(64, 48), rate=7680, frames=10, codec="mpeg4")
    summary = vidstyle.render(source, tmp_path / "out.avi", "plain")
    assert (summary.exit_code, summary.frames) == (0, 10)
    assert len(shown(tmp_path / "out.avi", "video")) == 10


def test_frames_years_apart_are_taken_for_frames_without_times(tmp_path, caplog):
    """The header of an AVI file gives the time of a frame as a fraction."""
    source = make_clip(tmp_path / "in.avi", size=(64, 48), frames=10, codec="mpeg4")
    content = bytearray(source.read_bytes())
    start = content.index(b"strh") + 8 + 20
    content[start : start + 8] = (778_409_643).to_bytes(4, "little") + (10).to_bytes(4, "little")
    source.write_bytes(content)
    summary = vidstyle.render(source, tmp_path / "out.avi", "plain")
    assert summary.frames == 10 and "the stream has no timestamps" in caplog.text
    assert shown(tmp_path / "out.avi", "video") == pytest.approx([number / 25 for number in range(10)])
