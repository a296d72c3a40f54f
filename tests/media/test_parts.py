"""Recordings whose streams restart midway, and films with a broken video track: losses are reported."""

from __future__ import annotations

import os
from contextlib import ExitStack, suppress
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from threading import Thread

import av
import pytest
from av.codec.hwaccel import HWAccel
from media import make_clip

import vidstyle
from vidstyle.errors import InputError
from vidstyle.media.options import ReadOptions
from vidstyle.media.read.file_structure.transport_stream import (
    RecordingStream,
    find_recording_parts,
    opened_stream,
)
from vidstyle.media.read.sampler import FilmSampler

FRAMES = 60


def recording(
    path: Path, first_pid: int, sound_pid: int = 0, sounds: int = 1, frames: int = FRAMES, **options: object
) -> bytes:
    """Write a transport stream of 2 s with a first PID, and optionally another PID of the sound."""
    clip = make_clip(path.with_suffix(".mp4"), frames=frames, audio_tracks=sounds, **options)
    pids = {"mpegts_start_pid": str(first_pid)}
    with av.open(str(clip)) as given, av.open(str(path), "w", container_options=pids) as made:
        streams = [made.add_stream_from_template(stream) for stream in given.streams]
        if sound_pid:
            streams[0].id, streams[1].id = first_pid, sound_pid
        for packet in given.demux():
            if packet.size:
                packet.stream = streams[packet.stream_index]
                made.mux(packet)
    return path.read_bytes()


def joined(folder: Path, *parts: bytes) -> Path:
    path = folder / "joined.ts"
    path.write_bytes(b"".join(parts))
    return path


def part_offsets(path: Path) -> list[int]:
    return [part.start for part in find_recording_parts(path)]


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
    assert "start again 2 times" in caplog.text
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


