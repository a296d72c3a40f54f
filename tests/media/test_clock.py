"""Repair of timestamps: none missing, repeated or decreasing, and no more changed than necessary."""

from __future__ import annotations

import itertools
from fractions import Fraction

import av
import media
import numpy as np
import pytest

from vidstyle.core.picture import Picture
from vidstyle.media.frame import Frame
from vidstyle.media.read.clock import ConstantRate, FrameClock, fine_time_base
from vidstyle.media.read.packet_clock import PacketClock
from vidstyle.media.read.reader import open_reader


def stamps(clock: FrameClock, given: list[int | None]) -> list[int]:
    """Return the timestamps after the clock; frames must keep their order."""
    natives = [av.VideoFrame(16, 16, "gray") for _ in given]
    shown = []
    for native, pts in zip(natives, given, strict=True):
        clock.push(native, pts)
        shown += clock.pull()
    shown += clock.pull(flush=True)
    assert all(frame.native is native for frame, native in zip(shown, natives, strict=True))
    return [frame.pts for frame in shown]


def test_good_stamps_stay(caplog):
    clock = FrameClock(Fraction(1, 90000), Fraction(30))
    assert stamps(clock, [7, 3010, 6000, 180_000]) == [7, 3010, 6000, 180_000]
    assert not caplog.text


def test_stamps_that_do_not_grow_are_nudged_by_a_tick(caplog):
    clock = FrameClock(Fraction(1, 90000), Fraction(30))
    assert stamps(clock, [0, 3000, 3000, 2990, 9000]) == [0, 3000, 3001, 3002, 9000]
    assert clock.shifted == 2 and len(caplog.records) == 1


def test_a_coarse_time_base_is_divided_so_that_a_nudge_is_not_seen():
    clock = FrameClock(Fraction(1, 25), Fraction(25))
    assert clock.time_base == Fraction(1, 12800)
    assert stamps(clock, [0, 1, 1, 2]) == [0, 512, 513, 1024]
    assert fine_time_base(Fraction(1, 1000)) == Fraction(1, 1000)
    largest = Fraction(2**31 - 1, 2**31 - 2)
    assert fine_time_base(largest) == largest, "as far as FFmpeg's integers reach"


def test_swapped_stamps_are_sorted_where_no_display_times_are_stored():
    clock = FrameClock(Fraction(1, 1000), Fraction(25), window=2)
    assert stamps(clock, [0, 80, 40, 120, 160]) == [0, 40, 80, 120, 160]


def test_missing_stamps_follow_from_the_rate(caplog):
    clock = FrameClock(Fraction(1, 1200000), Fraction(24000, 1001))
    assert stamps(clock, [None] * 4) == [0, 50050, 100100, 150150]
    assert "no timestamps" in caplog.text


def packet(stamp: int, stream_index: int = 0) -> av.Packet:
    made = av.Packet(b"x")
    made.pts = made.dts = stamp
    made.time_base = Fraction(1, 90000)
    made.duration = 3000
    return made


def restamped(clock: PacketClock, given: list[int]) -> list[int]:
    packets = [packet(stamp) for stamp in given]
    for one in packets:
        clock.restamp(one)
    return [one.pts for one in packets]


def test_a_shift_moves_every_packet():
    assert restamped(PacketClock(Fraction(14, 10), True), [126000, 129000]) == [0, 3000]


def test_a_clock_that_starts_again_is_bridged(caplog):
    clock = PacketClock(Fraction(0), broadcast=False)
    assert restamped(clock, [900_000, 903_000, 0, 3000]) == [900_000, 903_000, 906_000, 909_000]
    assert caplog.text.count("bridged") == 1


def test_a_leap_is_a_jump_in_broadcasts_and_a_gap_elsewhere():
    leap = [0, 3000, 90_000_000]
    assert restamped(PacketClock(Fraction(0), broadcast=True), leap) == [0, 3000, 6000]
    assert restamped(PacketClock(Fraction(0), broadcast=False), leap) == leap


@pytest.mark.parametrize("container", ["avi", "mkv"])
def test_b_frames_in_a_container_without_display_times(tmp_path, container):
    path = media.make_clip(
        tmp_path / f"clip.{container}", frames=20, codec="mpeg4", options={"bf": "2", "qscale": "3"}
    )
    with open_reader(path) as reader:
        frames = [item for item in reader if isinstance(item, Frame)]
    assert len(frames) == 20
    steps = [after.time - before.time for before, after in zip(frames, frames[1:], strict=False)]
    assert all(abs(step - Fraction(1, 30)) < Fraction(2, 1000) for step in steps)


@pytest.mark.parametrize(
    ("duration", "count"), [(None, 3), (0, 3), (100, 3), (140, 3), (160, 4), (300, 5)], ids=str
)
def test_the_last_frame_is_repeated_for_its_duration_at_a_constant_rate(
    duration: int | None, count: int
) -> None:
    """At 10 frames per second; an unknown duration is one interval."""
    rate = ConstantRate(Fraction(10))
    picture = Picture.from_array(np.zeros((2, 2, 3), np.uint8))
    frames = [Frame(picture, pts, Fraction(1, 1000), duration) for pts in (0, 100, 200)]
    made = [each for frame in frames for each in rate.push(frame)]
    made += itertools.islice(rate.flush(), 10)
    assert [each.time for each in made] == [Fraction(number, 10) for number in range(count)]
