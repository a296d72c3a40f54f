"""Anisotropic Kuwahara filter: the flat, brushed areas of an oil painting."""

from __future__ import annotations

import math
from typing import Annotated, Any

import cv2
import numpy as np

from vidstyle.block import Margin, ResultRows, SavedRef, Slider, block
from vidstyle.core.kernels import aligned_empty, cached, compiled, index_at, interleaved
from vidstyle.core.kernels.sector_means import HALF, SECTORS, sector_means

ORIENTATIONS, ANISOTROPIES = 32, 8
"""Kernels for which weights are tabulated."""
TURNS = range(0, SECTORS, 2)
"""Sectors at which four neighbouring ones may begin."""
OUTSIDE = np.array([[(each - turn) % SECTORS >= HALF for turn in TURNS] for each in range(SECTORS)], float)
"""By sector and turn, 1 where the sector is not one of the four."""
ZERO_CROSSING = 0.58
"""Angle in radians at which the weights of a sector end, at its middle radius."""
BORDER = 1.0001
"""The squared radius of the ellipse: rounding must not decide about pixels just on it."""
FALL = -3.125
"""The exponent by which weights fall off, at the border of the ellipse."""


def _radius(radius: float, stretch: float) -> int:
    return math.ceil(radius * (1 + stretch))


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
    weights of sectors by Kyprianidis et al. 2010. Ellipses have one of 32 directions and 8 shapes.
    """
    starts, places, weights = _kernels(radius, stretch)
    reach, (height, width) = _radius(radius, stretch), out.shape[:2]
    around = aligned_empty((height + 2 * reach, width + 2 * reach, 4))
    _surround(interleaved(picture), margin[0] - reach, reach, interleaved(around))
    chosen = _chosen_kernels(flow[margin[0] : margin[0] + height])
    offsets = (places[..., 0] * around.shape[1] + places[..., 1]) * 4
    kernels, squarings = (starts, offsets, weights), (0,) * (1 + sharpness)
    _filter(around.reshape(-1), (around.shape[1], reach), chosen, kernels, squarings, interleaved(out))
    return out


def _chosen_kernels(flow: np.ndarray) -> np.ndarray:
    """The number of each pixel's kernel, H x W int32."""
    x, y, clearness = np.empty((3, *flow.shape[:2]), np.float32)
    _split_flow(interleaved(flow), x, y, clearness)
    chosen = np.empty(flow.shape[:2], np.int32)
    _choose(cv2.phase(x, y), clearness, chosen)
    return chosen


@compiled
def _split_flow(flow, x, y, clearness):  # type: ignore[no-untyped-def]
    """The vector of doubled angle, and its length by the strength of the edge."""
    one, two, least = np.float32(1), np.float32(2), np.float32(1e-6)
    for row in range(x.shape[0]):
        for i in range(x.shape[1]):
            across, down = two * flow[row, 3 * i] - one, two * flow[row, 3 * i + 1] - one
            x[row, i], y[row, i] = across, down
            clearness[row, i] = np.sqrt(across * across + down * down) / max(flow[row, 3 * i + 2], least)


@compiled
def _choose(phase, clearness, chosen):  # type: ignore[no-untyped-def]
    per_turn, shapes = np.float32(ORIENTATIONS / (2 * math.pi)), np.float32(ANISOTROPIES)
    for row in range(chosen.shape[0]):
        for x in range(chosen.shape[1]):
            orientation = index_at(phase[row, x] * per_turn + np.float32(0.5), ORIENTATIONS)
            orientation = np.int32(0) if orientation == ORIENTATIONS else orientation
            shape = index_at(min(clearness[row, x], np.float32(1)) * shapes, ANISOTROPIES - 1)
            chosen[row, x] = orientation * ANISOTROPIES + shape


