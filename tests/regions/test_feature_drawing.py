"""Eyes, nose and mouth of small faces, drawn over the result."""

from __future__ import annotations

from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
from focus import EYES, PLACE, WINDOW, lifted
from pictures import picture_with_face

from vidstyle.core.picture import Picture
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.boxes import Box
from vidstyle.regions.features.feature_drawing import draw_features
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS
from vidstyle.regions.features.media import Medium
from vidstyle.regions.patches import plane_area
from vidstyle.regions.rasters import NO_RASTER, PageRaster
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import load_style

pytestmark = pytest.mark.usefixtures("faces_alone")


def test_squares_draw_features_themselves() -> None:
    """All other styles get them, in ink or in tones; letters are too coarse for eyes."""
    letters = PageRaster(cell=(13, 8), has_points=True)
    rasters = {"pixel": replace(letters, cell=(2, 2), has_colors=True), "riso": PageRaster(has_points=True)}
    rasters["ascii"] = letters
    names = "ink", "comic", "poster", "charcoal", "riso", "ascii", "pixel"
    media = [Medium.of(load_style(name), rasters.get(name, NO_RASTER)) for name in names]
    printed = PageRaster(is_screen=True, has_dots=True, has_colors=True)
    assert media[0] is Medium.INK and media[-1] is Medium.POINTS
    assert set(media[1:-1]) == {Medium.TONES}
    assert Medium.of(load_style("comic"), printed) is Medium.COLORED_INK
    light = replace(load_style("comic"), ink="#ffffff", paper="#000000")
    assert Medium.of(light, printed) is Medium.INK


def test_between_light_lines_skin_is_light_and_eyes_are_dark() -> None:
    """White eyes would make a face a negative. The light is hatched."""
    picture, eye = picture_with_face(), USUAL_LANDMARKS.inside(PLACE).left_eye
    cv2.circle(picture, (round(eye[0]), round(eye[1])), 3, (20, 20, 20), -1)
    features, page = lifted(Picture.from_array(picture))[1], np.full((480, 640, 3), 90, np.uint8)
    style = replace(load_style("ink"), ink="#eaf4ff", paper="#2f6cc2")
    drawn = draw_features(Picture.from_array(page), features, style, None, NO_RASTER)
    change = luma_in(drawn, WINDOW) - 90 / 255
    across, down = round(eye[0]) - WINDOW.left, round(eye[1]) - WINDOW.top
    cheek = change[down + 10 : down + 18, across - 4 : across + 4]
    assert change[down, across] < -0.05 and cheek.mean() > 0.1 and np.ptp(cheek) > 0.2


@pytest.mark.parametrize("raster", [PageRaster(is_screen=True), PageRaster(is_screen=True, has_dots=True)])
def test_ink_shades_faces_in_its_own_medium(raster: PageRaster) -> None:
    """White skin with dots for eyes is nobody's; gray skin between lines or dots is of another print."""
    features, page = lifted(Picture.from_array(picture_with_face()))[1], np.full((480, 640, 3), 255, np.uint8)
    drawn = draw_features(Picture.from_array(page), features, load_style("ink"), None, raster)
    luma = luma_in(drawn, features[0].window)
    shaded = np.abs(cv2.blur(luma, (5, 5)) - 0.55) < 0.25
    square = np.ones((5, 5), np.uint8)
    contrast = (cv2.dilate(luma, square) - cv2.erode(luma, square))[shaded]
    assert shaded.sum() > 60 and np.mean(contrast > 0.4) > 0.97


def test_over_dots_of_inks_blots_become_eyes() -> None:
    """A style draws small eyes as black holes: only the pupil is as dark as ink."""
    (found,) = lifted(Picture.from_array(picture_with_face()))[1]
    page, eye = np.full((480, 640, 3), (240, 180, 60), np.uint8), USUAL_LANDMARKS.inside(PLACE).left_eye
    across, down = (round(each) for each in eye)
    page[down - 8 : down + 8, across - 10 : across + 10] = 0
    darkness = np.zeros_like(found.darkness)
    column, row = across - found.window.left, down - found.window.top
    darkness[row - 2 : row + 3, column - 2 : column + 3] = 1
    raster = PageRaster(is_screen=True, has_dots=True, has_colors=True)
    drawn = draw_features(
        Picture.from_array(page), [found._replace(darkness=darkness)], load_style("comic"), None, raster
    )
    luma = luma_in(drawn, found.window)
    assert luma[row, column] < 0.2 and luma[row - 5 : row + 6, column - 9 : column - 5].min() > 0.6


