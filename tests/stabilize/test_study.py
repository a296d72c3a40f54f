"""Measurements of steadiness, of films with known values and of a style."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import make_clip, photograph
from pictures import step, style

from tools.steadiness import (
    Steadiness,
    Study,
    add_ghosts,
    mean_difference,
    mean_warping_error,
    measure_flicker,
)
from tools.steadiness.clips import Clip, find_motions, make_moving_disc, make_still_scene, read_clip
from tools.steadiness.mark_motion import compare_mark_motion, correlate_marks, find_moving_pairs
from tools.steadiness.table import SOURCE, format_mark_motion, format_steadiness
from tools.steadiness.warping import Motion, find_motion, find_visible_pixels, warping_error
from vidstyle.errors import InputError

SMALL = cv2.resize(photograph("coffee"), (160, 90), interpolation=cv2.INTER_AREA)


def constant_flow(flow: tuple[float, float], shape: tuple[int, int] = (90, 160)) -> np.ndarray:
    """Return the same flow at each pixel, to the right and down."""
    return np.tile(np.array(flow, np.float32), (*shape, 1))


def shifted_views(right: int, down: int) -> tuple[np.ndarray, np.ndarray]:
    """Return two crops of a photograph, 90 x 160; the second shows it shifted to the right and down."""
    still = photograph("astronaut")
    first, second = still[100:190, 150:310], still[100 - down : 190 - down, 150 - right : 310 - right]
    return np.ascontiguousarray(first), np.ascontiguousarray(second)


@pytest.mark.parametrize("motion_px", [(5, 3), (-4, 7), (0, 0)])
def test_pure_motion_has_no_error(motion_px: tuple[int, int]) -> None:
    first, second = shifted_views(*motion_px)
    forward, backward = constant_flow(motion_px), constant_flow((-motion_px[0], -motion_px[1]))
    motion = Motion(forward, find_visible_pixels(forward, backward))
    assert motion.visible.sum() == (160 - abs(motion_px[0])) * (90 - abs(motion_px[1]))
    assert warping_error(first, second, motion) == 0
    if motion_px != (0, 0):
        assert warping_error(first, second, Motion(backward, motion.visible)) > 0.01


def test_error_is_mean_square_of_visible_pixels() -> None:
    first = np.full((90, 160, 3), 100, np.uint8)
    second = first + np.array([10, 20, 0], np.uint8)
    second[:, 80:] = 255
    visible = np.zeros((90, 160), bool)
    visible[:, :80] = True
    error = warping_error(first, second, Motion(constant_flow((0, 0)), visible))
    assert error == pytest.approx((10**2 + 20**2) / 3 / 255**2)
    assert math.isnan(warping_error(first, second, Motion(constant_flow((0, 0)), ~visible & visible)))


def test_covered_pixels_and_motion_borders_are_excluded() -> None:
    """A square moves 8 pixels to the right over a still background."""
    forward, backward = constant_flow((0, 0)), constant_flow((0, 0))
    forward[30:60, 40:70] = 8, 0
    backward[30:60, 48:78] = -8, 0
    visible = find_visible_pixels(forward, backward)
    assert not visible[30:60, 70:78].any(), "covered by the square"
    assert not visible[29, 40:70].any() and not visible[30:60, 39].any() and not visible[59, 40:70].any()
    assert visible[31:58, 41:68].all(), "the square itself"
    assert visible[:28].all() and visible[62:].all() and visible[:, 80:].all() and visible[:, :38].all()


@pytest.mark.parametrize(
    ("motion_px", "stray", "visible"), [(0, 0.70, True), (0, 0.72, False), (10, 1.4, True), (10, 1.55, False)]
)
def test_flows_may_differ_within_defined_tolerance(motion_px: int, stray: float, visible: bool) -> None:
    """|v + w|^2 > 0.01 (|v|^2 + |w|^2) + 0.5: 0.711 pixels where w = 0, 1.49 where w = 10."""
    back = constant_flow((stray - motion_px, 0))
    assert find_visible_pixels(constant_flow((motion_px, 0)), back)[:, :150].all() == visible


def test_borders_of_motion_are_as_defined() -> None:
    """With w = 0.05 x: 0.0025 > 0.01 (0.05 x)^2 + 0.002 left of the 4.47th column."""
    forward, backward = constant_flow((0, 0)), constant_flow((0, 0))
    forward[..., 0] = 0.05 * np.arange(160)
    backward[..., 0] = -0.05 / 1.05 * np.arange(160)
    visible = find_visible_pixels(forward, backward)
    assert not visible[:, :5].any()
    assert visible[:, 5:150].all()


def test_motion_is_estimated() -> None:
    first, second = shifted_views(3, -2)
    motion = find_motion(first, second)
    np.testing.assert_allclose(np.median(motion.flow, axis=(0, 1)), (3, -2), atol=0.1)
    assert motion.visible.mean() > 0.7
    assert warping_error(first, second, motion) < 0.05 * warping_error(
        first, second, Motion(constant_flow((0, 0)), motion.visible)
    )


def test_mean_over_films_averages_means_and_excludes_cuts() -> None:
    levels = [[0, 51, 0], [0, 0, 255, 255, 255]]
    films = [[np.full((90, 160, 3), level, np.uint8) for level in film] for film in levels]
    at_rest = Motion(constant_flow((0, 0)), np.ones((90, 160), bool))
    invisible = Motion(constant_flow((0, 0)), np.zeros((90, 160), bool))
    assert mean_warping_error([(films[0], [at_rest] * 2)]) == pytest.approx(0.04)
    assert mean_warping_error([(films[0], [at_rest] * 2), (films[1], [at_rest] * 4)]) == pytest.approx(0.145)
    assert mean_warping_error(
        [(films[0], [at_rest] * 2), (films[1], [at_rest, None, at_rest, invisible])]
    ) == pytest.approx(0.02)
    assert math.isnan(mean_warping_error([(films[0], [None, None])]))


@pytest.mark.parametrize("noise", [2, 4, 9])
def test_flicker_of_noise_matches_theory(noise: float) -> None:
    """The mean difference of two normal numbers is 2 sigma / sqrt(pi); rounding adds 1/12 to the variance."""
    gray = np.full((90, 160, 3), 128, np.uint8)
    clip = make_still_scene(gray, 12, noise)
    assert measure_flicker(clip.frames) == pytest.approx(
        2 * math.sqrt(noise**2 + 1 / 12) / math.sqrt(math.pi), rel=0.01
    )
    assert np.mean(clip.frames) == pytest.approx(128, abs=0.1)
    assert clip.times[:3] == [0, 0.04, 0.08]
    np.testing.assert_array_equal(clip.frames[5], make_still_scene(gray, 12, noise).frames[5])


def test_disc_moves_over_still_background() -> None:
    clip, edges = make_moving_disc(SMALL, 8)
    for first, second, edge in zip(clip.frames, clip.frames[1:], edges, strict=False):
        changed = (first != second).any(axis=2)
        assert changed.any()
        np.testing.assert_array_equal(first[34:56, 69:80], second[34:56, 72:83])
        assert not (changed & ~edge)[:20].any()
    places = [np.nonzero(edge[45])[0] for edge in edges]
    np.testing.assert_array_equal(places[5] - places[2], 9)


def test_ghosts_count_as_smear() -> None:
    clip, edges = make_moving_disc(SMALL, 12)
    lighter = [np.minimum(frame, 254) + np.uint8(1) for frame in clip.frames]
    assert mean_difference(clip.frames, clip.frames, edges) == 0
    assert mean_difference(lighter, clip.frames, edges) <= 1
    assert mean_difference(list(add_ghosts(clip.frames)), clip.frames, edges) > 10


def test_frames_are_taken_from_middle_and_reduced(tmp_path: Path) -> None:
    film = make_clip(tmp_path / "film.mp4", size=(320, 180), frames=60)
    clip = read_clip(film, 6, 160)
    assert [frame.shape for frame in clip.frames] == [(90, 160, 3)] * 6
    assert clip.frames[0].dtype == np.uint8
    np.testing.assert_allclose(np.diff(clip.times), 1 / 30, atol=1e-4)
    whole = read_clip(film, 100, 320)
    assert len(whole.frames) == 60
    middle = [cv2.resize(frame, (160, 90), interpolation=cv2.INTER_AREA) for frame in whole.frames[27:33]]
    assert np.abs(np.int16(middle) - np.int16(clip.frames)).mean() < 1
    assert np.abs(np.int16(middle) - np.int16(clip.frames[::-1])).mean() > 1


def test_single_picture_is_refused_as_clip(tmp_path: Path) -> None:
    path = tmp_path / "still.png"
    cv2.imwrite(str(path), SMALL)
    with pytest.raises(InputError, match="is a single picture; give films"):
        read_clip(path, 6, 160)


def test_there_is_no_motion_across_a_cut() -> None:
    frames = [shifted_views(0, 0)[0], shifted_views(2, 0)[1], SMALL, SMALL]
    motions = find_motions(Clip(frames, [0.0, 0.1, 0.2, 0.3]))
    assert [motion is None for motion in motions] == [False, True, False]


POSTERIZED = style(step("posterize", levels=4))


def test_style_is_compared_with_source() -> None:
    first, second = shifted_views(3, -2)
    study = Study(SMALL, [Clip([first, second], [0.0, 0.04])])
    assert study.source.still == pytest.approx(4.5, abs=0.15)
    unsteady, steady = study.measure(POSTERIZED, [0, 0.5])
    assert unsteady.smear == 0
    assert steady.smear < unsteady.ghost
    assert unsteady.ghost == steady.ghost > 10
    assert unsteady.still > 1
    assert unsteady.ratio == pytest.approx(unsteady.warping / study.source.warping)
    assert unsteady.ratio > 2, "posterized tones have hard edges"
    (overridden,) = study.measure(replace(POSTERIZED, steady=0.5), [0])
    assert overridden == unsteady, "the value of `steady` in the style has no effect"
    assert steady.still <= unsteady.still
    (same,) = study.measure(style(), [0])
    assert same == study.source


def test_styles_receive_frame_times() -> None:
    """A block that measures has adapted after a long time."""
    frames = [SMALL, SMALL // 2 + 20]
    settling = style(step("equalize", settle=0.5))
    soon, late = (
        next(Study(SMALL, [Clip(frames, [0.0, time])]).measure(settling, [0])) for time in (0.04, 5.0)
    )
    assert late.warping < 0.5 * soon.warping


def test_table_has_rows_for_styles_and_source() -> None:
    measured = {"ink": [Steadiness(4, 0.002, 3, 1, 0, 30), Steadiness(1.25, 0.001, 1.5, 0.5, 2, 30)]}
    source = Steadiness(4.5, float("nan"), 1, 0.25, 0, 20)
    lines = format_steadiness(measured, [0, 0.5], source, "2 clips").splitlines()
    assert lines[0].startswith("| style | still scene at 0 | still scene at 0.5 | warping error at 0 |")
    assert lines[2] == "| ink | 4.00 | 1.25 | 2.00 | 1.00 | 3.00 | 1.50 | 1.00 | 0.50 | 0.00 | 2.00 | 30.0 |"
    assert lines[3] == f"| {SOURCE} | 4.50 | 4.50 | - | - | 1.00 | 1.00 | 0.25 | 0.25 | 0.00 | 0.00 | 20.0 |"
    assert all(line.count("|") == 13 for line in lines[:4])
    assert "2 clips" in "".join(lines[4:])


def test_marks_stay_fixed_or_follow_motion() -> None:
    """Compare a view that moves by 3 pixels per frame with a fixed view over a moving film."""
    views = [shifted_views(3 * number, 0)[1] for number in range(3)]
    pairs = find_moving_pairs(views)
    assert [pair.first for pair in pairs] == [0]
    page, along = correlate_marks(views, pairs)
    assert along > 0.9 > 0.4 > page
    page, along = correlate_marks([views[0]] * 3, pairs)
    assert page == pytest.approx(1) and along < 0.4
    assert find_moving_pairs([views[0]] * 3) == [], "nothing moves"
    (still,) = compare_mark_motion([], Clip([views[0]] * 3, [0.0, 0.1, 0.2]), "cpu")
    assert np.isnan(still).all()
    restyled, source = compare_mark_motion([style()], Clip(views, [0.0, 0.1, 0.2]), "cpu")
    assert restyled == source == correlate_marks(views, pairs)
    assert format_mark_motion(["ink"], ["walk"], [[(0.25, 0.5), (0, 1)]]).splitlines()[2:] == [
        "| ink | 0.25 \\| 0.50 |",
        f"| {SOURCE} | 0.00 \\| 1.00 |",
    ]
