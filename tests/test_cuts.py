"""Cuts: a new scene is found, movement, noise, flashes of a lamp's size and fades are not taken for one."""

from __future__ import annotations

import numpy as np
import pytest
from media import moving_frames, photograph
from pictures import noise

from vidstyle.cuts import CutDetector


def small(name: str) -> np.ndarray:
    return photograph(name)[::4, ::4, 1][:64, :96].astype(np.float32) / 255


def test_the_first_frame_begins_a_scene_and_the_same_again_does_not() -> None:
    detector = CutDetector()
    assert [detector.is_cut(small("astronaut")) for _ in range(3)] == [True, False, False]


@pytest.mark.parametrize("pair", [("astronaut", "rocket"), ("rocket", "coffee"), ("coffee", "chelsea")])
def test_another_picture_is_a_cut(pair: tuple[str, str]) -> None:
    detector = CutDetector()
    cuts = [detector.is_cut(small(name)) for name in (pair[0], pair[0], pair[1], pair[1], pair[0])]
    assert cuts == [True, False, True, False, True]


def test_another_size_is_a_cut() -> None:
    detector = CutDetector()
    detector.is_cut(small("coffee"))
    assert detector.is_cut(small("coffee")[:32])


def test_movement_is_no_cut() -> None:
    detector = CutDetector()
    frames = [frame[..., 1].astype(np.float32) / 255 for frame in moving_frames(40, (160, 90))]
    assert [detector.is_cut(frame) for frame in frames] == [True] + [False] * 39


def test_noise_is_no_cut() -> None:
    detector = CutDetector()
    still = small("astronaut")
    frames = [still + 0.08 * (noise(*still.shape, seed=seed) - 0.5) for seed in range(10)]
    assert not any([detector.is_cut(frame) for frame in frames][1:])


def test_a_fade_is_no_cut() -> None:
    """To black in one second, at 25 frames a second."""
    detector = CutDetector()
    cuts = [detector.is_cut(small("astronaut") * (1 - number / 25)) for number in range(26)]
    assert not any(cuts[1:])


def test_a_buffer_that_is_used_again_does_not_hide_a_cut() -> None:
    detector = CutDetector()
    buffer = small("astronaut").copy()
    detector.is_cut(buffer)
    buffer[:] = small("rocket")
    assert detector.is_cut(buffer)
