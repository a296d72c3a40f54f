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

ORIENTATION_COUNT, ANISOTROPY_COUNT = 32, 8
"""Numbers of directions and shapes of ellipses for which weights are tabulated."""
BORDER_TANGENTS = tuple(
    np.float32(math.tan((number + 0.5) * 2 * math.pi / ORIENTATION_COUNT)) for number in range(4)
)
"""Tangents of the angles halfway between neighbouring directions, in an eighth of a turn."""
STRIP_COLUMNS = 64
"""Width of a strip, whose rows stay in the first-level cache."""
ZERO_CROSSING_RADIANS = 0.58
"""Angle at which the weights of a sector end, at its middle radius."""
MAX_SQUARED_RADIUS = 1.0001
"""The squared radius of the ellipse, slightly above 1 so that rounding does not decide about pixels on the
border."""
MIN_SAMPLE_COUNT = 4
"""Minimum number of samples from the middle of an ellipse to its border, if not every pixel is sampled."""
FALLOFF_EXPONENT = -3.125
"""Exponent of the Gaussian weight at the border of the ellipse."""


def _spacing(radius: float) -> int:
    """Return the distance of samples in pixels, odd; it keeps large ellipses as fast as small ones."""
    # Rounding must not decide at 12, 20 ...
    return 2 * max(int((radius / MIN_SAMPLE_COUNT - 1) / 2 + 0.001), 0) + 1


def _reach(radius: float, stretch: float) -> int:
    """Return the maximum number of samples on each side of a pixel."""
    return math.ceil(radius / _spacing(radius) * (1 + stretch))


def _radius(radius: float, stretch: float) -> int:
    spacing = _spacing(radius)
    return spacing * _reach(radius, stretch) + spacing // 2


