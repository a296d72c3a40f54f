"""Frames that lost detail, subjects that rest in most frames, and noise of compression in small sources."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.analyze.edges import edge_width_sharpness, measure_slopes
from vidstyle.comic.analyze.features import extract_features
from vidstyle.comic.analyze.flaws.defect_limits import DefectLimits
from vidstyle.comic.analyze.moving.action import add_actions
from vidstyle.comic.analyze.sharpness import measure_resolution
from vidstyle.comic.output.compression_noise import smooth_compression_noise
from vidstyle.comic.output.panel_renderer import cut_out
from vidstyle.regions.boxes import Box

SHARP = cv2.resize(photograph("chelsea"), (640, 360))


def smeared(across: int, down: int) -> np.ndarray:
    return cv2.blur(SHARP, (across, down))


@pytest.mark.parametrize("blurred", [smeared(15, 1), smeared(1, 15), smeared(7, 7)])
@pytest.mark.parametrize("scene", [0, 1])
def test_a_frame_without_the_detail_of_its_neighbours_is_blurred(blurred: np.ndarray, scene: int) -> None:
    """Also in front of a still camera, and if the sudden blur looked like a cut."""
    sharp = [extract_features(SHARP, time, (360, 640)) for time in (0.0, 0.25, 0.5, 0.75)]
    soft = replace(extract_features(blurred, 1.0, (360, 640)), scene=scene)
    limits = DefectLimits.of([*sharp, soft])
    assert [limits.mark(each).blurred for each in (*sharp, soft)] == [False] * 4 + [True]


def test_other_content_is_not_blurred() -> None:
    frames = [extract_features(SHARP, time, (360, 640)) for time in (0.0, 0.25, 0.5)]
    calm = extract_features(cv2.resize(photograph("rocket"), (640, 360)), 0.75, (360, 640))
    assert not DefectLimits.of([*frames, calm]).mark(replace(calm, scene=1)).blurred


def test_a_subject_may_sway_where_it_rests() -> None:
    """What changes next to it does not hide that the pictures without it are the empty ones."""
    wall = cv2.resize(photograph("rocket"), (320, 240)) // 4 + 120
    pictures = [wall] * 6
    for step in range(14):
        person = wall.copy()
        cv2.ellipse(person, (160 + (13, 0)[step % 5 > 1], 130), (26, 70), 0, 0, 360, (20, 15, 30), -1)
        pictures.append(person)
    shot = [extract_features(each, time, (240, 320)) for time, each in enumerate(pictures)]
    actions = [each.action for each in add_actions(shot, shot)]
    assert [action is not None and not action.is_gone for action in actions] == [False] * 6 + [True] * 14


@pytest.mark.parametrize("empty", [3, 7])
def test_a_subject_may_rest_in_most_frames_of_its_shot(empty: int) -> None:
    wall = cv2.resize(photograph("rocket"), (320, 240)) // 4 + 120
    person = wall.copy()
    cv2.ellipse(person, (160, 130), (26, 70), 0, 0, 360, (20, 15, 30), -1)
    pictures = [wall] * empty + [person] * (10 - empty)
    shot = [extract_features(each, time, (240, 320)) for time, each in enumerate(pictures)]
    actions = [each.action for each in add_actions(shot, shot)]
    assert [action is not None and not action.is_gone for action in actions] == [
        time >= empty for time in range(10)
    ]


def test_faint_squares_vanish_and_edges_stay() -> None:
    squares = np.kron(np.indices((12, 16)).sum(axis=0) % 2, np.ones((16, 16), int))[..., np.newaxis]
    picture = (np.full((192, 256, 3), 120) + 6 * squares - 3).astype(np.uint8)
    picture[:, 128:] += 80
    smooth = smooth_compression_noise(picture).astype(int)
    assert smooth[:, :100].std() < 0.5 * picture[:, :100].std()
    assert (smooth[:, 132] - smooth[:, 123]).mean() > 70


def test_small_and_blurred_pictures_have_less_resolution() -> None:
    """A soft background does not hide a sharp subject."""
    large = cv2.cvtColor(SHARP, cv2.COLOR_RGB2GRAY)
    small = cv2.resize(large, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(large, (0, 0), 5)
    focused = blurred.copy()
    focused[120:240, 200:440] = large[120:240, 200:440]
    few, many, soft, subject = map(measure_resolution, (small, large, blurred, focused))
    assert max(few, soft) < 0.7 * many
    assert 1.1 * soft < subject < many


@pytest.mark.parametrize("shape", [(1, 1), (1, 700), (48, 3)])
def test_small_and_narrow_pictures_have_a_resolution(shape: tuple[int, int]) -> None:
    assert np.isfinite(measure_resolution(np.full(shape, 128, np.uint8)))


def test_an_enlarged_picture_has_steeper_edges_and_no_rims() -> None:
    picture = np.full((60, 80, 3), 60, np.uint8)
    picture[:, 40:] = 180
    soft, sharp = (
        cut_out(picture, Box(0, 0, 80, 60), 320, 240, is_cleaned=each).astype(int) for each in (False, True)
    )
    assert np.diff(sharp[120, :, 0]).max() > 1.3 * np.diff(soft[120, :, 0]).max()
    assert soft.min() - 8 <= sharp.min() and sharp.max() <= soft.max() + 8
    same = cut_out(picture, Box(0, 0, 80, 60), 80, 60, is_cleaned=True)
    assert np.array_equal(same, picture)


def sparse(places: slice) -> np.ndarray:
    """Slopes of 0 except at these places of the flattened picture."""
    slopes = np.zeros(200 * 300, np.float32)
    slopes[places] = np.arange(len(slopes[places])) % 97 + 1
    return slopes.reshape(200, 300)


@pytest.mark.parametrize(
    "wide",
    [
        measure_slopes(cv2.cvtColor(SHARP, cv2.COLOR_RGB2GRAY), 2.5)[0],
        np.full((40, 60), 3, np.float32),
        np.arange(6, dtype=np.float32),
        *(sparse(slice(first, None, 13)) for first in (0, 1)),
    ],
)
def test_sharpness_is_measured_at_the_steepest_edges_and_all_that_equal_them(wide: np.ndarray) -> None:
    thin = wide.ravel() * np.random.default_rng(1).uniform(1, 3, wide.size).astype(np.float32)
    number = max(1, round(0.03 * wide.size))
    steepest = wide.ravel() >= np.sort(wide, axis=None)[-number]
    ratio = float(thin[steepest].mean()) / float(wide.ravel()[steepest].mean())
    found = edge_width_sharpness([thin.reshape(wide.shape)], [wide])
    assert found == float(np.clip((ratio - 1) / (2.5 / 0.7 - 1), 0, 1))
