"""Focus: faces in finer detail, and nothing else changed."""

from __future__ import annotations

from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
from covering import of_the_day
from media import photograph
from pictures import FACE, film_with_face, picture_with_face

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.scene_cuts import KnownCuts, SceneCuts
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face, FaceFollower
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.exposure import (
    FACE_LUMA_RANGE,
    FACE_QUANTILES,
    PAGE_QUANTILES,
    Stretch,
    expose_face,
)
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS
from vidstyle.regions.focus import FACE_RATIOS, FocusRenderer
from vidstyle.regions.masks import face_mask, inner_mask, mask_box
from vidstyle.regions.patch_blending import patch_mask
from vidstyle.regions.patch_renderer import PatchRenderer
from vidstyle.regions.patches import (
    CHANGE_SECONDS,
    Patch,
    PatchPlanner,
    PatchSet,
    cut_patches,
    patches_shape,
    plane_area,
)
from vidstyle.regions.rasters import NO_RASTER
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.renderer import open_renderer, restyle_array, stylize
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import Style, load_style, style_from_table
from vidstyle.style.resolve import resolve

PLACE = FACE.moved(250, 150)
"""The face in `picture_with_face`."""
SKIN = np.ones((80, 80), np.float32)
STYLES = ("comic", "engraving", "ink")

pytestmark = pytest.mark.usefixtures("faces_alone")


def without(style: Style) -> Style:
    return replace(style, focus=0.0)


