"""Recordings whose streams begin anew midway, and films with a broken video track: nothing is lost unsaid."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import pytest
from media import make_clip

import vidstyle
from vidstyle.media.options import ReadOptions
from vidstyle.media.read.sampler import FilmSampler
from vidstyle.media.read.transport_stream import part_offsets

FRAMES = 60


def recording(path: Path, first_pid: int, sounds: int = 1, **options: object) -> bytes:
    """A transport stream of 2 s whose PIDs begin at one."""
    clip = make_clip(path.with_suffix(".mp4"), frames=FRAMES, audio_tracks=sounds, **options)
    pids = {"mpegts_start_pid": str(first_pid)}
    with av.open(str(clip)) as given, av.open(str(path), "w", container_options=pids) as made:
        streams = [made.add_stream_from_template(stream) for stream in given.streams]
        for packet in given.demux():
            if packet.size:
                packet.stream = streams[packet.stream_index]
                made.mux(packet)
    return path.read_bytes()


def joined(folder: Path, *parts: bytes) -> Path:
    path = folder / "joined.ts"
    path.write_bytes(b"".join(parts))
    return path


def times(path: Path, stream: str) -> list[float]:
    with av.open(str(path)) as container:
        packets = [packet for packet in container.demux(**{stream: 0}) if packet.size]
    return sorted(float(packet.pts * packet.time_base) for packet in packets)


@pytest.mark.parametrize("ending", [".mp4", ".mkv"])
def test_pictures_and_sound_go_on_where_pids_change(tmp_path, caplog, ending):
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    source, target = joined(tmp_path, first, second, first), tmp_path / f"out{ending}"
    caplog.set_level("INFO")
    summary = vidstyle.render(source, target, "plain")
    assert (summary.exit_code, summary.frames) == (0, 3 * FRAMES)
    assert "begin anew 2 times" in caplog.text
    pictures, sound = times(target, "video"), times(target, "audio")
    steps = [after - before for before, after in zip(pictures, pictures[1:], strict=False)]
    assert len(pictures) == 3 * FRAMES
    assert max(steps) < 0.06, "sound begins a little before the pictures"
    assert abs(sound[-1] - pictures[-1]) < 0.1 and len(sound) > 3 * 90


def test_a_part_of_another_size_and_codec_is_kept_too(tmp_path):
    first = recording(tmp_path / "a.ts", 256)
    second = recording(tmp_path / "b.ts", 600, codec="mpeg2video", size=(96, 64))
    summary = vidstyle.render(joined(tmp_path, first, second), tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (0, 2 * FRAMES)


def test_sound_that_continues_no_stream_is_damage(tmp_path):
    first, second = recording(tmp_path / "a.ts", 256, sounds=1), recording(tmp_path / "b.ts", 600, sounds=2)
    summary = vidstyle.render(joined(tmp_path, first, second), tmp_path / "out.mkv", "plain")
    assert summary.exit_code == 4 and "packets left out that continue no stream" in summary.damage


def test_one_part_has_no_others(tmp_path):
    content = recording(tmp_path / "a.ts", 256)
    assert part_offsets(joined(tmp_path, content)) == [0]
    assert part_offsets(joined(tmp_path, content, content)) == [0], "the same PIDs go on"
    assert part_offsets(joined(tmp_path, b"\x47" * 1000)) == part_offsets(joined(tmp_path, b"x")) == [0]


def test_parts_are_found_where_packets_are_torn(tmp_path):
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    torn = len(first) - 100
    offsets = part_offsets(joined(tmp_path, first[:torn], bytes(2**17), second))
    assert len(offsets) == 2 and abs(offsets[1] - torn - 2**17) < 2**16


def test_every_pass_over_a_transport_stream_has_every_frame(tmp_path):
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    for parts in ((first,), (first, second)):
        with FilmSampler(joined(tmp_path, *parts)) as sampler:
            assert len(list(sampler.key_frames(Fraction(1, 2)))) == 2 * len(parts)
            counts = [len(list(sampler.frames())) for _ in range(2)]
            assert counts == [len(parts) * FRAMES] * 2
            keys = [float(frame.time) for frame in sampler.key_frames(Fraction(1, 2))]
            assert keys == pytest.approx(range(2 * len(parts)), abs=0.1)
            sampler.image_at(2 * len(parts) - 0.1)
            assert not sampler.damage.is_significant


@pytest.mark.parametrize("start", ["0.5", "1.5", "3.5"])
def test_a_transport_stream_is_entered_without_false_damage(tmp_path, start):
    parts = [recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600)]
    options = ReadOptions(start=Fraction(start))
    summary = vidstyle.render(joined(tmp_path, *parts), tmp_path / "out.mp4", "plain", read=options)
    assert summary.exit_code == 0 and abs(summary.frames - (4 - float(start)) * 30) <= 3


@pytest.mark.parametrize("broken", [1, 0])
def test_another_video_track_is_taken_if_the_longest_is_broken(tmp_path, caplog, broken):
    clips = [make_clip(tmp_path / "0.mp4", frames=10), make_clip(tmp_path / "1.mp4", frames=30)]
    source = tmp_path / "in.mkv"
    with av.open(str(source), "w") as made, av.open(str(clips[0])) as one, av.open(str(clips[1])) as two:
        tracks = [(film, made.add_stream_from_template(film.streams.video[0])) for film in (one, two)]
        for number, (film, stream) in enumerate(tracks):
            for packet in (packet for packet in film.demux() if packet.size):
                content = b"\xff" * packet.size if number == broken else bytes(packet)
                copy = av.Packet(content)
                copy.pts, copy.dts, copy.time_base = packet.pts, packet.dts, packet.time_base
                copy.is_keyframe, copy.stream = packet.is_keyframe, stream
                made.mux(copy)
    summary = vidstyle.render(source, tmp_path / "out.mp4", "plain")
    said = "video stream 1 could be decoded" in caplog.text
    assert (summary.frames, summary.exit_code, said) == ((10, 4, True) if broken == 1 else (30, 0, False))