def test_black_hair_stays_as_the_style_draws_it() -> None:
    """On lit skin, black marks are removed."""
    (found,) = lifted(Picture.from_array(picture_with_face()))[1]
    darkness, page = np.zeros_like(found.darkness), np.full((480, 640, 3), 250, np.uint8)
    middle, (left, center) = len(darkness) // 2, (found.window.left, round(PLACE.center[0]))
    darkness[:middle] = 0.7
    page[:, center - 2 : center + 2] = 0
    drawn = draw_features(
        Picture.from_array(page), [found._replace(darkness=darkness)], load_style("ink"), None, NO_RASTER
    )
    strand = luma_in(drawn, found.window)[:, center - 2 - left : center + 2 - left]
    assert strand[middle - 20 : middle - 10].max() < 0.15 and strand[middle + 10 : middle + 16].min() > 0.8


@pytest.mark.parametrize("has_dots", [False, True])
def test_lines_keep_the_outline_of_a_head(has_dots: bool) -> None:
    """Drawn with tones of the source up to its edge, a face is a pale oval. Dots would cut it."""
    (found,) = lifted(Picture.from_array(picture_with_face()))[1]
    is_edge = (found.weight > 0.95) & (found.areas.whole < 0.01)
    assert is_edge.sum() > 50
    page = np.full((480, 640, 3), 255, np.uint8)
    page[plane_area(found.window, (1, 1))][is_edge] = 0
    drawn = draw_features(
        Picture.from_array(page),
        [found._replace(darkness=np.zeros_like(found.darkness))],
        load_style("ink"),
        None,
        PageRaster(is_screen=True, has_dots=has_dots),
    )
    luma = luma_in(drawn, found.window)[is_edge]
    assert luma.max() < 0.05 if not has_dots else luma.min() > 0.3


def test_scan_lines_are_softened_under_features() -> None:
    """Also in light parts of eyes and of a mouth, and in the dark; on lit skin they stay."""
    (found,) = lifted(Picture.from_array(picture_with_face()))[1]
    darkness, page = np.zeros_like(found.darkness), np.full((480, 640, 3), 200, np.uint8)
    middle, page[::2] = darkness.shape[1] // 2, 150
    darkness[:, middle:] = 0.6
    drawn = draw_features(
        Picture.from_array(page), [found._replace(darkness=darkness)], load_style("oil"), None, NO_RASTER
    )
    contrast = np.abs(np.diff(np.log(luma_in(drawn, found.window)), axis=0))
    whole, is_left = found.areas.whole[1:], np.arange(darkness.shape[1]) < middle - 5
    is_right, is_drawn = is_left[::-1], found.weight[1:] > 0.95
    skin, dark = (contrast[is_drawn & (whole < 0.01) & side].mean() for side in (is_left, is_right))
    feature = contrast[is_drawn & (whole > 0.99) & is_left].mean()
    assert skin > 0.9 * np.log(200 / 150) and dark < 0.75 * skin and feature < 0.5 * skin


def features_with_teeth() -> Features:
    picture = picture_with_face()
    mouth = picture[PLACE.top + 36 : PLACE.bottom + 6, PLACE.left : PLACE.right]
    mouth[6:8, 12:33] = 250
    (found,) = lifted(Picture.from_array(picture))[1]
    return found


def test_teeth_are_lighter_than_skin() -> None:
    found = features_with_teeth()
    row, column = PLACE.top + 43 - found.window.top, PLACE.left + 22 - found.window.left
    page = np.full((480, 640, 3), 150, np.uint8)
    drawn = draw_features(Picture.from_array(page), [found], load_style("oil"), None, NO_RASTER)
    assert found.darkness[row, column] < 0 and drawn.color[PLACE.top + 43, PLACE.left + 22].min() > 160


def test_light_tones_add_no_colour() -> None:
    """Teeth are lighter than the paint below them, not more colourful."""
    page = np.full((480, 640, 3), (190, 130, 120), np.uint8)
    picture = picture_from_frame(av.VideoFrame.from_ndarray(page, "rgb24").reformat(format="yuv420p"))
    drawn = draw_features(picture, [features_with_teeth()], load_style("oil"), None, NO_RASTER)
    before, after = (np.abs(np.array(each.chroma, int) - 128).max() for each in (picture, drawn))
    assert drawn.luma.max() > picture.luma.max() and after <= before


