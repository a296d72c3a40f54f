"""Draws lifted eyes, noses and mouths over a restyled picture, in the colours of the style."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import codes_from_values, values_from_codes
from vidstyle.regions.features.blurring import resized
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.feature_marks import marks_of
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.page_colors import brightest_color, darkest_colors, local_mean, skin_mean
from vidstyle.regions.patches import plane_area
from vidstyle.regions.rasters import PageRaster
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import Style

GROUND_RATIO, SKIN_RATIO = 0.12, 0.07
"""Side of the square whose mean replaces letters and scan lines, relative to the face's height; and of the
one whose mean of lit skin replaces dots and hatching."""
MIN_LIGHT_INK = 1.5
"""Sum of red, green and blue from which an ink is the colour of light lines; otherwise the page shows it."""
BRIGHT_SHARE = 0.02
"""Share of the brightest pixels around a face that show the colour of paper or light."""


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
    darks = darkest_colors(page) if medium in (Medium.TONES, Medium.INK_OVER_TONES) else []
    darkest = float(
        np.dot(darks[0], page.encoding.weights) if darks and darks[0].size > 1 else sum(darks[:1])
    )
    marks = [
        marks_of(each, medium, is_light, luma, darkest, region, raster)
        for each, luma in zip(features, bright, strict=True)
    ]

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = page.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        ink = np.array(inks.pop(0), np.float32)
        dark = darks.pop(0) if darks else np.zeros_like(ink)
        for each, luma, found in zip(features, bright, marks, strict=True):
            area = plane_area(each.window, step)
            values = values_from_codes(plane[area], kind, page.encoding)
            drawn = values
            if found.clear is not None:
                ground = _ground(values, each, medium, step)
                drawn = drawn + _like(found.clear, values) * (ground - drawn)
            if found.light is not None:
                drawn = drawn * _like(found.light, values)
            if found.factor is not None:
                factor = np.minimum(found.factor, 1) if kind == "chroma" else found.factor
                drawn = dark + (drawn - dark) * _like(factor, values)
            if found.bright is not None:
                light = brightest_color(values, luma, BRIGHT_SHARE)
                drawn = drawn + _like(found.bright, values) * (light - drawn)
            if found.ink is not None:
                drawn = drawn + _like(found.ink, values) * (ink - drawn)
            plane[area] = codes_from_values(drawn, kind, page.encoding)
        return plane

    return page.map_planes(draw)


def _ground(values: np.ndarray, each: Features, medium: Medium, step: tuple[int, int]) -> np.ndarray:
    """Return what replaces letters, scan lines, dots and hatching under features."""
    height = each.face.box.height
    if medium is not Medium.INK:
        return local_mean(values, GROUND_RATIO * height, step)
    return skin_mean(values, _like(each.skin, values), SKIN_RATIO * height, step)


def _like(plane: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a plane at the size of samples, to be multiplied by them."""
    plane = resized(plane, values.shape[:2])
    return plane if values.ndim == 2 else plane[..., None]