def focused_on(faces: list[Box[float]], picture: np.ndarray, style: Style) -> np.ndarray:
    """Return a picture restyled with focus on these faces."""
    known = KnownFaces({each.scaled(1 / picture.shape[0]): USUAL_LANDMARKS for each in faces})
    with FocusRenderer(style, lambda style, _: CpuRenderer(style), known) as renderer:
        return restyle_array(renderer, picture).astype(int)


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of eyes and mouth: of luma without what is larger than a pupil."""
    inner, details = PLACE.padded(-0.12 * PLACE.width, 0, 0), []
    rows = [int(PLACE.top + share * PLACE.height) for share in (0.28, 0.5, 0.66, 0.86)]
    for picture in (one, other):
        luma = picture[:, int(inner.left) : int(inner.right)].mean(axis=2)
        luma = cv2.GaussianBlur(luma, (0, 0), 0.7) - cv2.GaussianBlur(luma, (0, 0), 3)
        details.append(np.vstack([luma[rows[0] : rows[1]], luma[rows[2] : rows[3]]]).ravel())
    return float(np.corrcoef(*details)[0, 1])


@pytest.mark.parametrize(
    ("name", "least"),
    [
        ("cartoon", 0.84),
        ("comic", 0.74),
        ("engraving", 0.76),
        ("ink", 0.81),
        ("manga", 0.79),
        ("poster", 0.79),
    ],
)
def test_a_pale_face_keeps_its_features(name: str, least: float) -> None:
    """As by flash. Some styles keep most of them without focus, too, as they expose locally."""
    picture, style = (picture_with_face() * 0.3 + 150).astype(np.uint8), load_style(name)
    assert likeness(picture, stylize(picture, style, "cpu")) > least


def test_much_of_what_a_pale_face_loses_is_there_with_focus() -> None:
    picture, style = (picture_with_face() * 0.3 + 150).astype(np.uint8), load_style("woodcut")
    focused, plain = (likeness(picture, stylize(picture, each, "cpu")) for each in (style, without(style)))
    assert 1 - focused < 0.7 * (1 - plain)


def test_faces_have_smaller_marks() -> None:
    """In squares, a face changes more often from pixel to pixel."""
    table = {"format": 1, "height": 480, "background": [{"block": "pixelate", "size": 8}]}
    picture, style = picture_with_face(), style_from_table(table, "pixels")
    inner = PLACE.padded(-0.2 * PLACE.width, -0.2 * PLACE.height, -0.2 * PLACE.height)
    area = plane_area(Box(*map(round, inner)), (1, 1))
    faces = (focused_on([PLACE], picture, each)[area] for each in (style, without(style)))
    counts = [np.count_nonzero((face[:, 1:] != face[:, :-1]).any(axis=2)) for face in faces]
    assert counts[0] > 1.6 * counts[1]


def test_blurs_and_grain_keep_their_size() -> None:
    """While other lengths become finer, each up to its own level of detail."""
    steps = [
        {"block": "gaussian", "sigma": 6}, {"block": "noise", "size": 6}, {"block": "pixelate", "size": 6},
        {"block": "kuwahara", "radius": 6},
    ]  # fmt: skip
    style = style_from_table({"format": 1, "height": 480, "background": steps}, "dots")
    resolved = resolve(replace(style, detail=3.0), 480, 640)["background"]
    names = "sigma", "size", "size", "radius"
    assert [step.values[name] for step, name in zip(resolved, names, strict=True)] == [6, 6, 3, 2]


@pytest.mark.parametrize("name", STYLES)
def test_only_faces_change(name: str) -> None:
    style = load_style(name)
    picture = picture_with_face()
    changed = (stylize(picture, style, "cpu") != stylize(picture, without(style), "cpu")).any(axis=2)
    rows, columns = np.nonzero(changed)
    found = Box(columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
    assert mask_box(PLACE).padded(8, 8, 8).contains(found) and found.area > PLACE.area


def test_pictures_without_a_small_face_are_unchanged() -> None:
    """Neither tables nor a face that fills the picture."""
    style, astronaut = load_style("comic"), np.ascontiguousarray(photograph("astronaut")[40:300, 80:400])
    for picture in (picture_with_face(None), photograph("rocket"), astronaut):
        assert np.array_equal(stylize(picture, style, "cpu"), stylize(picture, without(style), "cpu"))


def test_a_style_without_height_has_no_focus() -> None:
    picture, style = picture_with_face(), replace(load_style("comic"), height=None)
    assert np.array_equal(stylize(picture, style, "cpu"), stylize(picture, without(style), "cpu"))


def test_focus_is_a_slider() -> None:
    """More of it changes the face more."""
    picture, style = picture_with_face(), load_style("oil")
    results = [stylize(picture, replace(style, focus=focus), "cpu").astype(int) for focus in (0, 0.3, 1)]
    small, large = (np.abs(each - results[0]).mean() for each in results[1:])
    assert 0 < small < large


@pytest.mark.parametrize("format", ["yuv420p", "yuv422p10le", "yuv444p", "gray", "rgb24", "yuva420p"])
def test_every_layout_of_planes(format: str) -> None:
    """The planes outside faces and alpha are those without focus; odd sizes work."""
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture_with_face()[:479, :639]), "rgb24")
    picture, style = picture_from_frame(frame.reformat(format=format)), load_style("comic")
    results = []
    for each in (style, without(style)):
        with FocusRenderer(each, lambda style, _: CpuRenderer(style), FaceFollower(FaceFinder())) as renderer:
            results.append(renderer.run(picture))
    focused, plain = results
    assert focused.encoding == plain.encoding and focused.shape == plain.shape
    for one, other in zip(planes(focused), planes(plain), strict=True):
        assert one.shape == other.shape and one.dtype == other.dtype
        below = 280 * one.shape[0] // 479
        assert np.array_equal(one[below:], other[below:])
    main = [focused.luma, plain.luma] if focused.color is None else [focused.color, plain.color]
    assert main[0] is not None and main[1] is not None and (main[0] != main[1]).any()
    if plain.alpha is not None:
        assert focused.alpha is plain.alpha or np.array_equal(focused.alpha, plain.alpha)


def test_a_film_is_the_same_in_any_way_to_run_it() -> None:
    """Pictures in flight, and one after another; the source is only read."""
    frames = film_with_face(lambda number: 200 + 2 * number, 12)
    copies = [picture.color.copy() for picture, _ in frames if picture.color is not None]
    style, results = load_style("comic"), []
    for in_flight in (True, False):
        renderer = open_renderer(style, "cpu")
        pending = [
            renderer.begin(FrameRequest(*frame)) if in_flight else renderer.run(*frame) for frame in frames
        ]
        pictures = [each if isinstance(each, Picture) else each.result() for each in pending]
        results.append([planes(each)[0] for each in pictures])
        renderer.close()
    assert all(map(np.array_equal, *results))
    assert all(np.array_equal(picture.color, copy) for (picture, _), copy in zip(frames, copies, strict=True))


def test_a_scene_does_not_depend_on_the_scene_before() -> None:
    """Though its face appears later than the scene begins: segments of a film join without a seam."""
    before = [(below_white(picture), time) for picture, time in film_with_face(lambda _: 250, 8)]
    after = film_with_face(lambda number: 250 if number > 3 else None, 40)
    later, results = [(picture, time + 0.32) for picture, time in after], list[list[np.ndarray]]()
    style = style_from_table(
        {"format": 1, "height": 720, "background": [{"block": "equalize", "settle": 2}]}, "equal"
    )
    for each, frames in ((style, before + later), (style, later), (without(style), later)):
        renderer = open_renderer(each, "cpu", cuts=KnownCuts([0.0, 0.32]))
        results.append([planes(renderer.run(*frame))[0] for frame in frames][-len(later) :])
        renderer.close()
    assert all(map(np.array_equal, *results[:2]))
    assert not np.array_equal(results[0][-1], results[2][-1])


@pytest.mark.parametrize("name", of_the_day(["comic", "manga"], 1))
def test_marks_do_not_jump_while_a_face_moves(name: str) -> None:
    """The greatest change from frame to frame around a slow face is near the mean, though windows change."""
    frames = film_with_face(lambda number: 100 + number, 40)
    renderer, changes, before = open_renderer(replace(load_style(name), steady=0.0), "cpu"), [], None
    for number, (picture, time) in enumerate(frames):
        color = renderer.run(picture, time, rgb=True).color
        assert color is not None
        if before is not None:
            area = plane_area(Box(*map(round, FACE.moved(100 + number, 150))), (1, 1))
            changes.append(float(np.abs(color[area].astype(int) - before[area]).mean()))
        before = color
    renderer.close()
    assert max(changes) < 1.4 * np.mean(changes)


def test_a_film_may_begin_after_pictures_that_are_skipped() -> None:
    """As where a render is continued: faces then have the windows of the whole film, and so their marks."""
    frames = film_with_face(lambda number: 150 + 3 * number if number > 2 else None, 40)
    style, results = replace(load_style("comic"), steady=0.0), list[np.ndarray]()
    for skipped, begun in ((0, 0), (30, 30), (0, 30)):
        renderer = open_renderer(style, "cpu")
        for frame in frames[:skipped]:
            renderer.skip(FrameRequest(*frame))
        pictures = [renderer.run(*frame) for frame in frames[begun:]]
        results.append(np.array([planes(each)[0].astype(int) for each in pictures][-5:]))
        renderer.close()
    # Percentiles of the style have not quite settled.
    continued, fresh = (np.mean(np.abs(results[0] - each)) for each in results[1:])
    assert continued < 0.25 * fresh


def below_white(picture: Picture) -> Picture:
    """Return a picture that is white below the face, which changes percentiles around it."""
    assert picture.color is not None
    color = picture.color.copy()
    color[int(PLACE.bottom) + 6 :] = 255
    return Picture.from_array(color)


def test_a_change_of_style_takes_effect_on_faces() -> None:
    picture, styles = Picture.from_array(picture_with_face()), [load_style(name) for name in ("comic", "ink")]
    renderer = open_renderer(styles[0], "cpu")
    renderer.run(picture)
    renderer.change_style(styles[1])
    changed = renderer.run(picture, rgb=True).color
    renderer.change_style(without(styles[1]))
    off = renderer.run(picture, rgb=True).color
    renderer.close()
    assert np.array_equal(changed, stylize(picture_with_face(), styles[1], "cpu"))
    assert np.array_equal(off, stylize(picture_with_face(), without(styles[1]), "cpu"))


def test_no_picture_waits_for_faces_that_cannot_be_found(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Without the networks the result has no focus, and a line reports what to install."""
    from vidstyle.regions import faces

    monkeypatch.setattr(faces, "weights_folder", lambda: None)
    picture, style = picture_with_face(), load_style("ink")
    with caplog.at_level("INFO", "vidstyle"):
        result = stylize(picture, style, "cpu")
    (line,) = [record.message for record in caplog.records if "focus" in record.message]
    assert "vidstyle[comic]" in line
    assert np.array_equal(result, stylize(picture, without(style), "cpu"))
    caplog.clear()
    stylize(picture, without(style), "cpu")
    assert not [record for record in caplog.records if "focus" in record.message]


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