@pytest.mark.parametrize(
    ("name", "paper"),
    [("ink", 250), ("oil", 180), ("neon", 180)],
)
def test_eyes_are_drawn_in_the_colours_of_the_style(name: str, paper: int) -> None:
    """And nothing around the face changes."""
    features, page = (
        lifted(Picture.from_array(picture_with_face()))[1],
        np.full((480, 640, 3), paper, np.uint8),
    )
    page[:, 357:360] = 220
    drawn = draw_features(Picture.from_array(page), features, load_style(name), None, NO_RASTER)
    change = luma_in(drawn, WINDOW)[EYES] - paper / 255
    assert change.min() < -0.3
    assert np.array_equal(drawn.color[:150], page[:150]) and np.array_equal(
        drawn.color[:, :290], page[:, :290]
    )


@pytest.mark.parametrize("format", ["rgb24", "yuv420p"])
def test_features_in_one_ink_are_as_dark_as_this_ink(format: str) -> None:
    """Gray eyes in a drawing in red chalk are not of this drawing."""
    page, ink = np.full((480, 640, 3), (222, 202, 198), np.uint8), (122, 46, 28)
    page[:60] = ink
    features = lifted(Picture.from_array(picture_with_face()))[1]
    picture = picture_from_frame(av.VideoFrame.from_ndarray(page, "rgb24").reformat(format=format))
    drawn = draw_features(picture, features, load_style("oil"), None, NO_RASTER)
    luma, least = luma_in(drawn, WINDOW), luma_in(picture, Box(0, 0, 640, 60)).min()
    assert least - 0.02 < luma[EYES].min() < 0.6
    if drawn.color is not None:
        red, green, _ = drawn.color[plane_area(WINDOW, (1, 1))].astype(int).transpose(2, 0, 1)
        assert (red - green)[luma < 0.75].min() >= 25


def test_features_keep_to_the_region_of_a_style() -> None:
    features, page = lifted(Picture.from_array(picture_with_face()))[1], np.full((480, 640, 3), 200, np.uint8)
    style, region = load_style("poster"), np.zeros((480, 640), np.float32)
    page_picture = Picture.from_array(page)
    assert np.array_equal(draw_features(page_picture, features, style, region, NO_RASTER).color, page)
    region[:, :320] = 1
    halved = draw_features(page_picture, features, style, region, NO_RASTER).color
    assert np.array_equal(halved[:, 320:], page[:, 320:]) and halved.min() < 150


@pytest.mark.parametrize(("ground", "lit"), [(30, 2.0), (150, 1.0)])
def test_dark_skin_in_tones_gets_light(ground: int, lit: float) -> None:
    """On black, eyes cannot be darker than the skin."""
    features, page = (
        lifted(Picture.from_array(picture_with_face()))[1],
        np.full((480, 640, 3), ground, np.uint8),
    )
    drawn = draw_features(Picture.from_array(page), features, load_style("neon"), None, NO_RASTER)
    luma = luma_in(drawn, WINDOW) * 255 / ground
    assert np.quantile(luma, 0.95) >= lit and luma[EYES].min() < 0.6 * np.quantile(luma, 0.95)
    assert luma[:4].max() == pytest.approx(1, abs=0.01)


def test_faces_that_overlap_are_drawn_once() -> None:
    """Else a cheek in front of another face is lit twice."""
    (found,), dark = lifted(Picture.from_array(picture_with_face()))[1], np.full((480, 640, 3), 30, np.uint8)
    once, twice = (
        draw_features(Picture.from_array(dark), [found] * count, load_style("neon"), None, NO_RASTER).color
        for count in (1, 2)
    )
    strong = np.zeros(dark.shape[:2], bool)
    strong[plane_area(found.window, (1, 1))] = found.weight > 0.999
    assert strong.any() and np.array_equal(once[strong], twice[strong])


def test_dots_of_inks_are_softened_around_features() -> None:
    """Their contrast is stronger than that of an eye."""
    features, page = lifted(Picture.from_array(picture_with_face()))[1], np.full((480, 640, 3), 230, np.uint8)
    page[::4, ::4], raster = (200, 60, 0), PageRaster(is_screen=True, has_dots=True, has_colors=True)
    drawn = luma_in(
        draw_features(Picture.from_array(page), features, load_style("comic"), None, raster), WINDOW
    )
    (found,), before = features, luma_in(Picture.from_array(page), WINDOW)
    rows, columns = found.window.top - WINDOW.top, found.window.left - WINDOW.left
    inside = np.s_[rows : rows + found.window.height, columns : columns + found.window.width]
    change = np.abs(cv2.Laplacian(drawn, -1))[inside] / np.abs(cv2.Laplacian(before, -1))[inside].mean()
    is_lit = (found.weight > 0.95) & (np.abs(found.darkness) < 0.05)
    skin, near = (
        change[is_lit & mask].mean() for mask in (found.areas.whole < 0.01, found.areas.whole > 0.99)
    )
    assert skin > 0.8 and near < 0.6 * skin
