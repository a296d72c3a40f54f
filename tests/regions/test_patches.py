"""Parts of the picture around faces: their masks, windows and edges."""

from __future__ import annotations

import numpy as np
import pytest
from focus import PLACE, below_white, focused_on, without
from pictures import picture_with_face

from vidstyle.core.picture import Encoding, Picture
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.masks import face_mask, inner_mask, mask_box
from vidstyle.regions.patch_blending import patch_mask
from vidstyle.regions.patches import (
    CHANGE_SECONDS,
    Patch,
    PatchPlanner,
    PatchSet,
    cut_patches,
    patches_shape,
    plane_area,
)
from vidstyle.renderer import stylize
from vidstyle.style import style_from_table

pytestmark = pytest.mark.usefixtures("faces_alone")


def test_masks_are_soft() -> None:
    box = mask_box(PLACE)
    mask = face_mask(PLACE, Box(280, 140, 380, 270))
    assert mask.dtype == np.float32 and mask.shape == (130, 100)
    assert mask.max() == 1 and mask[60, 52] == 1
    outside = np.ones_like(mask, bool)
    outside[int(box.top) - 140 : int(box.bottom) - 138, int(box.left) - 280 : int(box.right) - 278] = False
    assert not mask[outside].any()
    assert np.abs(np.diff(mask, axis=0)).max() < 0.2


def test_the_edge_of_a_mask_is_sharp_between_black_and_white() -> None:
    """There half of each would be gray. Where both are alike it is soft; where it is half, it stays half."""
    window = Box(280, 140, 380, 270)
    patch, differences = Patch(window, window, Face(0, PLACE)), (0.0, 1.0)
    soft, sharp = (
        patch_mask(patch, difference=np.full((130, 100), each, np.float32)) for each in differences
    )
    assert np.allclose(soft, patch_mask(patch), atol=1e-6)
    between = [np.count_nonzero((mask > 0.1) & (mask < 0.9)) for mask in (soft, sharp)]
    assert 4 * between[1] < between[0]
    assert np.array_equal(soft > 0.5, sharp > 0.5)


def test_a_sharp_edge_fades_like_a_soft_one() -> None:
    """The opacity of a face that enters is not sharpened."""
    window = Box(280, 140, 380, 270)
    mask = patch_mask(Patch(window, window, Face(0, PLACE, 0.2)), difference=np.ones((130, 100), np.float32))
    assert mask.max() == np.float32(0.2)


def plan(
    planner: PatchPlanner, *places: Box[float], time: float | None = None, shape: tuple[int, int] = (480, 640)
) -> list[PatchSet]:
    return planner.plan([Face(number, box) for number, box in enumerate(places)], shape, (2, 2), time)


def test_windows_rest_while_a_face_moves_a_little() -> None:
    planner, windows = PatchPlanner(), list[Box]()
    for frame, right in enumerate((0, 3, -4, 6, 2)):
        ((patch,),) = (each.patches for each in plan(planner, PLACE.moved(right, 0), time=frame / 25))
        assert patch.face and patch.window.contains(Box(*map(round, mask_box(patch.face.box))))
        windows.append(patch.window)
    assert len(set(windows)) == 1


def test_patches_of_new_windows_fade_in() -> None:
    """Where a face moves on, and where another enters; the earlier ones stay below until then."""
    planner, weights, numbers = PatchPlanner(), list[float](), set[int]()
    for frame in range(60):
        boxes = [PLACE.moved(frame, 0), PLACE.moved(-200, 0)][: 1 + (frame >= 30)]
        sets = plan(planner, *boxes, time=frame / 25)
        assert 1 <= len(sets) <= 2 and [each.number for each in sets] == sorted(each.number for each in sets)
        for each in sets:
            for patch in each.visible:
                assert patch.face and patch.window.contains(Box(*map(round, mask_box(patch.face.box))))
        numbers |= {each.number for each in sets}
        weights.append(sets[-1].patches[0].weight)
        covers = {patch.cover for patch in sets[0].visible} if len(sets) == 2 else set()
        assert covers <= {weights[-1]}
        if frame >= 30:
            assert sets[-1].patches[1].weight == 1 or frame > 32  # it has faded in by its opacity
    assert len(numbers) > 2 and weights[0] == 1
    rises = np.diff(weights)
    assert rises.max() <= 0.04 / CHANGE_SECONDS + 1e-6
    assert min(weights) == 0


def test_two_patches_cover_a_face_as_one() -> None:
    face, window = Face(0, PLACE, 0.7), Box(200, 100, 460, 360)
    alone = patch_mask(Patch(window, window, face))
    assert alone.max() == np.float32(0.7)
    for weight in (0.0, 0.3, 0.9):
        under, over = (
            patch_mask(Patch(window, window, face, *each)) for each in ((1.0, weight), (weight, 0.0))
        )
        assert np.allclose(1 - (1 - under) * (1 - over), alone, atol=1e-5)