def test_a_stream_whose_codec_changes_begins_a_part(tmp_path):
    first, second = (
        recording(tmp_path / f"{codec}.ts", 256, codec=codec) for codec in ("libx264", "mpeg2video")
    )
    summary = vidstyle.render(joined(tmp_path, first, second, first), tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (0, 3 * FRAMES)


def test_a_second_video_stream_of_a_part_is_counted(tmp_path):
    first, second = recording(tmp_path / "a.ts", 256), tmp_path / "b.ts"
    clip = make_clip(tmp_path / "clip.mp4", frames=FRAMES)
    with av.open(str(clip)) as given, av.open(str(second), "w", options={"mpegts_start_pid": "600"}) as made:
        streams = [made.add_stream_from_template(given.streams.video[0]) for _ in range(2)]
        for packet in given.demux(video=0):
            for stream in streams if packet.size else ():
                copy = av.Packet(bytes(packet))
                copy.pts, copy.dts, copy.time_base, copy.stream = (
                    packet.pts,
                    packet.dts,
                    packet.time_base,
                    stream,
                )
                made.mux(copy)
    source = joined(tmp_path, first, second.read_bytes())
    summary = vidstyle.render(source, tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, 2 * FRAMES)
    assert f"{FRAMES} packets without a matching stream" in summary.damage


def test_a_damaged_table_begins_no_part(tmp_path):
    content = bytearray(recording(tmp_path / "a.ts", 256))
    tables = [place for place in range(0, len(content), 188) if content[place + 1 : place + 3] == b"\x50\x00"]
    content[tables[1] + 5 + 13] ^= 1  # in the PID of the video
    assert len(tables) > 3 and part_offsets(joined(tmp_path, bytes(content))) == [0]


PADDING = (b"\x47\x1f\xff\x10" + b"\xff" * 184) * 30_000
"""Empty packets: FFmpeg looks for streams in the first 5 MB, and at the end of a file."""


@pytest.fixture
def feed(monkeypatch):
    """Gives content on standard input, from a pipe that returns at most N bytes per read."""
    threads = []

    def write(inlet: int, content: bytes, step: int) -> None:
        with os.fdopen(inlet, "wb") as pipe, suppress(BrokenPipeError):
            for start in range(0, len(content), step):
                pipe.write(content[start : start + step])
                pipe.flush()

    def begin(content: bytes, step: int = 2**20) -> None:
        outlet, inlet = os.pipe()
        files.enter_context(file := os.fdopen(outlet))
        monkeypatch.setattr("sys.stdin", file)
        threads.append(Thread(target=write, args=(inlet, content, step)))
        threads[-1].start()

    with ExitStack() as files:
        yield begin
    for thread in threads:
        thread.join()


@pytest.mark.parametrize("padding", [b"", PADDING], ids=["soon", "late"])
@pytest.mark.parametrize("step", [1316, 2**20])
def test_standard_input_goes_on_where_pids_change(tmp_path, caplog, feed, padding, step):
    first = recording(tmp_path / "a.ts", 256)
    second = recording(tmp_path / "b.ts", 600, codec="mpeg2video", size=(96, 64))
    content = first + padding + second + first
    caplog.set_level("INFO")
    feed(content, step)
    summary = vidstyle.render("-", tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames, summary.damage) == (0, 3 * FRAMES, "")
    assert caplog.text.count("start again (continued)") == 2
    source = joined(tmp_path, content)
    assert vidstyle.render(source, tmp_path / "file.mkv", "plain").frames == 3 * FRAMES
    for stream in ("video", "audio"):
        assert times(tmp_path / "out.mkv", stream) == times(tmp_path / "file.mkv", stream)


@pytest.mark.parametrize("size", [100, 2**15])
def test_a_stream_is_divided_where_a_file_is(tmp_path, size):
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    path = joined(tmp_path, first, second, first)
    bounds = [*part_offsets(path), path.stat().st_size]
    with path.open("rb") as file:
        stream, parts = opened_stream(file), []
        assert isinstance(stream, RecordingStream)
        while not parts or stream.enter_next_part():
            parts.append(b"".join(iter(lambda: stream.read(size), b"")))
    content = path.read_bytes()
    assert parts == [content[start:end] for start, end in pairwise(bounds)] and len(parts) == 3


def test_a_redirected_file_goes_on_where_pids_change(tmp_path, monkeypatch):
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    with joined(tmp_path, first, second).open() as file:
        monkeypatch.setattr("sys.stdin", file)
        summary = vidstyle.render("-", tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (0, 2 * FRAMES)


@pytest.mark.parametrize("ending", [".mkv", ".y4m", ".mp4"])
@pytest.mark.parametrize("is_pipe", [True, False])
def test_other_formats_on_standard_input_are_read_whole(tmp_path, monkeypatch, feed, ending, is_pipe):
    clip = make_clip(tmp_path / f"clip{ending}", codec="wrapped_avframe" if ending == ".y4m" else "libx264")
    if ending == ".mp4" and is_pipe:
        pytest.skip("its index is behind the frames")
    with clip.open() as file:
        monkeypatch.setattr("sys.stdin", file)
        if is_pipe:
            feed(clip.read_bytes(), 100)
        summary = vidstyle.render("-", tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (
        0,
        vidstyle.render(clip, tmp_path / "o.mkv", "plain").frames,
    )


def test_a_later_part_of_standard_input_that_is_refused_is_damage(tmp_path, caplog, feed):
    first = recording(tmp_path / "a.ts", 256, size=(64, 48))
    second = recording(tmp_path / "b.ts", 600, size=(320, 240))
    feed(first + second + first)
    options = ReadOptions(max_pixels=160 * 120)
    summary = vidstyle.render("-", tmp_path / "out.mkv", "plain", read=options)
    assert (summary.exit_code, summary.frames) == (4, 2 * FRAMES)
    assert "is skipped" in caplog.text


def test_tables_that_come_apart_begin_a_part(tmp_path):
    """Broadcasters repeat the list of programs and each program's list of streams at different times."""
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    packets = [second[start : start + 188] for start in range(0, len(second), 188)]
    is_list = [packet[1] & 0x1F == packet[2] == 0 for packet in packets]
    late = b"".join(packet for number, packet in enumerate(packets) if not is_list[number] or number > 20)
    assert sum(is_list[:20]) == 1
    summary = vidstyle.render(joined(tmp_path, first, late), tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (0, 2 * FRAMES)


def test_hardware_that_is_missing_is_named_for_a_pipe(tmp_path, feed):
    with suppress(OSError):
        HWAccel("cuda").create(av.Codec("h264", "r"))
        pytest.skip("this machine has the hardware")
    feed(recording(tmp_path / "a.ts", 256))
    with pytest.raises(InputError, match="cuda cannot decode here.*leave out --hwaccel"):
        vidstyle.render("-", tmp_path / "out.mkv", "plain", read=ReadOptions(hwaccel="cuda"))


def test_sound_that_begins_late_on_standard_input_is_reported(tmp_path, feed):
    """PyAV passes nothing on of streams that FFmpeg finds later."""
    first, second = (recording(tmp_path / f"{pid}.ts", 256, pid) for pid in (257, 300))
    feed(first + PADDING + second)
    summary = vidstyle.render("-", tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, 2 * FRAMES)
    assert "unreadable streams that start in mid-file: 1" in summary.damage


def test_sound_goes_on_where_only_its_pid_changes(tmp_path):
    first, second = (recording(tmp_path / f"{pid}.ts", 256, pid) for pid in (257, 300))
    source, target = joined(tmp_path, first, second), tmp_path / "out.mkv"
    summary = vidstyle.render(source, target, "plain")
    assert (summary.exit_code, summary.frames) == (0, 2 * FRAMES)
    pictures, sound = times(target, "video"), times(target, "audio")
    assert abs(sound[-1] - pictures[-1]) < 0.1 and len(sound) > 2 * 90


def test_sound_that_begins_late_in_a_file_is_reported(tmp_path):
    first, second = (recording(tmp_path / f"{pid}.ts", 256, pid) for pid in (257, 300))
    source = joined(tmp_path, first, PADDING, second, PADDING, first)
    summary = vidstyle.render(source, tmp_path / "out.mkv", "plain")
    assert (summary.exit_code, summary.frames) == (4, 3 * FRAMES)
    assert "unreadable streams that start in mid-file: 1" in summary.damage


def test_sound_that_continues_no_stream_is_damage(tmp_path):
    first, second = recording(tmp_path / "a.ts", 256, sounds=1), recording(tmp_path / "b.ts", 600, sounds=2)
    summary = vidstyle.render(joined(tmp_path, first, second), tmp_path / "out.mkv", "plain")
    assert summary.exit_code == 4 and "packets without a matching stream" in summary.damage


def test_one_part_has_no_others(tmp_path):
    content = recording(tmp_path / "a.ts", 256)
    assert part_offsets(joined(tmp_path, content)) == [0]
    assert part_offsets(joined(tmp_path, content, content)) == [0], "the same PIDs continue"
    assert part_offsets(joined(tmp_path, b"\x47" * 1000)) == part_offsets(joined(tmp_path, b"x")) == [0]


def test_parts_are_found_where_packets_are_torn(tmp_path):
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    torn = len(first) - 100
    offsets = part_offsets(joined(tmp_path, first[:torn], bytes(2**17), second))
    assert len(offsets) == 2 and abs(offsets[1] - torn - 2**17) < 2**16


@pytest.mark.parametrize("added", [b"\x00", b"\x47" * 3, bytes(187)])
def test_a_part_is_found_before_and_after_bytes_that_were_added(tmp_path, added):
    """Most packets are not a multiple of their size apart from the first one."""
    first, second = (recording(tmp_path / f"{pid}.ts", pid) for pid in (256, 600))
    soon = 188 * 12
    path = joined(tmp_path, first[: 188 * 40], second[:soon], added, second[soon:])
    assert part_offsets(path) == part_offsets(joined(tmp_path, first[: 188 * 40], second))


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
    with FilmSampler(source) as sampler:
        for _ in range(2):
            assert len(list(sampler.frames())) == summary.frames
            assert sampler.damage.is_significant == said
        assert sampler.image_at(0.1).shape[2] == 3
