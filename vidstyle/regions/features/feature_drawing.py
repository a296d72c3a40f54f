"""Draws lifted eyes, noses and mouths over a restyled picture, in the colours of the style."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import codes_from_values, values_from_codes
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.page_colors import brightest_color, local_mean, mean_chroma
from vidstyle.regions.features.tones import MAX_SPECK_PX, SPECK_RATIO, without_specks
from vidstyle.regions.patch_blending import patch_mask
from vidstyle.regions.patches import Patch, plane_area
from vidstyle.regions.rasters import PageRaster, cell_means
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import Style

INK_RANGE, CORE_RANGE, LINE_RANGE = (0.2, 0.5), (0.45, 0.95), (0.2, 0.6)
"""Darkness at which a pixel begins to be ink, and from which it is, relative to the strongest nearby; the
same over tones; and for lines in light."""
CORE_WEIGHT = 0.7
"""Opacity of ink over tones."""
FULL_LINE_HEIGHT_PX = 60
"""Height of a face from which lines in light are opaque: on smaller ones, they are as wide as an eye."""
FULL_INK_WEIGHT = 0.33
"""Weight of features from which strokes are full ink: line drawings have no gray."""
LIGHT_WEIGHT = 0.8
"""Opacity of whites of eyes and teeth between lines."""
CLEAR_RATIO, CLEAR_RANGE, GROUND_RATIO = 0.027, (0.4, 0.65), 0.12
"""Distance from ink in which dots and hatching are cleared, relative to the face's height; nearness from
which they begin to be, and from which they are, as there is no gray; and side of the square whose mean
replaces letters and scan lines, in the same way."""
PAPER_WEIGHT = 0.45
"""How far dots and hatching near ink are cleared to paper, as bare paper would be a white ring."""
CALM_WEIGHT_RANGE, CALM_CELL_FACTOR = (0.5, 0.75), 6.0
"""How far scan lines and letters are cleared under features; letters, by their height relative to the face's
times this factor."""
MAX_DOT_RATIO = 3 / 720
"""Largest side of the squares that features consist of in styles of squares, relative to the picture's
shorter side."""
MIN_DOT_COVERAGE = 0.4
"""Coverage from which such a square is full."""
TONE_STEP = 0.15
"""Difference of tones in such squares: they have few colours."""
MIN_LIGHT_INK = 1.5
"""Sum of red, green and blue from which an ink is the colour of light lines; otherwise the page shows it."""
BRIGHT_SHARE = 0.02
"""Share of the brightest pixels around a face that show the colour of paper or light."""
MAX_PAPER_CHROMA = 0.12
"""Mean chroma around a face up to which the ground between dots is paper: inks of colours print skin."""
GROUND_SHARE = 0.1
"""Share of the brightest pixels near eyes and mouth that show the ground between dots and hatching."""


class _Marks(NamedTuple):
    """Layers over the page, H x W float32, in this order: a factor, and coverage.

    Attributes:
        factor: of the page.
        clear: coverage by even ground.
        bright: coverage by the brightest colour of the page, paper or light.
        ink: coverage by the ink of the style.
    """

    factor: np.ndarray
    clear: np.ndarray
    bright: np.ndarray
    ink: np.ndarray


def draw_features(
    page: Picture,
    features: Sequence[Features],
    style: Style,
    region: np.ndarray | None,
    raster: PageRaster,
) -> Picture:
    """Return a picture with features over it.

    Styles with lines draw them in ink, with paper for the whites of eyes; other styles darken their result.

    Args:
        page: the restyled picture; only read.
        features: the features.
        style: its ink is the colour.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        raster: its dots and squares.
    """
    color = rgb_from_text(style.ink)
    luma, *chroma = page.encoding.yuv_from_color(color)
    inks = [
        *((luma,) if page.luma is not None else ()),
        *(chroma if page.chroma else ()),
        *((color,) if page.color is not None else ()),
    ]
    bright = [luma_in(page, each.window) for each in features]
    medium, is_light = Medium.of(style, raster), sum(color) > MIN_LIGHT_INK
    marks = [_marks(each, medium, is_light, page, region, raster) for each in features]
    has_paper = [
        medium is Medium.INK and mean_chroma(page, each.window) < MAX_PAPER_CHROMA for each in features
    ]

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = page.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        ink = np.array(inks.pop(0), np.float32)
        for each, luma, found, is_paper in zip(features, bright, marks, has_paper, strict=True):
            area = plane_area(each.window, step)
            values = values_from_codes(plane[area], kind, page.encoding)
            factor = np.minimum(found.factor, 1) if kind == "chroma" else found.factor
            drawn = values
            light = brightest_color(values, luma, BRIGHT_SHARE) if found.bright.any() else ink
            if found.clear.any():
                ground = (
                    brightest_color(values, luma, GROUND_SHARE, each.tones.near)
                    if is_paper
                    else local_mean(values, GROUND_RATIO * each.face.box.height, step)
                )
                share = np.float32(PAPER_WEIGHT if is_paper and raster.cell is None else 1)
                drawn = drawn + share * _like(found.clear, values) * (ground - drawn)
            drawn = drawn * _like(factor, values)
            for color, cover in ((light, found.bright), (ink, found.ink)):
                if cover.any():
                    drawn = drawn + _like(cover, values) * (color - drawn)
            plane[area] = codes_from_values(drawn, kind, page.encoding)
        return plane

    return page.map_planes(draw)


def _marks(
    each: Features,
    medium: Medium,
    is_light: bool,
    page: Picture,
    region: np.ndarray | None,
    raster: PageRaster,
) -> _Marks:
    """Return the layers over the page for the features of a face.

    Args:
        is_light: whether the ink has the colour of light lines.
    """
    weight = each.weight if region is None else each.weight * region[plane_area(each.window, (1, 1))]
    if raster.cell is not None:
        weight = weight * (patch_mask(Patch(each.window, each.window, each.face), raster.cell) > 0)
    tones, none = each.tones, np.zeros_like(weight)
    cover, same = np.minimum(weight / np.float32(FULL_INK_WEIGHT), 1), none + 1
    change, dot = weight * (tones.tone - 1), raster.dot(MAX_DOT_RATIO * min(page.shape))
    match medium:
        case Medium.LIGHT_LINES:
            share = np.float32(min(1.0, each.face.box.height / FULL_LINE_HEIGHT_PX))
            line = share * cover * _ramp(tones.contour, LINE_RANGE)
            return _Marks(same, none, none, line) if is_light else _Marks(same, none, line, none)
        case Medium.INK_OVER_TONES:
            least = min(SPECK_RATIO * each.face.box.height, MAX_SPECK_PX)
            core = without_specks(_ramp(tones.dark, CORE_RANGE), least)
            return _Marks(1 + change, none, none, np.float32(CORE_WEIGHT) * cover * core)
        case Medium.INK:
            paper = np.float32(LIGHT_WEIGHT) * weight * tones.light
            ink, paper = (
                _in_dots(plane, each, dot) for plane in (cover * _ramp(tones.dark, INK_RANGE), paper)
            )
            return _Marks(same, _cleared(each, ink, raster), paper, ink)
    if dot != (1, 1):
        change = np.round(cell_means(change, each.window, dot) / np.float32(TONE_STEP)) * np.float32(
            TONE_STEP
        )
    calm = _calm(each, raster) * weight if dot == (1, 1) else none
    return _Marks(1 + change, calm, none, none)


def _in_dots(plane: np.ndarray, each: Features, dot: tuple[int, int]) -> np.ndarray:
    """Return coverage in which the squares of a page are full or empty; the same without squares."""
    if dot == (1, 1):
        return plane
    return (cell_means(plane, each.window, dot) >= MIN_DOT_COVERAGE).astype(np.float32)


def _cleared(each: Features, ink: np.ndarray, raster: PageRaster) -> np.ndarray:
    """Return where dots and hatching are cleared: close to ink, which is hard to see among them."""
    side = 2 * max(1, round(CLEAR_RATIO * each.face.box.height)) + 1
    near = cv2.dilate(ink * each.tones.near, np.ones((side, side), np.uint8))
    near = near if raster.cell is not None else cv2.blur(near, (side, side))
    return _ramp(near * each.tones.near, CLEAR_RANGE)


def _calm(each: Features, raster: PageRaster) -> np.float32:
    """Return how far a style's letters or scan lines are cleared under features, 0..1."""
    if not raster.waves:
        return np.float32(0)
    least, most = CALM_WEIGHT_RANGE
    share = CALM_CELL_FACTOR * raster.cell[0] / each.face.box.height if raster.cell else 0.0
    return np.float32(min(most, max(least, share)))


def _ramp(plane: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    low, high = map(np.float32, ends)
    return np.clip((plane - low) / (high - low), 0, 1)


def _like(plane: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a plane at the size of samples, to be multiplied by them."""
    if plane.shape != values.shape[:2]:
        plane = cv2.resize(plane, values.shape[1::-1], interpolation=cv2.INTER_AREA)
    return plane if values.ndim == 2 else plane[..., None]
