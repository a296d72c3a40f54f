"""Draws faces with their lifted features over a restyled picture, in the colours of the style."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import codes_from_values, values_from_codes
from vidstyle.regions.features.blurring import enlarged
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.feature_marks import FeatureMarks, tone_marks
from vidstyle.regions.features.ink_marks import ink_marks
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.page_colors import darkest_colors, local_mean, masked_mean, plane_colors
from vidstyle.regions.features.windows import common_parts
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
    """Return a picture with faces drawn over it.

    Styles of ink draw them in ink; other styles get the tones of the face, above the page's darkest colour.

    Args:
        page: the restyled picture; only read.
        features: the features of the faces.
        style: its ink is the colour.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        raster: its dots and squares.
    """
    ink, paper = rgb_from_text(style.ink), rgb_from_text(style.paper)
    ends = page.encoding.yuv_from_color(ink)[0], page.encoding.yuv_from_color(paper)[0]
    inks, is_ink = plane_colors(page, ink), Medium.of(style, raster) is not Medium.TONES
    darks = [np.zeros_like(each) for each in inks] if is_ink else darkest_colors(page)
    darkest = _luma(darks[0], page)
    marks = [
        ink_marks(each, weight, luma_in(page, each.window), ends, raster)
        if is_ink
        else tone_marks(each, weight, luma_in(page, each.window), darkest)
        for each, weight in zip(features, _weights(features, region), strict=True)
    ]
    return _over(page, features, marks, list(zip(inks, darks, strict=True)))


def _luma(color: np.ndarray, page: Picture) -> float:
    """Return the luma of a value or a colour; see `plane_colors`."""
    return float(np.dot(color, page.encoding.weights) if color.size > 1 else color)


def _weights(features: Sequence[Features], region: np.ndarray | None) -> list[np.ndarray]:
    """Return how much of each face is drawn, H x W float32, 0..1: not where another one already is."""
    drawn = list[np.ndarray]()
    for each in features:
        free = np.ones((each.window.height, each.window.width), np.float32)
        for other, weight in zip(features, drawn, strict=False):
            rest, covered = common_parts(free, each.window, weight, other.window)
            rest -= covered
        drawn.append(enlarged(each.weight, free.shape) * free)
    if region is None:
        return drawn
    areas = [plane_area(each.window, (1, 1)) for each in features]
    return [weight * region[area] for weight, area in zip(drawn, areas, strict=True)]


def _over(
    page: Picture,
    features: Sequence[Features],
    marks: Sequence[FeatureMarks],
    colors: Sequence[tuple[np.ndarray, np.ndarray]],
) -> Picture:
    """Return a page with the layers of faces over it; `colors`: ink and darkest colour of each plane."""
    step, next_colors = page.encoding.subsampling, iter(colors)
    layers = {"luma": marks, "color": marks}
    if page.chroma:
        shapes = [page.chroma[0][plane_area(each.window, step)].shape for each in features]
        layers["chroma"] = [each.for_chroma(shape) for each, shape in zip(marks, shapes, strict=True)]

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in layers:
            return plane
        pitch, plane = step if kind == "chroma" else (1, 1), plane.copy()
        ink, dark = next(next_colors)
        for each, found in zip(features, layers[kind], strict=True):
            area = plane_area(each.window, pitch)
            values = values_from_codes(plane[area], kind, page.encoding)
            ground = _ground(values, found.ground, each.face.box.height, pitch)
            plane[area] = codes_from_values(_drawn(values, found, ground, ink, dark), kind, page.encoding)
        return plane

    return page.map_planes(draw)


def _drawn(
    values: np.ndarray, marks: FeatureMarks, ground: np.ndarray, ink: np.ndarray, dark: np.ndarray
) -> np.ndarray:
    """Return samples with layers of their height and width over them."""
    drawn = values + _like(marks.clear, values) * (ground - values)
    if marks.light is not None:
        drawn = drawn * _like(marks.light, values)
    if marks.factor is not None:
        drawn = dark + (drawn - dark) * _like(marks.factor, values)
    if marks.ink is not None:
        drawn = drawn + _like(marks.ink, values) * (ink - drawn)
    return drawn


def _ground(values: np.ndarray, seen: np.ndarray | None, height: float, step: tuple[int, int]) -> np.ndarray:
    """Return the local mean: between marks of ink by the weights `seen`, and in tones of all samples."""
    if seen is None:
        return local_mean(values, TONE_RATIO * height, step)
    return masked_mean(values, _like(seen, values), GROUND_RATIO * height, step)


def _like(plane: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a plane as a factor of samples: of each channel if they have several."""
    return plane if values.ndim == 2 else plane[..., None]
