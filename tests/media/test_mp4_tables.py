"""MP4 files whose index is damaged: what can be decoded is, and the damage is reported."""

from __future__ import annotations

import struct
from fractions import Fraction
from pathlib import Path

import av
import pytest
from media import make_clip, read_all

import vidstyle
from vidstyle.errors import InputError
from vidstyle.media.read.file_structure.mp4_tables import find_corrections, has_one_edit
from vidstyle.media.read.open import open_media

FRAMES = 60
TIMES = [Fraction(number, 30) + Fraction(number % 3, 200) for number in range(FRAMES)]
"""Uneven times, so that each frame has separate entries in the tables."""


def damaged(path: Path, table: bytes, changes: dict[int, int]) -> Path:
    """A film in which some numbers behind a table's version are others; number 0 is its count of entries."""
    content = bytearray(make_clip(path, times=TIMES, audio_tracks=1, options={"bf": "2"}).read_bytes())
    start = content.index(table) + 8
    for number, value in changes.items():
        struct.pack_into(">I", content, start + 4 * number, value)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("table", [b"stts", b"ctts", b"stss"])
@pytest.mark.parametrize("count", [10_000, 2**32 - 1])
def test_a_count_that_exceeds_its_table_is_cut(tmp_path, table, count):
    source, target = damaged(tmp_path / "in.mp4", table, {0: count}), tmp_path / "out.mp4"
    summary = vidstyle.render(source, target, "plain")
    assert summary.exit_code == 4 and "its index is invalid" in summary.damage
    assert summary.frames == len(read_all(target)) >= FRAMES - 1


@pytest.mark.parametrize("duration", [2**31 - 1, 2**30])
def test_a_frame_of_hours_is_no_reason_to_fail(tmp_path, duration):
    source, target = damaged(tmp_path / "in.mp4", b"stts", {12: duration}), tmp_path / "out.mp4"
    summary = vidstyle.render(source, target, "plain")
    assert summary.exit_code == 4 and "its clock jumps" in summary.damage
    assert len(read_all(target)) == summary.frames > 0


def test_decoding_times_half_a_day_before_zero_are_moved_to_it(tmp_path):
    source, target = damaged(tmp_path / "in.mp4", b"ctts", {42: 2**31}), tmp_path / "out.mp4"
    assert vidstyle.render(source, target, "plain").exit_code in (0, 4)
    with av.open(str(target)) as container:
        assert container.duration < 4 * av.time_base
        assert len(list(container.decode(video=0))) >= FRAMES - 3


def test_a_count_of_billions_is_not_reported_as_frames(tmp_path):
    source = damaged(tmp_path / "in.mp4", b"stts", {1: 2**31})
    summary = vidstyle.render(source, tmp_path / "out.mp4", "plain")
    assert summary.exit_code == 4 and "missing" not in summary.damage


def with_two_tables_of_durations(path: Path) -> Path:
    content = make_clip(path, frames=FRAMES).read_bytes()
    start = content.index(b"stts") - 4
    size = int.from_bytes(content[start : start + 4])
    for parent in (b"moov", b"trak", b"mdia", b"minf", b"stbl"):
        place = content.index(parent) - 4
        longer = int.from_bytes(content[place : place + 4]) + size
        content = content[:place] + longer.to_bytes(4) + content[place + 4 :]
    path.write_bytes(content[:start] + content[start : start + size] + content[start:])
    return path


def test_a_second_table_of_durations_is_passed_over(tmp_path):
    source = with_two_tables_of_durations(tmp_path / "in.mov")  # the index of which is at its end
    summary = vidstyle.render(source, tmp_path / "out.mp4", "plain")
    assert (summary.exit_code, summary.frames) == (4, FRAMES)


def test_a_header_for_which_ffmpeg_lacks_memory_is_the_fault_of_the_film(tmp_path):
    source = with_two_tables_of_durations(tmp_path / "in.mov")
    with source.open("rb") as file, pytest.raises(InputError, match="its header is damaged"):
        open_media(file)


@pytest.mark.parametrize("frame", [2, 20, FRAMES - 2])
@pytest.mark.parametrize("table", [b"stts", b"ctts"])
@pytest.mark.parametrize("seconds", [36, 12 * 3600])
def test_frames_that_a_damaged_time_hides_are_damage(tmp_path, frame, table, seconds):
    """The edit list ends before them, or begins behind them."""
    source = damaged(tmp_path / "in.mp4", table, {})
    content = bytearray(source.read_bytes())
    start = content.index(table) + 8
    entries = struct.unpack_from(">I", content, start)[0]
    place = start + 4 + 8 * (frame * entries // FRAMES) + 4
    struct.pack_into(">I", content, place, struct.unpack_from(">I", content, place)[0] + seconds * 15360)
    source.write_bytes(content)
    summary = vidstyle.render(source, tmp_path / "out.mp4", "plain")
    assert summary.exit_code == 4


def test_frames_that_an_edit_list_hides_are_no_damage(tmp_path):
    source, trimmed = make_clip(tmp_path / "whole.mp4", frames=FRAMES), tmp_path / "in.mp4"
    with (
        av.open(str(source)) as given,
        av.open(str(trimmed), "w", options={"avoid_negative_ts": "disabled"}) as made,
    ):
        stream = made.add_stream_from_template(given.streams.video[0])
        for packet in given.demux(video=0):
            if packet.size:
                early = 20 * 512
                packet.pts, packet.dts, packet.stream = packet.pts - early, packet.dts - early, stream
                made.mux(packet)
    summary = vidstyle.render(trimmed, tmp_path / "out.mp4", "plain")
    assert (summary.exit_code, summary.frames) == (0, FRAMES - 20)


def test_good_files_have_no_corrections(tmp_path):
    for name in ("a.mp4", "a.mov", "a.mkv"):
        path = make_clip(tmp_path / name, frames=10, audio_tracks=1)
        assert not find_corrections(path) and has_one_edit(path)
    empty = tmp_path / "empty.mp4"
    empty.write_bytes(struct.pack(">I4s", 0, b"ftyp") + struct.pack(">I4s", 8, b"moov") * 3)
    assert not find_corrections(empty)