@block(
    "filter",
    on="color",
    radius=_radius,
    label="Oil paint",
    category="paint",
    aliases=(
        "painting, brush, brush strokes, flat, flatten, simplify, abstract, anime, cartoon, toon, "
        "watercolor, watercolour, smooth, denoise, artistic, acrylic, gouache, wash"
    ),
)
def kuwahara(
    picture: np.ndarray,
    margin: Margin,
    out: ResultRows,
    flow: Annotated[Any, SavedRef("smoothed edge directions", label="Direction from")] = "source",
    radius: Annotated[float, Slider(1, 8, "size of the brush", "px", explore=(3, 7), label="Brush size")] = 5,
    stretch: Annotated[
        float, Slider(0, 1, "elongation of strokes along edges; 0 for circles", label="Stroke length")
    ] = 1,
    sharpness: Annotated[
        int, Slider(0, 3, "how sharply areas are separated", explore=(1, 3), label="Edge sharpness")
    ] = 2,
) -> np.ndarray:
    """Paint in flat dabs with crisp edges, like oil paint.

    Areas are flattened, and the edges between them sharpened, with strokes along the edges. Each pixel
    becomes the mean of the eight sectors of an ellipse along the flow, each weighted by 1 / (1 + (255 v)
    ^ (2 ^ sharpness)), where v is the sector's variance, summed over channels. Kyprianidis, Kang and
    Döllner 2009, "Image and Video Abstraction by Anisotropic Kuwahara Filtering"; polynomial weights of
    sectors by Kyprianidis et al. 2010. Ellipses have one of 32 directions and 8 shapes. From a radius of
    12 pixels on, squares of 3 x 3 pixels share a weight, from 20 on squares of 5 x 5, and so on. Colours
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
    """Filter a picture; `around` holds its pixel pairs, with `reach` additional ones on all sides."""
    starts, places, weights = kernels
    offsets = places[..., 0] * around.shape[1] + places[..., 1] * 4
    way, sums = (around.shape[1], reach), aligned_empty((2 * SECTOR_LANES * STRIP_COLUMNS,)).view(np.int32)
    listed = starts, offsets, weights
    _filter(around.reshape(-1), way, chosen, listed, (0,) * (1 + sharpness), sums, interleaved(out))


@compiled
def _choose(flow, chosen):  # type: ignore[no-untyped-def]
    """Choose the kernel of each pixel by the vector of the doubled angle and its length."""
    one, two, least, shapes = np.float32(1), np.float32(2), np.float32(1e-6), np.float32(ANISOTROPY_COUNT)
    for row in range(chosen.shape[0]):
        for x in range(chosen.shape[1]):
            across, down = two * flow[row, 3 * x] - one, two * flow[row, 3 * x + 1] - one
            clearness = np.sqrt(across * across + down * down) / max(flow[row, 3 * x + 2], least)
            shape = index_at(min(clearness, one) * shapes, ANISOTROPY_COUNT - 1)
            chosen[row, x] = np.int32(_orientation(across, down) * np.int32(ANISOTROPY_COUNT)) + shape


@compiled
def _orientation(x, y):  # type: ignore[no-untyped-def]
    """Return the direction nearest to a vector, int32: found within an eighth of a turn, then mirrored."""
    longer, shorter, number = max(abs(x), abs(y)), min(abs(x), abs(y)), np.int32(0)
    for border in BORDER_TANGENTS:
        number = np.int32(number + np.int32(shorter > border * longer))
    number = np.int32(ORIENTATION_COUNT // 4 - number) if abs(y) > abs(x) else number
    number = np.int32(ORIENTATION_COUNT // 2 - number) if x < np.float32(0) else number
    number = np.int32(ORIENTATION_COUNT - number) if y < np.float32(0) else number
    return np.int32(number & np.int32(ORIENTATION_COUNT - 1))


@cached(maxsize=8)
def _kernels(radius: float, stretch: float) -> Kernels:
    """Return the first pair of each kernel, rows and columns (n x 4 x 2), and weights (n x 4 x 4).

    They are four interleaved lists, as `sector_sums` reads them.
    """
    kernels = [
        pair_lists(*_kernel(radius, stretch, orientation, shape))
        for orientation in range(ORIENTATION_COUNT)
        for shape in range(ANISOTROPY_COUNT)
    ]
    places, weights = (np.concatenate(parts) for parts in zip(*kernels, strict=True))
    return np.cumsum([0] + [len(each) for each, _ in kernels]), places, weights


def _kernel(radius: float, stretch: float, orientation: int, shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and columns of the samples in half an ellipse, n x 2, and their sector weights, n x 8.

    The other half is point-symmetric, with the same weights in the opposite sectors.
    """
    longer, reach = 1 + stretch * (shape + 0.5) / ANISOTROPY_COUNT, _reach(radius, stretch)
    # Along the edge; the gradient's angle is a right angle less.
    angle = math.pi * (orientation / ORIENTATION_COUNT + 0.5)
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    along = (math.cos(angle) * columns + math.sin(angle) * rows) / (radius * longer)
    across = (math.cos(angle) * rows - math.sin(angle) * columns) / (radius / longer)
    inside = along**2 + across**2 <= MAX_SQUARED_RADIUS
    along, across = along[inside], across[inside]
    lift = 2 / radius
    narrowness = (lift + math.cos(ZERO_CROSSING_RADIANS)) / math.sin(ZERO_CROSSING_RADIANS) ** 2
    turns = 2 * math.pi * np.arange(SECTOR_COUNT) / SECTOR_COUNT
    ahead = np.outer(along, np.cos(turns)) + np.outer(across, np.sin(turns))
    aside = np.outer(across, np.cos(turns)) - np.outer(along, np.sin(turns))
    weights = np.maximum(ahead + lift - narrowness * aside**2, 0) ** 2
    weights *= (np.exp(FALLOFF_EXPONENT * (along**2 + across**2)) / weights.sum(axis=1))[:, None]
    places, weights = np.argwhere(inside) - reach, weights / weights.sum(axis=0)
    middle = len(places) // 2
    weights[middle] /= 2  # is its own opposite
    return places[middle:], weights[middle:]


@compiled
def _filter(around, way, chosen, kernels, squarings, sums, out):  # type: ignore[no-untyped-def]
    """Compute the mean over the sectors of the kernel chosen for each pixel.

    It runs in strips of columns, whose rows stay in the first-level cache.

    Args:
        sums: scratch for each pixel of a strip's row, see `sector_sums`.
    """
    (columns, reach), (starts, offsets, weights), width = way, kernels, chosen.shape[1]
    for left in range(0, width, STRIP_COLUMNS):
        right = min(left + STRIP_COLUMNS, width)
        for row in range(chosen.shape[0]):
            first = (row + reach) * columns + 4 * (reach + 1)
            for x in range(left, right):
                begin, end = starts[chosen[row, x]], starts[chosen[row, x] + 1]
                place = 2 * SECTOR_LANES * (x - left)
                sector_sums(around, first + 4 * x, offsets, weights, begin, end, sums, place)
            for x in range(left, right):
                mean_of_sectors(sums, 2 * SECTOR_LANES * (x - left), squarings, out[row], 3 * x)
