"""Anisotropic Kuwahara filter: the flat, brushed areas of an oil painting."""

from __future__ import annotations

import math
from itertools import product
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Margin, ResultRows, SavedRef, Slider, block
from vidstyle.core.kernels import aligned_empty, cached, compiled, index_at, interleaved
from vidstyle.core.kernels.sector_means import SECTOR_COUNT, SECTOR_LANES, mean_of_sectors, sector_sums
from vidstyle.core.kernels.sector_tables import pair_lists, pixel_pairs, square_means

Kernels = tuple[np.ndarray, np.ndarray, np.ndarray]

ORIENTATIONS, ANISOTROPIES = 32, 8
"""Kernels for which weights are tabulated."""
BORDERS = tuple(np.float32(math.tan((number + 0.5) * 2 * math.pi / ORIENTATIONS)) for number in range(4))
"""Tangents of the angles between neighbouring directions, in an eighth of a turn."""
STRIP = 64
"""Columns of a strip."""
ZERO_CROSSING = 0.58
"""Angle in radians at which the weights of a sector end, at its middle radius."""
BORDER = 1.0001
"""The squared radius of the ellipse: rounding must not decide about pixels just on it."""
SAMPLES = 4
"""From the middle of an ellipse to its border, at least, where they are not side by side."""
FALL = -3.125
"""The exponent by which weights fall off, at the border of the ellipse."""


def _spacing(radius: float) -> int:
    """Pixels from one sample to the next, odd: with it, large ellipses take the time of small ones."""
    return 2 * max(int((radius / SAMPLES - 1) / 2 + 0.001), 0) + 1  # rounding must not decide at 12, 20 ...


def _reach(radius: float, stretch: float) -> int:
    """Samples on each side of a pixel, at most."""
    return math.ceil(radius / _spacing(radius) * (1 + stretch))


def _radius(radius: float, stretch: float) -> int:
    spacing = _spacing(radius)
    return spacing * _reach(radius, stretch) + spacing // 2


@block("filter", on="color", radius=_radius)
def kuwahara(
    picture: np.ndarray,
    margin: Margin,
    out: ResultRows,
    flow: Annotated[Any, SavedRef("smoothed result of `structure_tensor`")] = "source",
    radius: Annotated[float, Slider(1, 8, "size of the brush", "px", explore=(3, 7))] = 5,
    stretch: Annotated[float, Slider(0, 1, "how much longer strokes are along edges than across")] = 1,
    sharpness: Annotated[int, Slider(0, 3, "how clearly areas are set apart", explore=(1, 3))] = 2,
) -> np.ndarray:
    """Flatten areas and sharpen the edges between them, with strokes along the edges: oil paint.

    Each pixel becomes a mean of the eight sectors of an ellipse along the flow, each weighted by
    1 / (1 + (255 v) ^ (2 ^ sharpness)), where v is the sector's variance, summed over channels. Kyprianidis,
    Kang and Döllner 2009, "Image and Video Abstraction by Anisotropic Kuwahara Filtering"; polynomial
    weights of sectors by Kyprianidis et al. 2010. Ellipses have one of 32 directions and 8 shapes. From a
    radius of 12 pixels on, squares of 3 x 3 pixels have the same weight, from 20 on 5 x 5, and so on. Colours
    are clipped to -1..2.
    """
    spacing, reach, height = _spacing(radius), _reach(radius, stretch), len(out)
    chosen = np.empty(out.shape[:2], np.int32)
    _choose(interleaved(flow[margin[0] : margin[0] + height]), chosen)
    kernels = _kernels(radius / spacing, stretch)
    if spacing == 1:
        around = pixel_pairs(picture, (margin[0] - reach, margin[0] + height + reach), reach)
        _run(around, reach, chosen, kernels, sharpness, out)
        return out
    means = square_means(picture, margin, _radius(radius, stretch), spacing)
    for top, left in product(range(min(spacing, height)), range(min(spacing, out.shape[1]))):
        grid = slice(top, None, spacing), slice(left, None, spacing)
        samples, part = means[grid], np.empty_like(out[grid], order="C")
        around = pixel_pairs(samples, (0, len(samples)), 0)
        _run(around, reach, np.ascontiguousarray(chosen[grid]), kernels, sharpness, part)
        out[grid] = part
    return out


def _run(
    around: np.ndarray, reach: int, chosen: np.ndarray, kernels: Kernels, sharpness: int, out: np.ndarray
) -> None:
    """Filter a picture, of which `around` has the pixel pairs and `reach` more of them on all sides."""
    starts, places, weights = kernels
    offsets = places[..., 0] * around.shape[1] + places[..., 1] * 4
    way, sums = (around.shape[1], reach), aligned_empty((2 * SECTOR_LANES * STRIP,)).view(np.int32)
    listed = starts, offsets, weights
    _filter(around.reshape(-1), way, chosen, listed, (0,) * (1 + sharpness), sums, interleaved(out))


