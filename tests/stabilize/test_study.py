"""The study of stabilization: figures of films with known values, and of a style."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import make_clip, photograph
from pictures import step, style

from tools.steadiness import Figures, Study, difference, flicker, ghosts, mean_error
from tools.steadiness.clips import Clip, motions_of, moving_disc, read_clip, still_scene
from tools.steadiness.following import correlations, followed, ways_of
from tools.steadiness.table import SOURCE, markdown, markdown_of_following
from tools.steadiness.warping import Motion, find_motion, seen_in_both, warping_error
from vidstyle.errors import InputError

SMALL = cv2.resize(photograph("coffee"), (160, 90), interpolation=cv2.INTER_AREA)


def constant(flow: tuple[float, float], shape: tuple[int, int] = (90, 160)) -> np.ndarray:
    """Uniform flow, to the right and down."""
    return np.tile(np.array(flow, np.float32), (*shape, 1))


def moved(right: int, down: int) -> tuple[np.ndarray, np.ndarray]:
    """Two views of a photograph, the second moved to the right and down by these pixels."""
    still = photograph("astronaut")
    first, second = still[100:190, 150:310], still[100 - down : 190 - down, 150 - right : 310 - right]
    return np.ascontiguousarray(first), np.ascontiguousarray(second)


@pytest.mark.parametrize("way", [(5, 3), (-4, 7), (0, 0)])
def test_pure_motion_has_no_error(way: tuple[int, int]) -> None:
    first, second = moved(*way)
    forward, backward = constant(way), constant((-way[0], -way[1]))
    motion = Motion(forward, seen_in_both(forward, backward))
    assert motion.seen.sum() == (160 - abs(way[0])) * (90 - abs(way[1]))
    assert warping_error(first, second, motion) == 0
    if way != (0, 0):
        assert warping_error(first, second, Motion(backward, motion.seen)) > 0.01


def test_error_is_mean_square_of_visible_pixels() -> None:
    first = np.full((90, 160, 3), 100, np.uint8)
    second = first + np.array([10, 20, 0], np.uint8)
    second[:, 80:] = 255
    seen = np.zeros((90, 160), bool)
    seen[:, :80] = True
    error = warping_error(first, second, Motion(constant((0, 0)), seen))
    assert error == pytest.approx((10**2 + 20**2) / 3 / 255**2)
    assert math.isnan(warping_error(first, second, Motion(constant((0, 0)), ~seen & seen)))


def test_covered_pixels_and_motion_borders_are_excluded() -> None:
    """A square moves 8 pixels to the right over a background at rest."""
    forward, backward = constant((0, 0)), constant((0, 0))
    forward[30:60, 40:70] = 8, 0
    backward[30:60, 48:78] = -8, 0
    seen = seen_in_both(forward, backward)
    assert not seen[30:60, 70:78].any(), "covered by the square"
    assert not seen[29, 40:70].any() and not seen[30:60, 39].any() and not seen[59, 40:70].any()
    assert seen[31:58, 41:68].all(), "the square itself"
    assert seen[:28].all() and seen[62:].all() and seen[:, 80:].all() and seen[:, :38].all()


@pytest.mark.parametrize(
    ("way", "stray", "seen"), [(0, 0.70, True), (0, 0.72, False), (10, 1.4, True), (10, 1.55, False)]
)
def test_flows_may_differ_within_defined_tolerance(way: int, stray: float, seen: bool) -> None:
    """|v + w|^2 > 0.01 (|v|^2 + |w|^2) + 0.5: 0.711 pixels where w = 0, 1.49 where w = 10."""
    back = constant((stray - way, 0))
    assert seen_in_both(constant((way, 0)), back)[:, :150].all() == seen


def test_borders_of_motion_are_as_defined() -> None:
    """With w = 0.05 x: 0.0025 > 0.01 (0.05 x)^2 + 0.002 left of the 4.47th column."""
    forward, backward = constant((0, 0)), constant((0, 0))
    forward[..., 0] = 0.05 * np.arange(160)
    backward[..., 0] = -0.05 / 1.05 * np.arange(160)
    seen = seen_in_both(forward, backward)
    assert not seen[:, :5].any()
    assert seen[:, 5:150].all()


def test_motion_is_found() -> None:
    first, second = moved(3, -2)
    motion = find_motion(first, second)
    np.testing.assert_allclose(np.median(motion.flow, axis=(0, 1)), (3, -2), atol=0.1)
    assert motion.seen.mean() > 0.7
    assert warping_error(first, second, motion) < 0.05 * warping_error(
        first, second, Motion(constant((0, 0)), motion.seen)
    )


def test_mean_over_films_averages_means_and_excludes_cuts() -> None:
    levels = [[0, 51, 0], [0, 0, 255, 255, 255]]
    films = [[np.full((90, 160, 3), level, np.uint8) for level in film] for film in levels]
    at_rest = Motion(constant((0, 0)), np.ones((90, 160), bool))
    unseen = Motion(constant((0, 0)), np.zeros((90, 160), bool))
    assert mean_error([(films[0], [at_rest] * 2)]) == pytest.approx(0.04)
    assert mean_error([(films[0], [at_rest] * 2), (films[1], [at_rest] * 4)]) == pytest.approx(0.145)
    assert mean_error(
        [(films[0], [at_rest] * 2), (films[1], [at_rest, None, at_rest, unseen])]
    ) == pytest.approx(0.02)
    assert math.isnan(mean_error([(films[0], [None, None])]))


@pytest.mark.parametrize("noise", [2, 4, 9])
def test_flicker_of_noise_matches_theory(noise: float) -> None:
    """The mean difference of two normal numbers is 2 sigma / sqrt(pi); rounding adds 1/12 to the variance."""
    gray = np.full((90, 160, 3), 128, np.uint8)
    clip = still_scene(gray, 12, noise)
    assert flicker(clip.frames) == pytest.approx(
        2 * math.sqrt(noise**2 + 1 / 12) / math.sqrt(math.pi), rel=0.01
    )
    assert np.mean(clip.frames) == pytest.approx(128, abs=0.1)
    assert clip.times[:3] == [0, 0.04, 0.08]
    np.testing.assert_array_equal(clip.frames[5], still_scene(gray, 12, noise).frames[5])


def test_the_disc_moves_over_a_background_at_rest() -> None:
    clip, edges = moving_disc(SMALL, 8)
    for first, second, edge in zip(clip.frames, clip.frames[1:], edges, strict=False):
        changed = (first != second).any(axis=2)
        assert changed.any()
        np.testing.assert_array_equal(first[34:56, 69:80], second[34:56, 72:83])
        assert not (changed & ~edge)[:20].any()
    places = [np.nonzero(edge[45])[0] for edge in edges]
    np.testing.assert_array_equal(places[5] - places[2], 9)


def test_ghosts_count_as_smear() -> None:
    clip, edges = moving_disc(SMALL, 12)
    lighter = [np.minimum(frame, 254) + np.uint8(1) for frame in clip.frames]
    assert difference(clip.frames, clip.frames, edges) == 0
    assert difference(lighter, clip.frames, edges) <= 1
    assert difference(list(ghosts(clip.frames)), clip.frames, edges) > 10


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
    frames = [moved(0, 0)[0], moved(2, 0)[1], SMALL, SMALL]
    motions = motions_of(Clip(frames, [0.0, 0.1, 0.2, 0.3]))
    assert [motion is None for motion in motions] == [False, True, False]


FLAT = style(step("posterize", levels=4))


def test_style_is_compared_with_films() -> None:
    first, second = moved(3, -2)
    study = Study(SMALL, [Clip([first, second], [0.0, 0.04])])
    assert study.untouched.still == pytest.approx(4.5, abs=0.15)
    loose, steady = study.measure(FLAT, [0, 0.5])
    assert loose.smear == 0
    assert steady.smear < loose.ghost
    assert loose.ghost == steady.ghost > 10
    assert loose.still > 1
    assert loose.ratio == pytest.approx(loose.warping / study.untouched.warping)
    assert loose.ratio > 2, "edges of posterized tones are hard"
    (alone,) = study.measure(replace(FLAT, steady=0.5), [0])
    assert alone == loose, "the style's own steadiness is not what is measured"
    assert steady.still <= loose.still
    (same,) = study.measure(style(), [0])
    assert same == study.untouched


def test_styles_see_the_times_of_the_frames() -> None:
    """A measured block has adapted after a long time."""
    frames = [SMALL, SMALL // 2 + 20]
    settling = style(step("equalize", settle=0.5))
    soon, late = (
        next(Study(SMALL, [Clip(frames, [0.0, time])]).measure(settling, [0])) for time in (0.04, 5.0)
    )
    assert late.warping < 0.5 * soon.warping


def test_the_table_names_styles_and_has_a_row_of_the_films() -> None:
    figures = {"ink": [Figures(4, 0.002, 3, 1, 0, 30), Figures(1.25, 0.001, 1.5, 0.5, 2, 30)]}
    untouched = Figures(4.5, float("nan"), 1, 0.25, 0, 20)
    lines = markdown(figures, [0, 0.5], untouched, "2 clips").splitlines()
    assert lines[0].startswith("| style | still, 0 | still, 0.5 | warping error, 0 |")
    assert lines[2] == "| ink | 4.00 | 1.25 | 2.00 | 1.00 | 3.00 | 1.50 | 1.00 | 0.50 | 0.00 | 2.00 | 30.0 |"
    assert lines[3] == f"| {SOURCE} | 4.50 | 4.50 | - | - | 1.00 | 1.00 | 0.25 | 0.25 | 0.00 | 0.00 | 20.0 |"
    assert all(line.count("|") == 13 for line in lines[:4])
    assert "2 clips" in "".join(lines[4:])


def test_marks_stay_fixed_or_follow_motion() -> None:
    """A view that moves by 3 pixels per frame, and one that stays fixed over a moving film."""
    views = [moved(3 * number, 0)[1] for number in range(3)]
    ways = ways_of(views)
    assert [way.first for way in ways] == [0]
    page, along = followed(views, ways)
    assert along > 0.9 > 0.4 > page
    page, along = followed([views[0]] * 3, ways)
    assert page == pytest.approx(1) and along < 0.4
    assert ways_of([views[0]] * 3) == [], "nothing moves"
    (still,) = correlations([], Clip([views[0]] * 3, [0.0, 0.1, 0.2]), "cpu")
    assert np.isnan(still).all()
    restyled, source = correlations([style()], Clip(views, [0.0, 0.1, 0.2]), "cpu")
    assert restyled == source == followed(views, ways)
    assert markdown_of_following(["ink"], ["walk"], [[(0.25, 0.5), (0, 1)]]).splitlines()[2:] == [
        "| ink | 0.25 \\| 0.50 |",
        f"| {SOURCE} | 0.00 \\| 1.00 |",
    ]
