"""Takes writing off a picture, and keeps its strokes."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import PartLuma, codes_from_values, values_from_codes
from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.patches import plane_area
from vidstyle.regions.writing.finding import Writing, find_writing, thickness_of
from vidstyle.regions.writing.letters import letter_mask

STROKE_RANGE = 0.25, 0.75
"""Contrast at which a pixel begins to belong to a stroke, and from which it does fully, relative to the
strongest nearby."""
TRACE_RATIO = 0.2
"""Contrast from which nothing of a stroke is left, in the same way."""
MIN_STRENGTH_LEVEL = 20
"""Contrast of the strongest stroke nearby, at least, in 8-bit levels."""
NEAR_RATIO = 3
"""Side of the square that counts as nearby, relative to the thickness of strokes."""
WIDE_RATIO, WIDE_CONTRAST_RATIO = 5, 0.4
"""Side of the square that fills what is wider than strokes, relative to their thickness; and contrast to its
ground from which that counts, relative to the strongest stroke nearby."""
GROUND_RATIO = 3
"""Side of the square whose ground replaces strokes, relative to the thickness of strokes."""


class Strokes(NamedTuple):
    """The writing in a part of a picture.

    Attributes:
        window: the part.
        dark, light: coverage by dark and by light strokes, H x W float32, 0..1.
    """

    window: Rectangle
    dark: np.ndarray
    light: np.ndarray


def lift_writing(picture: Picture, amount: float) -> tuple[Picture, list[Strokes]]:
    """Return a picture without its writing, and that writing.

    Args:
        picture: is only read.
        amount: of the writing that is lifted, 0..1.
    """
    found = [_strokes(picture, each) for each in find_writing(picture)]
    lifted = [(strokes, amount * trace) for strokes, trace in found if trace.any()]
    if not lifted:
        return picture, []
    size = int(GROUND_RATIO * thickness_of(picture.shape))

    def erase(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = picture.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        for strokes, trace in lifted:
            area = plane_area(strokes.window, step)
            values = values_from_codes(plane[area], kind, picture.encoding)
            ground = _on_ground(values, trace, (size // step[0], size // step[1]))
            plane[area] = codes_from_values(ground, kind, picture.encoding)
        return plane

    dark = [Strokes(each.window, amount * each.dark, amount * each.light) for each, _ in lifted]
    return picture.map_planes(erase), dark


def _strokes(picture: Picture, writing: Writing) -> tuple[Strokes, np.ndarray]:
    """Return the strokes in a part of a picture, and how much each pixel has of any, H x W float32, 0..1."""
    luma = np.rint(255 * luma_in(picture, writing.window)).astype(np.uint8)
    size, trace = thickness_of(picture.shape), np.zeros_like(writing.dark)
    square, reach = np.ones((size, size), np.uint8), int(NEAR_RATIO * size)
    covers = []
    for weight, plane in ((writing.dark, luma), (writing.light, cv2.bitwise_not(luma))):
        if not weight.any():
            covers.append(weight)
            continue
        height = cv2.subtract(cv2.morphologyEx(plane, cv2.MORPH_CLOSE, square), plane)
        peak = cv2.blur(cv2.dilate(height, np.ones((reach, reach), np.uint8)), (size, size))
        share = cv2.divide(height, np.maximum(peak, np.uint8(MIN_STRENGTH_LEVEL)), dtype=cv2.CV_32F)
        strokes, near = _between(share, *STROKE_RANGE), cv2.dilate(share, np.ones((3, 3), np.uint8))
        cover = weight * strokes
        letters = letter_mask(cover, strokes, height, partial(_wider, plane, height, peak, size), size)
        if letters is None:
            covers.append(np.zeros_like(weight))
            continue
        covers.append(np.where(letters, cover, np.float32(0)))
        close = cv2.dilate(letters.astype(np.uint8), square) > 0
        trace = np.maximum(trace, np.where(close, weight * _between(near, 0, TRACE_RATIO), np.float32(0)))
    return Strokes(writing.window, *covers), trace


def _wider(plane: np.ndarray, height: np.ndarray, peak: np.ndarray, size: int) -> np.ndarray:
    """Return where something wider than strokes is as dark as they are, H x W uint8, 0 or 255.

    Args:
        plane: luma.
        height, peak: contrast of strokes, and the strongest nearby.
        size: width of strokes that count as thin.
    """
    reach = np.ones((WIDE_RATIO * size, WIDE_RATIO * size), np.uint8)
    ground = cv2.morphologyEx(plane, cv2.MORPH_CLOSE, reach)
    rest = cv2.subtract(cv2.subtract(ground, plane), height)
    return cv2.compare(rest, cv2.convertScaleAbs(peak, alpha=WIDE_CONTRAST_RATIO), cv2.CMP_GT)


def luma_in(picture: Picture, window: Rectangle) -> np.ndarray:
    """Return the luma of a part of a picture, H x W float32, 0..1."""
    return PartLuma(picture, plane_area(window, (1, 1))).luma


def _on_ground(values: np.ndarray, trace: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return a plane whose pixels with traces of strokes have the mean of the others nearby."""
    if trace.shape != values.shape[:2]:
        trace = cv2.resize(trace, values.shape[1::-1], interpolation=cv2.INTER_AREA)
    keep = 1 - trace + np.float32(1e-4)
    weight, total = keep, cv2.blur(keep, size)
    if values.ndim == 3:
        trace, weight, total = (np.repeat(each[..., None], 3, axis=2) for each in (trace, keep, total))
    return values + trace * (cv2.blur(values * weight, size) / total - values)


def _between(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return 0 at `low` and below, 1 at `high` and above."""
    return np.clip((values - np.float32(low)) / np.float32(high - low), 0, 1)