@compiled
def _choose(flow, chosen):  # type: ignore[no-untyped-def]
    """The number of each pixel's kernel, by the vector of doubled angle and its length."""
    one, two, least, shapes = np.float32(1), np.float32(2), np.float32(1e-6), np.float32(ANISOTROPIES)
    for row in range(chosen.shape[0]):
        for x in range(chosen.shape[1]):
            across, down = two * flow[row, 3 * x] - one, two * flow[row, 3 * x + 1] - one
            clearness = np.sqrt(across * across + down * down) / max(flow[row, 3 * x + 2], least)
            shape = index_at(min(clearness, one) * shapes, ANISOTROPIES - 1)
            chosen[row, x] = np.int32(_orientation(across, down) * np.int32(ANISOTROPIES)) + shape


@compiled
def _orientation(x, y):  # type: ignore[no-untyped-def]
    """The direction nearest to a vector, int32: counted in an eighth of a turn, and from there on."""
    longer, shorter, number = max(abs(x), abs(y)), min(abs(x), abs(y)), np.int32(0)
    for border in BORDERS:
        number = np.int32(number + np.int32(shorter > border * longer))
    number = np.int32(ORIENTATIONS // 4 - number) if abs(y) > abs(x) else number
    number = np.int32(ORIENTATIONS // 2 - number) if x < np.float32(0) else number
    number = np.int32(ORIENTATIONS - number) if y < np.float32(0) else number
    return np.int32(number & np.int32(ORIENTATIONS - 1))


@cached(maxsize=8)
def _kernels(radius: float, stretch: float) -> Kernels:
    """Where the pairs of each kernel begin; their rows and columns, n x 4 x 2, and weights, n x 4 x 4.

    They are four lists side by side, as `sector_sums` reads them.
    """
    kernels = [
        pair_lists(*_kernel(radius, stretch, orientation, shape))
        for orientation in range(ORIENTATIONS)
        for shape in range(ANISOTROPIES)
    ]
    places, weights = (np.concatenate(parts) for parts in zip(*kernels, strict=True))
    return np.cumsum([0] + [len(each) for each, _ in kernels]), places, weights


def _kernel(radius: float, stretch: float, orientation: int, shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the samples in half an ellipse, n x 2, and their weights in each sector, n x 8.

    The other half lies opposite, with the same weights in the opposite sectors.
    """
    longer, reach = 1 + stretch * (shape + 0.5) / ANISOTROPIES, _reach(radius, stretch)
    angle = math.pi * (orientation / ORIENTATIONS + 0.5)  # of the edge; the gradient's is a right angle less
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    along = (math.cos(angle) * columns + math.sin(angle) * rows) / (radius * longer)
    across = (math.cos(angle) * rows - math.sin(angle) * columns) / (radius / longer)
    inside = along**2 + across**2 <= BORDER
    along, across = along[inside], across[inside]
    lift = 2 / radius
    narrowness = (lift + math.cos(ZERO_CROSSING)) / math.sin(ZERO_CROSSING) ** 2
    turns = 2 * math.pi * np.arange(SECTOR_COUNT) / SECTOR_COUNT
    ahead = np.outer(along, np.cos(turns)) + np.outer(across, np.sin(turns))
    aside = np.outer(across, np.cos(turns)) - np.outer(along, np.sin(turns))
    weights = np.maximum(ahead + lift - narrowness * aside**2, 0) ** 2
    weights *= (np.exp(FALL * (along**2 + across**2)) / weights.sum(axis=1))[:, None]
    places, weights = np.argwhere(inside) - reach, weights / weights.sum(axis=0)
    middle = len(places) // 2
    weights[middle] /= 2  # its own opposite
    return places[middle:], weights[middle:]


@compiled
def _filter(around, way, chosen, kernels, squarings, sums, out):  # type: ignore[no-untyped-def]
    """A mean over the sectors of the kernel that is chosen for each pixel.

    In strips of columns, whose rows stay in the first-level cache.

    Args:
        sums: scratch, see `sector_sums`, for each pixel of a strip's row.
    """
    (columns, reach), (starts, offsets, weights), width = way, kernels, chosen.shape[1]
    for left in range(0, width, STRIP):
        right = min(left + STRIP, width)
        for row in range(chosen.shape[0]):
            first = (row + reach) * columns + 4 * (reach + 1)
            for x in range(left, right):
                begin, end = starts[chosen[row, x]], starts[chosen[row, x] + 1]
                place = 2 * SECTOR_LANES * (x - left)
                sector_sums(around, first + 4 * x, offsets, weights, begin, end, sums, place)
            for x in range(left, right):
                mean_of_sectors(sums, 2 * SECTOR_LANES * (x - left), squarings, out[row], 3 * x)
