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
from vidstyle.regions.patch_blending import patch_mask
from vidstyle.regions.patches import Patch, plane_area
from vidstyle.regions.rasters import PageRaster, cell_means, divided_cell
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import Style

INK_RANGE = 0.26, 0.55
"""Darkness at which a pixel begins to be ink, and from which it is, relative to the strongest nearby."""
FULL_INK_WEIGHT = 0.33
"""Weight of features from which strokes are full ink: line drawings have no gray."""
LIGHT_WEIGHT = 0.8
"""Opacity of whites of eyes and teeth in styles with lines."""
SHADE_WEIGHT = 0.6
"""Weight of tones under the ink, in styles with continuous tones next to lines."""
MAX_DOT_RATIO = 3 / 720
"""Largest side of the squares that features consist of in styles of squares, relative to the picture's
shorter side."""
GLOW_RATIO_RANGE = 0.4, 0.2
"""Luma of skin in the result, relative to the source, at which features begin to glow, as in styles with
light lines on black, and up to which they do completely."""
GLOW_SHARE = 0.02
"""Share of the brightest pixels around a face that show the colour of that light."""
SKIN_SHARE, MIN_SKIN_RATIO = 0.9, 0.1
"""Quantile of luma that counts as the skin, which is black between letters; and minimum luma of skin."""


class _Marks(NamedTuple):
    """Layers over the page, H x W float32: coverage by ink, by paper and by light, and a factor."""

    ink: np.ndarray
    paper: np.ndarray
    glow: np.ndarray
    factor: np.ndarray


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
        style: its ink and paper are the colours.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        raster: its dots and squares.
    """
    colors = [rgb_from_text(text) for text in (style.ink, style.paper)]
    tones = [page.encoding.yuv_from_color(color) for color in colors]
    samples = [
        *([[tone[0] for tone in tones]] if page.luma is not None else ()),
        *([[tone[channel] for tone in tones] for channel in (1, 2)] if page.chroma else ()),
        *([colors] if page.color is not None else ()),
    ]
    bright = [luma_in(page, each.window) for each in features]
    marks = [
        _marks(each, luma, style, page, region, raster) for each, luma in zip(features, bright, strict=True)
    ]

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = page.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        inks = np.array(samples.pop(0), np.float32)
        for each, luma, found in zip(features, bright, marks, strict=True):
            area = plane_area(each.window, step)
            values = values_from_codes(plane[area], kind, page.encoding)
            factor = np.minimum(found.factor, 1) if kind == "chroma" else found.factor
            light = _brightest(values, luma) if found.glow.any() else inks[1]
            drawn = values * _like(factor, values)
            for ink, cover in ((light, found.glow), (inks[0], found.ink), (inks[1], found.paper)):
                drawn = drawn + _like(cover, values) * (ink - drawn)
            plane[area] = codes_from_values(drawn, kind, page.encoding)
        return plane

    return page.map_planes(draw)


def _marks(
    each: Features,
    luma: np.ndarray,
    style: Style,
    page: Picture,
    region: np.ndarray | None,
    raster: PageRaster,
) -> _Marks:
    """Return the layers over the page for the features of a face; `luma`: of the page."""
    weight = each.weight if region is None else each.weight * region[plane_area(each.window, (1, 1))]
    if raster.cell is not None:
        weight = weight * (patch_mask(Patch(each.window, each.window, each.face), raster.cell) > 0)
    low, high = INK_RANGE
    ink = np.clip((each.dark - np.float32(low)) / np.float32(high - low), 0, 1)
    ink *= np.minimum(weight / np.float32(FULL_INK_WEIGHT), 1)
    paper, none = np.float32(LIGHT_WEIGHT) * weight * each.light, np.zeros_like(weight)
    change = weight * (each.tone - 1)
    if raster.cell is not None:
        dot = divided_cell(raster.cell, MAX_DOT_RATIO * min(page.shape))
        ink, paper, change = (cell_means(plane, each.window, dot) for plane in (ink, paper, change))
        ink, paper = ((plane >= 0.5).astype(np.float32) for plane in (ink, paper))
    if style.lines:
        shade = SHADE_WEIGHT if style.background and not raster.waves else 0.0
        return _Marks(ink, paper, none, 1 + np.float32(shade) * change)
    glow = _glow(each, luma)
    return _Marks(none, none, glow * ink, 1 + change)


def _glow(each: Features, luma: np.ndarray) -> np.float32:
    """Return how much features glow on the page, 0..1."""
    none, whole = GLOW_RATIO_RANGE
    skin = float(np.quantile(luma[each.weight >= 0.5 * each.weight.max()], SKIN_SHARE))
    share = skin / max(each.skin_luma, MIN_SKIN_RATIO)
    return np.float32(min(1.0, max(0.0, (none - share) / (none - whole))))


def _brightest(values: np.ndarray, luma: np.ndarray) -> np.ndarray:
    """Return the mean of the samples where luma is highest."""
    if luma.shape != values.shape[:2]:
        luma = cv2.resize(luma, values.shape[1::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(values[luma >= np.quantile(luma, 1 - GLOW_SHARE)].mean(axis=0), np.float32)


def _like(plane: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a plane at the size of samples, to be multiplied by them."""
    if plane.shape != values.shape[:2]:
        plane = cv2.resize(plane, values.shape[1::-1], interpolation=cv2.INTER_AREA)
    return plane if values.ndim == 2 else plane[..., None]
