"""Shot detection: cuts and dissolves are found, flashes and pans are not."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest
from stories import PLACES, RATE, Place, add_flash, dissolve, make_whip_pan, shot, small_luma, view

from vidstyle.comic.analyze.picture_contrast import color_histogram
from vidstyle.comic.analyze.shots import KeyShots, ShotFinder

CUT_TOLERANCE_SECONDS, DISSOLVE_TOLERANCE_SECONDS = 0.06, 0.25
"""Tolerance for a cut, and for the middle of a dissolve in addition to half its length."""


def finder_of(frames: list[np.ndarray]) -> ShotFinder:
    finder = ShotFinder()
    for number, frame in enumerate(frames):
        finder.push(number / RATE, small_luma(frame))
    return finder


def joined(seed: int) -> tuple[list[np.ndarray], list[tuple[float, float]]]:
    """Return noisy frames of eight shots, and start and half the dissolve of each but the first."""
    random = np.random.default_rng(seed)
    frames: list[np.ndarray] = []
    begins = []
    for number in random.permutation(len(PLACES))[:8]:
        new = eventful(PLACES[number], random)
        mixed = int(random.integers(8, 26)) if frames and random.random() < 0.5 else 0
        if frames:
            begins.append(((len(frames) - mixed / 2) / RATE, mixed / 2 / RATE))
        frames = dissolve(frames, new, mixed) if mixed else frames + new
    return [noisy(frame, random) for frame in frames], begins


def eventful(place: Place, random: np.random.Generator) -> list[np.ndarray]:
    """Return a shot with a flash, with a whip pan, or with neither."""
    length = int(random.integers(56, 90))
    event = random.integers(4)
    if event == 0:
        return make_whip_pan(place, length, float(random.choice([-220, 220])))
    frames = shot(place, length, float(random.uniform(-1.5, 1.5)))
    return add_flash(frames, length // 2) if event == 1 else frames


def noisy(frame: np.ndarray, random: np.random.Generator) -> np.ndarray:
    return cv2.add(frame, 2 * random.standard_normal(frame.shape, np.float32), dtype=cv2.CV_8U)


@pytest.mark.parametrize("seeds", [[0], pytest.param(range(8), marks=pytest.mark.thorough)], ids=len)
def test_joined_shots_are_distinguished(seeds: Sequence[int]) -> None:
    found = missed = wrong = 0
    for seed in seeds:
        frames, begins = joined(seed)
        shots = finder_of(frames).shots()[1:]
        for time, half in begins:
            hits = [
                each
                for each in shots
                if abs(each - time) <= (half + DISSOLVE_TOLERANCE_SECONDS if half else CUT_TOLERANCE_SECONDS)
            ]
            found, missed = found + bool(hits), missed + (not hits)
            shots = [each for each in shots if each not in hits[:1]]
        wrong += len(shots)
    assert found + missed == 7 * len(seeds)
    assert found / (found + missed) >= 0.95
    assert found / (found + wrong) >= 0.95


@pytest.mark.parametrize("frames", [10, 16, 24])
def test_only_pictures_in_or_near_a_dissolve_are_in_transition(frames: int) -> None:
    finder = finder_of(dissolve(shot(PLACES[0], 60), shot(PLACES[1], 60), frames))
    begin, middle, end = (60 - frames) / RATE, (60 - frames / 2) / RATE, 60 / RATE
    assert finder.shots() == pytest.approx([0, middle], abs=frames / 2 / RATE)
    assert finder.is_transition(middle)
    assert not any(finder.is_transition(time) for time in (0, begin - 0.6, end + 0.6))


def test_a_fade_to_black_is_a_transition() -> None:
    frames = [*shot(PLACES[0], 50), *([view(PLACES[0])] * 25), *[np.zeros_like(view(PLACES[0]))] * 50]
    faded = [
        np.rint(frame * np.clip((75 - number) / 25, 0, 1)).astype(np.uint8)
        for number, frame in enumerate(frames)
    ]
    finder = finder_of(faded)
    assert finder.is_transition(62 / RATE)
    assert not finder.is_transition(40 / RATE)


def test_motion_is_independent_of_the_frame_rate() -> None:
    """The same pan filmed at twice the rate has the same motion."""
    quick, slow = (
        [small_luma(view(PLACES[2], 4 * number / step)) for number in range(8 * step)] for step in (1, 2)
    )
    one, other = ShotFinder(), ShotFinder()
    first = [one.push(number / 24, frame) for number, frame in enumerate(quick)]
    second = [other.push(number / 48, frame) for number, frame in enumerate(slow)]
    assert first[0] == second[0] == 0
    assert np.mean(first[1:]) == pytest.approx(np.mean(second[1:]), rel=0.15)
    still = ShotFinder()
    assert [still.push(number / 24, quick[0]) for number in range(3)] == [0, 0, 0]


def test_key_frames_of_one_place_are_one_scene() -> None:
    keys = KeyShots()
    for number in range(6):
        place = PLACES[0] if number < 3 else PLACES[6]
        frame = view(place, 30 * number)
        keys.push(5.0 * number, small_luma(frame), color_histogram(frame))
    assert keys.scene_starts == [0, 15]


def test_motion_is_measured_if_each_frame_comes_twice() -> None:
    """As in films with a raised frame rate; after a cut, and in a still, the motion is 0."""
    moving = shot(PLACES[0], 12, 3)
    twice = [frame for frame in moving for _ in range(2)]
    finder = ShotFinder()
    film = [*twice, *[view(PLACES[1])] * 6]
    moved = [finder.push(number / RATE, small_luma(frame)) for number, frame in enumerate(film)]
    assert min(moved[2 : len(twice)]) > 0.01
    assert moved[len(twice) :] == [0.0] * 6


@pytest.mark.parametrize("speed", [0.0, 6.0], ids=["still", "fast"])
def test_a_dissolve_into_a_shot_that_is_cut_at_once_is_a_transition(speed: float) -> None:
    second = [*shot(PLACES[1], 10, speed), *shot(PLACES[2], 50, speed)]
    finder = finder_of(dissolve(shot(PLACES[0], 60), second, 20))
    assert all(finder.is_transition(number / RATE) for number in range(43, 58))
    assert not any(finder.is_transition(number / RATE) for number in (20, 80))
