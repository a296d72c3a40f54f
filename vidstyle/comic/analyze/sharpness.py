"""Sharpness of a picture, and the fine detail that blur takes from a frame but not from its neighbours."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from vidstyle.comic.analyze.edges import (
    COARSE_DEVIATION_PX,
    FINE_DEVIATION_PX,
    edge_width_sharpness,
    measure_slopes,
    steepest_per_cell,
)

# Detail that other frames have.
DETAIL_ROWS, DETAIL_COLUMNS = 9, 16
"""Size of the grid on which detail is kept."""
_USUAL_SIDE_PX = 640
"""Longer side of a picture whose slopes are kept as they are; smaller pictures have steeper ones."""
_USUAL_PERCENTILE = 80
"""Percentile of the detail of neighbouring frames that a sharp frame has."""
_MIN_FINE_LEVELS, _MIN_TEXTURED_PARTS = 1.0, 12
"""Mean fine slope of a part with texture, of 255, and the number of such parts that can be compared."""
_MAX_DETAIL_RATIO, _MAX_FINENESS_RATIO = 0.8, 0.85
"""A blurred frame has less than these fractions of the usual detail and of the usual fineness.

They were tuned on seven films with blurred intervals, of known direction or of averaged frames, and on the
whole of five films: blurred frames have at most 0.76 and 0.83, of 900 others one has less.
"""

# The sharpest part of a picture.
FULL_FACE_DETAIL_LEVELS = 10.0
"""Detail of a face from which it survives being drawn, see `measure_detail`.

Of 30 faces on pages that two judges had seen, the six that were called dissolved have 4 to 8, others mostly
10 to 20.
"""
_MEASURED_PX = 360
"""Side of a square with the area of the copies that are measured."""
_CELL_COUNT, _PART_CELL_COUNT = 6, 2
"""The picture is divided into this many cells a side; overlapping parts of some cells a side are measured."""
_DETAIL_PERCENTILE = 98
"""Percentile of the slopes of a part that counts."""

# Resolution.
_STRONG_EDGE_PERCENTILE, _MIN_EDGE_HEIGHT_RATIO = 95, 0.5
"""Percentile of the slopes of a part that are its strong edges, and height of the edges of a part, relative
to the highest, from which its sharpness counts."""
_MIN_SLOPE_RATIO, _MIN_BLUR_DEVIATION_PX = 1.0001, 0.1
"""Minimum ratio of slopes under both Gaussians, of a very soft edge, and minimum blur of an edge."""

_CLUTTER_SLOPE_RANGE = 5.5, 7.5
"""Mean coarse slopes, of 255, of a picture without clutter and of one that is nothing but clutter.

They were tuned on 38 panels that judges had seen: crowds, machines and rigging that nobody could read have
6.7 to 8.1, panels with a readable subject up to 6.3.
"""


def measure_clutter(detail: np.ndarray) -> float:
    """Return how much a picture consists of edges, 0..1, by its detail, see `measure_sharpness`."""
    lowest, highest = _CLUTTER_SLOPE_RANGE
    slope = float(np.hypot(*detail[1].astype(np.float32)).mean())
    return float(np.clip((slope - lowest) / (highest - lowest), 0, 1))


def measure_sharpness(luma: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Measure the sharpness of a picture, H x W uint8.

    Returns:
        Its sharpness, 0 blurred, 1 perfectly sharp, see `edge_width_sharpness`; its detail: the mean slope of
        each part under a narrow and a wide Gaussian, across and down, 2 x 2 x rows x columns float16; and its
        edges: the steepest slope in each small cell, in the same order, see `steepest_per_cell`.
    """
    fine, coarse = (measure_slopes(luma, deviation) for deviation in (FINE_DEVIATION_PX, COARSE_DEVIATION_PX))
    size = DETAIL_COLUMNS, DETAIL_ROWS
    parts = [cv2.resize(each, size, interpolation=cv2.INTER_AREA) for each in (*fine, *coarse)]
    detail = np.array(parts, np.float32).reshape(2, 2, DETAIL_ROWS, DETAIL_COLUMNS)
    detail *= max(luma.shape) / _USUAL_SIDE_PX
    edges = np.array([[steepest_per_cell(each) for each in pair] for pair in (fine, coarse)])
    return edge_width_sharpness(fine, coarse), detail.astype(np.float16), edges


