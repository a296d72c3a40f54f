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
from vidstyle.regions.features.page_colors import brightest_color, darkest_color, local_mean, skin_mean
from vidstyle.regions.features.tones import MAX_SPECK_PX, SPECK_RATIO, in_steps, without_specks
from vidstyle.regions.patch_blending import patch_mask
from vidstyle.regions.patches import Patch, plane_area
from vidstyle.regions.rasters import PageRaster, cell_means
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import Style

CORE_RANGE = 0.45, 0.95
"""Darkness at which a pixel begins to be ink, and from which it is, relative to the strongest nearby."""
CORE_WEIGHT = 0.7
"""Opacity of ink over tones."""
FULL_INK_WEIGHT = 0.33
"""Weight of features from which strokes are full ink: line drawings have no gray."""
LIGHT_WEIGHT = 0.8
"""Opacity of whites of eyes and teeth between lines."""
GROUND_RATIO, SKIN_RATIO = 0.12, 0.07
"""Side of the square whose mean replaces letters and scan lines, relative to the face's height; and of the
one whose mean of lit skin replaces dots and hatching."""
SKIN_WEIGHT = 0.75
"""How far dots and hatching on lit skin are replaced: what is left shows the medium."""
SHADE_FACTOR, INK_WEIGHT = 1.5, 0.95
"""How much darker shade is than where all is tones; and opacity of ink without tones."""
SKIN_LIGHT_WEIGHT = 0.5
"""Opacity of light on lit skin between light lines."""
CALM_WEIGHT_RANGE, CALM_CELL_FACTOR = (0.5, 0.75), 6.0
"""How far scan lines and letters are cleared under features; letters, by their height relative to the face's
times this factor."""
MAX_DOT_RATIO = 3 / 720
"""Largest side of the squares that features consist of in styles of squares, relative to the picture's
shorter side."""
TONE_STEP = 0.15
"""Difference of tones in such squares: they have few colours."""
MIN_LIGHT_INK = 1.5
"""Sum of red, green and blue from which an ink is the colour of light lines; otherwise the page shows it."""
BRIGHT_SHARE = 0.02
"""Share of the brightest pixels around a face that show the colour of paper or light."""


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

    Styles with lines draw them in ink, with paper for the whites of eyes; other styles darken their result,
    towards the darkest colour of the page.

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
    darks = darkest_color(page) if features and medium is not Medium.LIGHT_LINES else None

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = page.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        ink = np.array(inks.pop(0), np.float32)
        dark = darks.pop(0) if darks else np.zeros_like(ink)
        for each, luma, found in zip(features, bright, marks, strict=True):
            area = plane_area(each.window, step)
            values = values_from_codes(plane[area], kind, page.encoding)
            factor = np.minimum(found.factor, 1) if kind == "chroma" else found.factor
            drawn = values
            light = brightest_color(values, luma, BRIGHT_SHARE) if found.bright.any() else ink
            if found.clear.any():
                ground = _ground(values, each, medium, step)
                drawn = drawn + _like(found.clear, values) * (ground - drawn)
            drawn = dark + (drawn - dark) * _like(factor, values)
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
    weight, skin = each.weight, each.skin
    if region is not None:
        weight, skin = (plane * region[plane_area(each.window, (1, 1))] for plane in (weight, skin))
    if raster.cell is not None:
        weight = weight * (patch_mask(Patch(each.window, each.window, each.face), raster.cell) > 0)
    tones, none = each.tones, np.zeros_like(weight)
    cover, same = np.minimum(weight / np.float32(FULL_INK_WEIGHT), 1), none + 1
    change, dot = weight * (tones.tone - 1), raster.dot(MAX_DOT_RATIO * min(page.shape))
    paper = np.float32(LIGHT_WEIGHT) * weight * tones.light
    match medium:
        case Medium.LIGHT_LINES:
            shade = in_steps(np.float32(SHADE_FACTOR) * cover * (1 - tones.tone * tones.shade))
            light = np.maximum(np.float32(SKIN_LIGHT_WEIGHT) * skin * (1 - shade), paper)
            factor = 1 - np.float32(SKIN_LIGHT_WEIGHT) * np.minimum(shade, skin)
            return _Marks(factor, none, none, light) if is_light else _Marks(factor, none, light, none)
        case Medium.INK_OVER_TONES:
            return _Marks(1 + change, none, none, np.float32(CORE_WEIGHT) * cover * _core(each))
        case Medium.INK:
            shade = in_steps(np.float32(SHADE_FACTOR) * weight * (1 - tones.tone * tones.shade))
            ink = np.maximum(shade, np.float32(INK_WEIGHT) * cover * _core(each))
            clear = np.minimum(weight, skin)
            return _Marks(same, np.float32(SKIN_WEIGHT) * clear, paper, ink)
    if dot != (1, 1):
        change = np.round(cell_means(change, each.window, dot) / np.float32(TONE_STEP)) * np.float32(
            TONE_STEP
        )
    calm = _calm(each, raster) * weight if dot == (1, 1) else none
    return _Marks(1 + change, calm, none, none)


def _core(each: Features) -> np.ndarray:
    """Return coverage by ink in the darkest parts, without specks."""
    least = min(SPECK_RATIO * each.face.box.height, MAX_SPECK_PX)
    return without_specks(_ramp(each.tones.dark, CORE_RANGE), least)


def _ground(values: np.ndarray, each: Features, medium: Medium, step: tuple[int, int]) -> np.ndarray:
    """Return what replaces letters, scan lines, dots and hatching under features."""
    height = each.face.box.height
    if medium is not Medium.INK:
        return local_mean(values, GROUND_RATIO * height, step)
    return skin_mean(values, _like(each.skin, values), SKIN_RATIO * height, step)


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
