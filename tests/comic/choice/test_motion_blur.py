"""Motion blur is predicted from the flow of the part that counts; corners of blocks tell damage."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph
from stories import small_luma, write_film

from vidstyle.comic.analyze.features import Candidate, Foreground, Survey, extract_features
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.flaws.defect_limits import DefectLimits
from vidstyle.comic.analyze.flaws.defects import Blockiness, count_block_corners
from vidstyle.comic.analyze.flaws.motion_blur import FlowMeter, mark_fast_faces, region_flow, subject_flow
from vidstyle.comic.analyze.flaws.refused import describe_lack, describe_refused
from vidstyle.comic.select.choose import choose
from vidstyle.regions.boxes import Box

STILL = cv2.resize(photograph("chelsea"), (640, 360))


def moved(pixels: int) -> np.ndarray:
    return np.roll(STILL, pixels, axis=1)


def seen(flow: np.ndarray | None, **values: object) -> Candidate:
    found = extract_features(STILL, 1.0, STILL.shape[:2])
    return replace(found, flow=flow, **values)  # type: ignore[arg-type]


def flow_of(before: np.ndarray, after: np.ndarray, seconds: float = 1 / 24) -> np.ndarray | None:
    meter = FlowMeter()
    assert meter.push(0.0, small_luma(before), True) is None
    return meter.push(seconds, small_luma(after), True)


@pytest.mark.parametrize(("seconds", "flow"), [(1 / 24, 0.025), (1 / 60, 0.025), (1 / 10, 0.0104)])
def test_flow_is_relative_to_the_width_and_the_exposure(seconds: float, flow: float) -> None:
    assert region_flow(seen(flow_of(STILL, moved(16), seconds))) == pytest.approx(flow, rel=0.15)


def test_the_first_frame_of_a_shot_moves_as_the_second_does(tmp_path: Path) -> None:
    """Nothing precedes it, but a film may begin in the middle of a pan."""
    frames = [moved(24 * number) for number in range(8)]
    path = write_film(tmp_path / "film.mp4", frames)
    with open_film(path) as film:
        first, second = film.survey().candidates[:2]
    assert first.motion > 0.5 * second.motion > 0
    assert region_flow(first) > 0.02


def test_flow_of_a_region_is_its_own() -> None:
    """The left half moves; the right half is still, like the background of a runner."""
    after = np.hstack([moved(20)[:, :320], STILL[:, 320:]])
    left, right = Box(40, 60, 240, 300), Box(420, 60, 600, 300)
    found = seen(flow_of(STILL, after))
    assert region_flow(found, left) > 0.02 > 0.005 > region_flow(found, right)
    fast, slow = mark_fast_faces([replace(found, faces=(left,)), replace(found, faces=(right,))])
    assert fast.blurred and not slow.blurred


def test_a_fast_picture_is_blurred_unless_it_is_as_sharp_as_the_film() -> None:
    calm, fast = (seen(np.full((9, 16), flow, np.float32)) for flow in (0.001, 0.03))
    limits = DefectLimits.of([calm] * 5)
    softer = replace(fast, sharpness=0.9 * calm.sharpness)
    marked = [limits.mark(each).blurred for each in (calm, fast, softer)]
    assert marked == [False, False, True]


def test_unknown_flow_is_none() -> None:
    assert region_flow(seen(None)) == 0.0
    meter = FlowMeter()
    assert meter.push(0, np.zeros((2, 2), np.float32), True) is None
    assert meter.push(1, np.zeros((2, 2), np.float32), True) is None


def broken(color: np.ndarray, count: int) -> np.ndarray:
    """Blocks of a film, taken from elsewhere in it, as decoders show them after an error."""
    random, shown = np.random.default_rng(4), color.copy()
    for _ in range(count):
        rows, columns, other = random.integers(0, 20), random.integers(0, 38), random.integers(0, 38)
        block = color[16 * rows : 16 * rows + 16, 16 * other : 16 * other + 16]
        shown[16 * rows : 16 * rows + 16, 16 * columns : 16 * columns + 16] = block
    return shown


def test_corners_of_blocks_remain_in_a_scaled_and_encoded_film() -> None:
    counts = []
    for color in (STILL, broken(STILL, 120)):
        scaled = cv2.resize(color, (500, 282), interpolation=cv2.INTER_AREA)
        encoded = cv2.imdecode(cv2.imencode(".jpg", scaled, [cv2.IMWRITE_JPEG_QUALITY, 70])[1], 0)
        counts.append(count_block_corners(encoded))
    assert counts[0] <= 3 and counts[1] > 20


def test_damage_spreads_to_frames_nearby_in_the_scene_only() -> None:
    clear = [seen(None, time=float(time)) for time in range(6)]
    strong = seen(None, time=6.0, block_corners=40)
    limits = DefectLimits.of([*clear, strong])
    weak = replace(strong, block_corners=8)
    times = {time: limits.mark(replace(weak, time=time)).damaged for time in (5.0, 6.5)}
    assert limits.mark(strong).damaged and times == {5.0: False, 6.5: True}
    assert not limits.mark(replace(weak, scene=1)).damaged


def test_a_person_with_smeared_hands_before_a_still_camera_is_blurred() -> None:
    flow = np.full((9, 16), 0.001, np.float32)
    waving = flow.copy()
    waving[6:8, 6:10] = 0.02
    face = Box(300, 40, 360, 120)
    resting, smeared, empty = (
        seen(each, faces=faces) for each, faces in ((flow, (face,)), (waving, (face,)), (waving, ()))
    )
    assert [each.blurred for each in mark_fast_faces([resting, smeared, empty])] == [False, True, False]


def test_refused_frames_are_reported_with_their_first_reason() -> None:
    good, mixed = seen(None), seen(None, in_transition=True, blurred=True)
    broken = seen(None, damaged=True, in_transition=True)
    text = "3 of 4 frames were not used: 1 damaged, 2 in dissolves or fades"
    assert describe_refused([good, mixed, broken, mixed]) == text
    assert describe_refused([good]) == ""


def test_few_panels_are_explained_by_the_reason_that_holds() -> None:
    good, broken = seen(None), seen(None, damaged=True)
    again, later = replace(good, time=2.0), replace(good, time=3.0)
    other = extract_features(cv2.resize(photograph("coffee"), (640, 360)), 4.0, (360, 640))
    assert describe_lack([good, broken, broken], [1.2]) == "2 of its 3 frames were not used"
    assert describe_lack([good, broken], [1.2]) == "no other usable frame"
    assert describe_lack([good, again], [1.2]) == "its other frames show the same view"
    assert describe_lack([good, again, other], [1.2]) == "its other views were rated lower"
    most = "most of its other frames show the same view"
    assert describe_lack([good, again, later, other], [1.2]) == most
    assert describe_lack([good, again, other], [1.2, 4]) == "its other frames show the same views"


def test_flow_of_a_mover_is_measured_within_black_bars() -> None:
    """Its mask covers the picture, and the flow the whole frame."""
    places = np.zeros((32, 48), bool)
    places[4:12, 16:32] = True
    flow = np.full((9, 16), 0.001, np.float32)
    flow[3, 5:11] = 0.02
    action = Foreground(places, Box(0, 0, 1, 1), 1.0, 0.0, is_gone=False)
    barred = replace(seen(flow, action=action), shape=(180, 640), offset=(0, 90))
    assert subject_flow(barred) == pytest.approx(0.02)
    assert subject_flow(replace(barred, shape=(360, 640), offset=(0, 0))) == pytest.approx(0.001)


def test_damage_is_found_though_most_of_a_film_is_damaged() -> None:
    clean, broken = (seen(None, blockiness=Blockiness(value, 0.2)) for value in (0.15, 0.45))
    limits = DefectLimits.of([clean] * 3 + [broken] * 7)
    assert limits.mark(broken).broken and not limits.mark(clean).broken


@pytest.mark.parametrize(("corners", "is_broken"), [(18, False), (45, True)])
def test_a_scene_may_have_corners_of_its_own(corners: int, is_broken: bool) -> None:
    """Bricks and signs in each frame of a scene of a film without others; damage has more corners."""
    smooth = [seen(None, block_corners=1)] * 20
    brick = seen(None, scene=1, block_corners=corners)
    assert DefectLimits.of([*smooth, *[brick] * 9]).mark(brick).broken == is_broken


def test_a_person_whose_hands_rest_has_not_left() -> None:
    """Before a still camera only the hands move: without them, the picture is like its background."""
    still = Foreground(np.zeros((32, 48), bool), Box(0, 0, 640, 360), 0.0, 0.0, is_gone=True)
    waving = still._replace(places=np.ones((32, 48), bool), share=1.0, is_gone=False)
    person, hands, empty = (
        seen(None, time=time, action=action, faces=faces)
        for time, action, faces in ((0, still, (Box(300, 40, 360, 120),)), (4, waving, ()), (8, still, ()))
    )
    shown = choose(Survey([person, hands, empty], [0.0], 9.0), [], 2)
    assert [each.time for each in shown] == [0, 4]