def lacks_detail(detail: np.ndarray, near: Sequence[np.ndarray]) -> bool:
    """Whether a frame lacks detail, along one axis, that most frames near it in its scene have.

    Both the fine slopes and their ratio to the coarse ones must be lower: if the content of the picture
    changes, both kinds of slopes change.

    Args:
        detail: of the frame, see `measure_sharpness`.
        near: of the frames near it, with the frame itself.
    """
    others = np.stack(list(near)).astype(np.float32)
    usual = np.percentile(others[:, 0], _USUAL_PERCENTILE, axis=0)
    sums = others.sum(axis=(3, 4)) + 1e-3
    most = np.percentile(sums[:, 0], _USUAL_PERCENTILE, axis=0)
    finest = np.percentile(sums[:, 0] / sums[:, 1], _USUAL_PERCENTILE, axis=0)
    own = detail.sum(axis=(2, 3), dtype=np.float32) + 1e-3
    for axis in range(2):
        textured = usual[axis] > _MIN_FINE_LEVELS
        if textured.sum() < _MIN_TEXTURED_PARTS:
            continue
        parts = float(np.median(detail[0, axis][textured] / usual[axis][textured]))
        fineness = own[0, axis] / own[1, axis] / finest[axis]
        if max(parts, own[0, axis] / most[axis]) < _MAX_DETAIL_RATIO and fineness < _MAX_FINENESS_RATIO:
            return True
    return False


def measure_resolution(luma: np.ndarray) -> float:
    """Return the resolution of a picture, H x W uint8: the root of its area, in widths of its blur.

    The blur of its sharpest part and its usual blur count alike, as a subject may be sharp before a soft
    background. Dense texture looks sharper than it is, also after enlarging.
    """
    fine, coarse = (
        np.hypot(*measure_slopes(luma, deviation)) for deviation in (FINE_DEVIATION_PX, COARSE_DEVIATION_PX)
    )
    edges = [_strong_edges(fine[part], coarse[part]) for part in _overlapping_parts(luma.shape)]
    highest = max(height for _, height in edges)
    clear = [ratio for ratio, height in edges if height >= _MIN_EDGE_HEIGHT_RATIO * highest]
    blur = _blur_deviation(max(clear)) * _blur_deviation(float(np.median([ratio for ratio, _ in edges])))
    return float(np.sqrt(luma.size / np.sqrt(blur)))


def _strong_edges(fine: np.ndarray, coarse: np.ndarray) -> tuple[float, float]:
    """Return the ratio of the slopes under both Gaussians at the strongest edges, and their height."""
    strong = coarse >= np.percentile(coarse, _STRONG_EDGE_PERCENTILE)
    height = float(coarse[strong].mean())
    return float(fine[strong].mean()) / max(height, 1e-6), height


def _blur_deviation(ratio: float) -> float:
    """Return the standard deviation, in pixels, of the Gaussian blur of an edge by that ratio of slopes."""
    squared = max(_MIN_SLOPE_RATIO, ratio) ** 2
    found = (COARSE_DEVIATION_PX**2 - squared * FINE_DEVIATION_PX**2) / (squared - 1)
    return float(np.sqrt(max(_MIN_BLUR_DEVIATION_PX**2, found)))


def measure_detail(color: np.ndarray) -> float:
    """Return the slope of the edges in the sharpest part of a picture, H x W x 3 uint8, of 255 per pixel.

    Soft surroundings of something sharp do not count.
    """
    factor = _MEASURED_PX / np.sqrt(color.shape[0] * color.shape[1])
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    size = (max(_CELL_COUNT, round(side * factor)) for side in color.shape[1::-1])
    luma = cv2.cvtColor(cv2.resize(color, tuple(size), interpolation=method), cv2.COLOR_RGB2GRAY)
    slopes = np.hypot(*measure_slopes(luma, FINE_DEVIATION_PX)) / 2
    parts = _overlapping_parts(slopes.shape)
    return max(float(np.percentile(slopes[part], _DETAIL_PERCENTILE)) for part in parts)


def _overlapping_parts(shape: tuple[int, ...]) -> list[tuple[slice, slice]]:
    """Return the rows and columns of the overlapping parts of a picture that are measured."""
    rows, columns = (
        [
            slice(start, max(start + 1, (first + _PART_CELL_COUNT) * side // _CELL_COUNT))
            for first in range(_CELL_COUNT - _PART_CELL_COUNT + 1)
            for start in [first * side // _CELL_COUNT]
        ]
        for side in shape
    )
    return [(row, column) for row in rows for column in columns]