@pytest.mark.parametrize(("dark", "bright"), [(0.02, 0.2), (0.7, 0.98), (0.3, 0.4)])
def test_tones_of_a_face_approach_one_range(dark: float, bright: float) -> None:
    luma = np.float32(np.linspace(dark, bright, 6400).reshape(80, 80))
    tones = np.quantile(luma, FACE_QUANTILES)
    after = np.quantile(expose_face(luma, tones, SKIN, 60.0, Stretch(0.5, 1.0)), FACE_QUANTILES)
    assert np.ptp(after) > 1.2 * np.ptp(tones)
    assert (
        abs(after.mean() - np.mean(FACE_LUMA_RANGE))
        < 0.7 * abs(tones.mean() - np.mean(FACE_LUMA_RANGE)) + 0.02
    )


def test_the_stretch_is_what_styles_do() -> None:
    """Else skin that is bright on a dull page becomes paper white."""
    page = np.tile(np.linspace(0.02, 0.55, 200, dtype=np.float32)[:, None], (100, 1, 3))
    equalize = {"block": "equalize", "low": 1, "high": 99.7}
    wanted = stylize(page, load_style({"format": 1, "name": "x", "background": [equalize]}), device="cpu")
    shown = Stretch.of(*np.quantile(page, PAGE_QUANTILES)).shown(page)
    assert np.abs(np.clip(shown, 0, 1) - wanted).max() < 0.02