@cached(maxsize=8)
def _kernels(radius: float, stretch: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the samples of each kernel begin; their rows and columns, n x 2 x 2, and weights, n x 2 x 4.

    They are two lists side by side, as `sector_means` reads them.
    """
    kernels = [
        _in_two_lists(*_kernel(radius, stretch, orientation, shape))
        for orientation in range(ORIENTATIONS)
        for shape in range(ANISOTROPIES)
    ]
    places, weights = (np.concatenate(parts) for parts in zip(*kernels, strict=True))
    return np.cumsum([0] + [len(each) for each, _ in kernels]), places, weights.astype(np.float32)


def _in_two_lists(places: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Samples by whether the sectors that they lie in are among 0 to 3, or 2 to 5.

    Those among the opposite four are turned round. One that lies in more sectors counts as two.
    """
    fits = weights @ OUTSIDE == 0
    lists: list[list[tuple[int, int]]] = [[], []]  # samples, and the first sector of their four weights
    for sample, fitting in enumerate(fits.tolist()):
        possible = [turn for turn, fit in zip(TURNS, fitting, strict=True) if fit] or [0, 2]
        turn = min(possible, key=lambda turn: len(lists[turn // 2 % 2]))
        lists[turn // 2 % 2] += [(sample, turn)] if any(fitting) else [(sample, turn), (sample, turn + HALF)]
    length = max(map(len, lists))
    listed_places, listed_weights = np.zeros((length, 2, 2), np.int64), np.zeros((length, 2, HALF))
    for column, each in enumerate(lists):
        samples, turns = np.array(each, np.int64).reshape(-1, 2, 1).swapaxes(0, 1)
        listed_places[: len(each), column] = places[samples[:, 0]] * np.where(turns < HALF, 1, -1)
        listed_weights[: len(each), column] = weights[samples, (turns + np.arange(HALF)) % SECTORS]
    return listed_places, listed_weights


def _kernel(radius: float, stretch: float, orientation: int, shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the samples in half an ellipse, n x 2, and their weights in each sector, n x 8.

    The other half lies opposite, with the same weights in the opposite sectors.
    """
    longer, reach = 1 + stretch * (shape + 0.5) / ANISOTROPIES, _radius(radius, stretch)
    angle = math.pi * (orientation / ORIENTATIONS + 0.5)  # of the edge; the gradient's is a right angle less
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    along = (math.cos(angle) * columns + math.sin(angle) * rows) / (radius * longer)
    across = (math.cos(angle) * rows - math.sin(angle) * columns) / (radius / longer)
    inside = along**2 + across**2 <= BORDER
    along, across = along[inside], across[inside]
    lift = 2 / radius
    narrowness = (lift + math.cos(ZERO_CROSSING)) / math.sin(ZERO_CROSSING) ** 2
    turns = 2 * math.pi * np.arange(SECTORS) / SECTORS
    ahead = np.outer(along, np.cos(turns)) + np.outer(across, np.sin(turns))
    aside = np.outer(across, np.cos(turns)) - np.outer(along, np.sin(turns))
    weights = np.maximum(ahead + lift - narrowness * aside**2, 0) ** 2
    weights *= (np.exp(FALL * (along**2 + across**2)) / weights.sum(axis=1))[:, None]
    places, weights = np.argwhere(inside) - reach, weights / weights.sum(axis=0)
    middle = len(places) // 2
    weights[middle] /= 2  # its own opposite
    return places[middle:], weights[middle:]


@compiled
def _surround(picture, top, reach, out):  # type: ignore[no-untyped-def]
    """Red, green, blue and the sum of their squares from row `top` on, with those at the edge beyond it."""
    first, last = 4 * reach, out.shape[1] - 4 * reach
    for row in range(out.shape[0]):
        source = min(max(top + row, 0), picture.shape[0] - 1)
        for x in range(picture.shape[1] // 3):
            red, green, blue = picture[source, 3 * x], picture[source, 3 * x + 1], picture[source, 3 * x + 2]
            at = first + 4 * x
            out[row, at], out[row, at + 1], out[row, at + 2] = red, green, blue
            out[row, at + 3] = red * red + green * green + blue * blue
        for i in range(first):
            out[row, i], out[row, last + i] = out[row, first + i % 4], out[row, last - 4 + i % 4]


@compiled
def _filter(around, way, chosen, kernels, squarings, out):  # type: ignore[no-untyped-def]
    """A mean over the sectors of the kernel that is chosen for each pixel; see `sector_means`."""
    (columns, reach), (starts, offsets, weights), width = way, kernels, chosen.shape[1]
    for row in range(chosen.shape[0]):
        line, first = out[row], 4 * ((row + reach) * columns + reach)
        for x in range(width):
            kernel = chosen[row, x]
            begin, end, pixel = starts[kernel], starts[kernel + 1], first + 4 * x
            sector_means(around, pixel, offsets, weights, begin, end, squarings, line, 3 * x)