def test_windows_of_a_scene_do_not_depend_on_the_scene_before() -> None:
    planner, other = PatchPlanner(), PatchPlanner()
    plan(planner, PLACE, time=0.0)
    faces = [Face(9, PLACE.moved(50, 20))]
    after, alone = (each.plan(faces, (480, 640), (2, 2), 0.04) for each in (planner, other))
    assert len(after) == 1 and after[0].patches == alone[0].patches and after[0].is_new


@pytest.mark.parametrize("shape", [(480, 640), (479, 639), (240, 241)])
def test_patches_hold_their_windows(shape: tuple[int, int]) -> None:
    """Patches of many faces, also at the edges, are parts of the picture, and do not overlap."""
    random = np.random.default_rng(3)
    luma = random.integers(0, 255, shape, np.uint8)
    small = Encoding().chroma_shape(*shape)
    chroma = random.integers(0, 255, small, np.uint8), random.integers(0, 255, small, np.uint8)
    picture = Picture(Encoding(), luma, chroma)
    corners = [(-10, 5), (shape[1] - 25, 60), (90, shape[0] - 30), (100, 90), (0, 0)]
    boxes = [Box(x, y, x + 30, y + 40).moved(*random.uniform(0, 3, 2)) for x, y in corners]
    (patches,) = (each.patches for each in plan(PatchPlanner(), *boxes, shape=shape))
    cut = cut_patches(picture, patches)
    assert cut.shape == patches_shape(patches) and cut.chroma is not None
    for patch in patches:
        window, place = patch.window, patch.place
        assert Box(0, 0, shape[1], shape[0]).contains(window)
        assert not (window.left % 2 or window.top % 2 or place.left % 2 or place.top % 2)
        part = cut.luma[place.top : place.bottom, place.left : place.right]
        assert np.array_equal(part, luma[window.top : window.bottom, window.left : window.right])
        half = cut.chroma[1][place.top // 2 : -(-place.bottom // 2), place.left // 2 : -(-place.right // 2)]
        whole = chroma[1][window.top // 2 : -(-window.bottom // 2), window.left // 2 : -(-window.right // 2)]
        assert np.array_equal(half, whole)
        assert not any(place.intersection(other.place).area for other in patches if other is not patch)


@pytest.mark.parametrize(
    "step",
    [
        {"block": "halftone", "cell": 7.3},
        {"block": "pattern", "spacing": 36, "wobble": 0, "layout": "weave", "angle": 0, "width": 0.1},
    ],
)
@pytest.mark.parametrize(
    "places", [[PLACE], [PLACE.moved(-200, 60), PLACE.moved(33, -5), PLACE.moved(150, 171)]]
)
def test_patches_continue_dots_and_lines(step: dict[str, object], places: list[Box[float]]) -> None:
    """On even gray, focus changes little: the dots of a patch are close to the dots of the page."""
    picture, table = np.full((480, 640, 3), 110, np.uint8), {"format": 1, "height": 480, "background": [step]}
    style = style_from_table(table, "screen")
    results = [focused_on(places, picture, each) for each in (without(style), style)]
    for place in places:
        plain, focused = (each[plane_area(Box(*map(round, place)), (1, 1))] for each in results)
        assert plain.std() > 20 and np.abs(plain - focused).mean() < 0.75 * plain.std()


def test_squares_are_not_divided() -> None:
    """Where a face gets smaller squares, each of the page's is all old or all new."""
    table = {"format": 1, "height": 480, "background": [{"block": "pixelate", "size": 8}]}
    picture, style = picture_with_face(), style_from_table(table, "pixels")
    before, after = (focused_on([PLACE], picture, each) for each in (without(style), style))
    changed = (before != after).any(axis=2)
    (patch,) = (patch for each in plan(PatchPlanner(), PLACE) for patch in each.patches)
    whole = np.zeros((480, 640), np.float32)
    whole[plane_area(patch.window, (1, 1))] = patch_mask(patch, (8, 8))
    cells = whole.reshape(60, 8, 80, 8)
    assert set(np.unique(whole)) == {0, 1} and np.ptp(cells, axis=(1, 3)).max() == 0
    assert changed[whole == 1].mean() > 0.3 and not changed[whole == 0].any()


def test_a_patch_has_the_contrast_of_the_page() -> None:
    """The percentiles of the page hold for its patches, too: outside of the face nothing changes."""
    style = style_from_table(
        {"format": 1, "height": 480, "background": [{"block": "equalize"}, {"block": "minimum_range"}]},
        "equal",
    )
    picture = below_white(Picture.from_array(picture_with_face()))
    assert picture.color is not None
    focused, plain = (stylize(picture.color, each, "cpu").astype(int) for each in (style, without(style)))
    mask = inner_mask(PLACE, Box(0, 0, 640, 480))
    assert np.abs(focused - plain)[mask == 0].max() <= 1
    assert np.abs(focused - plain)[mask == 1].max() > 8