def test_exposure_takes_the_stretch_of_the_style_into_account() -> None:
    """What a style stretches later has the same tones as what it does not."""
    luma = np.float32(np.linspace(0.4, 0.6, 6400).reshape(80, 80))
    tones, stretch = np.quantile(luma, FACE_QUANTILES), Stretch.of(0.4, 0.7)
    assert stretch.gain > 2 and np.allclose(stretch.luma(stretch.shown(luma)), luma, atol=1e-6)
    exposed = expose_face(luma, tones, SKIN, 60.0, stretch)
    shown = expose_face(stretch.shown(luma), stretch.shown(tones), SKIN, 60.0, Stretch(0.5, 1.0))
    assert np.allclose(stretch.shown(exposed), shown, atol=1e-5)


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
    """On even gray, focus changes little: the dots of a patch lie about where those of the page do."""
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


def test_large_faces_have_no_focus() -> None:
    assert PLACE.height / 480 < FACE_RATIOS[0] < FACE_RATIOS[1] < 130 / 260


def planes(picture: Picture) -> list[np.ndarray]:
    found: list[np.ndarray] = []
    picture.map_planes(lambda plane, kind: (found.append(plane), plane)[1] if kind != "alpha" else plane)
    return found


def test_only_new_windows_begin_a_scene_of_the_patches() -> None:
    """A single picture begins none: it has no time."""
    known: list[SceneCuts | None] = []

    def open_backend(style: Style, cuts: SceneCuts | None) -> CpuRenderer:
        known.append(cuts)
        return CpuRenderer(style, cuts=cuts)

    picture = Picture.from_array(picture_with_face())
    patch = Patch(Box(200, 100, 460, 360), Box(0, 0, 260, 260), Face(1, PLACE, 1.0))
    times = 0.0, 0.04, 0.08, None
    with PatchRenderer(open_backend) as renderer:
        for time, is_new in zip(times, (True, False, True, True), strict=True):
            patches = PatchSet(1, (patch,), is_new, PLACE.height)
            renderer.prepare(
                FrameRequest(picture, time), patches, load_style("ink"), lambda face: 1.0, NO_RASTER
            )
    (cuts,) = known
    assert cuts is not None
    assert [cuts.begins_scene(picture, time) for time in times] == [True, False, True, False]


def test_features_come_from_the_cleaned_picture() -> None:
    """Else noise and blocks of JPEG return as specks of faces; and patches are not cleaned a second time."""
    _, data = cv2.imencode(".jpg", picture_with_face()[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 25])
    dirty = cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1]
    clean = flatten_still(FrameRequest(Picture.from_array(dirty)), 1).picture.color
    assert clean is not None and not np.array_equal(clean, dirty)
    chosen = load_style("ink")
    made = focused_on([PLACE], dirty, chosen)
    assert np.array_equal(made, focused_on([PLACE], clean, replace(chosen, steady=0)))
