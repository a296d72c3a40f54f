"""Colours of a restyled picture around a face."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import values_from_codes
from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.patches import plane_area

MAX_SAMPLES = 16_384
"""Samples that are measured for the brightest colour, at most."""


def brightest_color(
    values: np.ndarray, luma: np.ndarray, share: float, where: np.ndarray | None = None
) -> np.ndarray:
    """Return the mean of the samples where luma is highest, of `MAX_SAMPLES` at most.

    Args:
        values: samples, of luma's size or a fraction of it.
        luma: of the page, H x W float32.
        share: of the pixels that count as bright.
        where: which pixels count, H x W float32: above 0.5, or all if none are. None: all.
    """
    every = max(1, round((luma.size / MAX_SAMPLES) ** 0.5))
    luma = luma[::every, ::every]
    values = cv2.resize(values, luma.shape[::-1], interpolation=cv2.INTER_NEAREST)
    if where is not None and (inside := where[::every, ::every] > 0.5).any():
        luma, values = luma[inside], values[inside]
    return np.asarray(values[luma >= np.quantile(luma, 1 - share)].mean(axis=0), np.float32)


def mean_chroma(page: Picture, window: Rectangle) -> float:
    """Return the larger mean size of the two chroma planes in a part of the page, 0..0.5."""
    planes = page.chroma or ()
    if page.color is not None:
        area = plane_area(window, (1, 1))
        values = values_from_codes(page.color[area], "color", page.encoding)
        chroma = cv2.transform(values, page.encoding.from_rgb[1:])
        return float(np.abs(chroma).mean(axis=(0, 1)).max())
    area = plane_area(window, page.encoding.subsampling)
    sizes = [np.abs(values_from_codes(plane[area], "chroma", page.encoding)).mean() for plane in planes]
    return float(max(sizes, default=0.0))


def local_mean(values: np.ndarray, size: float, step: tuple[int, int]) -> np.ndarray:
    """Return the mean of the samples nearby."""
    return cv2.blur(values, (max(1, round(size / step[0])), max(1, round(size / step[1]))))
