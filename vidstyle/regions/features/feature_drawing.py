"""Draws lifted eyes, noses and mouths over a restyled picture, in the colours of the style."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import codes_from_values, values_from_codes
from vidstyle.regions.features.blurring import enlarged, resized
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.feature_marks import FeatureMarks, ink_marks, tone_marks
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.page_colors import darkest_colors, local_mean, masked_mean
from vidstyle.regions.patches import plane_area
from vidstyle.regions.rasters import PageRaster
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import Style

GROUND_RATIO, TONE_RATIO = 0.25, 0.06
"""Sides of the squares whose mean between marks of ink, and of grain and scan lines, is the ground, relative
to the face's height."""


def draw_features(
    page: Picture,
    features: Sequence[Features],
    style: Style,
    region: np.ndarray | None,
    raster: PageRaster,
) -> Picture:
    """Return a picture with features over it.

    Styles of ink draw them in ink; other styles get the tones of the face, above the page's darkest colour.

    Args:
        page: the restyled picture; only read.
        features: the features.
        style: its ink is the colour.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        raster: its dots and squares.
    """
    color, paper = rgb_from_text(style.ink), rgb_from_text(style.paper)
    ink_luma, *chroma = page.encoding.yuv_from_color(color)
    inks = [
        *((ink_luma,) if page.luma is not None else ()),
        *(chroma if page.chroma else ()),
        *((color,) if page.color is not None else ()),
    ]
    medium = Medium.of(style, raster)
    darks = darkest_colors(page) if medium is Medium.TONES else []
    darkest = float(
        np.dot(darks[0], page.encoding.weights) if darks and darks[0].size > 1 else sum(darks[:1])
    )
    ends = ink_luma, page.encoding.yuv_from_color(paper)[0]
    marks, free = list[FeatureMarks](), np.ones(page.shape, np.float32)
    for each in features:
        luma, area = luma_in(page, each.window), plane_area(each.window, (1, 1))
        weight = enlarged(each.weight, luma.shape) * free[area]
        free[area] -= weight
        if region is not None:
            weight = weight * region[area]
        if medium is Medium.INK:
            marks.append(ink_marks(each, weight, luma, ends, raster))
        else:
            marks.append(tone_marks(each, weight, luma, darkest))

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = page.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        ink = np.array(inks.pop(0), np.float32)
        dark = darks.pop(0) if darks else np.zeros_like(ink)
        for each, found in zip(features, marks, strict=True):
            area = plane_area(each.window, step)
            values = values_from_codes(plane[area], kind, page.encoding)
            ground = _ground(values, found.ground, each.face.box.height, step)
            drawn = values + _like(found.clear, values) * (ground - values)
            if found.light is not None:
                drawn = drawn * _like(found.light, values)
            if found.factor is not None:
                factor = np.minimum(found.factor, 1) if kind == "chroma" else found.factor
                drawn = dark + (drawn - dark) * _like(factor, values)
            if found.ink is not None:
                drawn = drawn + _like(found.ink, values) * (ink - drawn)
            plane[area] = codes_from_values(drawn, kind, page.encoding)
        return plane

    return page.map_planes(draw)


def _ground(values: np.ndarray, seen: np.ndarray | None, height: float, step: tuple[int, int]) -> np.ndarray:
    """Return what is between marks: of ink, where it is seen, and of tones, the mean nearby."""
    if seen is None:
        return local_mean(values, TONE_RATIO * height, step)
    return masked_mean(values, _like(seen, values), GROUND_RATIO * height, step)


def _like(plane: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a plane at the size of samples, to be multiplied by them."""
    plane = resized(plane, values.shape[:2])
    return plane if values.ndim == 2 else plane[..., None]
