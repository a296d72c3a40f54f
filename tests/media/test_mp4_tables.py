"""MP4 files whose index is damaged: what can be decoded is, and the damage is reported."""

from __future__ import annotations

import struct
from fractions import Fraction
from pathlib import Path

import av
import pytest
from media import make_clip, read_all

import vidstyle
from vidstyle.media.read.mp4_tables import cut_counts, has_one_edit

FRAMES = 60
TIMES = [Fraction(number, 30) + Fraction(number % 3, 200) for number in range(FRAMES)]
"""Uneven, so that each frame has entries of its own in the tables of times."""


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
    assert summary.exit_code == 4 and "its index cannot be right" in summary.damage
    assert summary.frames == len(read_all(target)) >= FRAMES - 1


@pytest.mark.parametrize("duration", [2**31 - 1, 2**30])
def test_a_frame_of_hours_is_no_reason_to_fail(tmp_path, duration):
    source, target = damaged(tmp_path / "in.mp4", b"stts", {12: duration}), tmp_path / "out.mp4"
    summary = vidstyle.render(source, target, "plain")
    assert summary.exit_code == 4 and "its clock leaps" in summary.damage
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


def test_good_files_have_no_corrections(tmp_path):
    for name in ("a.mp4", "a.mov", "a.mkv"):
        path = make_clip(tmp_path / name, frames=10, audio_tracks=1)
        assert not cut_counts(path) and has_one_edit(path)
    empty = tmp_path / "empty.mp4"
    empty.write_bytes(struct.pack(">I4s", 0, b"ftyp") + struct.pack(">I4s", 8, b"moov") * 3)
    assert not cut_counts(empty)
