"""Anisotropic Kuwahara filter: the flat, brushed areas of an oil painting."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Any

import cv2
import numpy as np

from vidstyle.block import SavedRef, Slider, block
from vidstyle.core.kernels import compiled
from vidstyle.core.weighted_sums import weighted_sums

ORIENTATIONS, ANISOTROPIES, SECTORS = 32, 8, 8
"""Kernels for which weights are tabulated, and sectors of each kernel."""
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
    margin, (height, width) = _radius(radius, stretch), picture.shape[:2]
    squares = np.einsum("yxc,yxc->yx", picture, picture)
    around = cv2.copyMakeBorder(np.dstack([picture, squares]), *(margin,) * 4, cv2.BORDER_REPLICATE)
    offsets = ((places[:, 0] + margin) * around.shape[1] + places[:, 1] + margin) * 4
    out, sums = np.empty((height, width, 3), np.float32), np.empty((4, SECTORS), np.float32)
    kernels = starts, offsets, weights
    _filter(around.reshape(-1), around.shape[1], _chosen_kernels(flow), kernels, sharpness, sums, out)
    return out


def _chosen_kernels(flow: np.ndarray) -> np.ndarray:
    """The number of each pixel's kernel, H x W int32."""
    x, y = (2 * flow[..., 0] - 1, 2 * flow[..., 1] - 1)
    turns = cv2.phase(x, y) * np.float32(ORIENTATIONS / (2 * math.pi))
    clearness = np.sqrt(x * x + y * y) / np.maximum(flow[..., 2], np.float32(1e-6))
    # fmin and fmax leave no NaN, which would be an index anywhere.
    orientation = np.fmax(np.fmin(np.floor(turns + np.float32(0.5)), ORIENTATIONS), 0).astype(np.int32)
    shape = np.fmax(np.fmin(clearness * ANISOTROPIES, ANISOTROPIES - 1), 0).astype(np.int32)
    return orientation % ORIENTATIONS * ANISOTROPIES + shape


@lru_cache(maxsize=8)
def _kernels(radius: float, stretch: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the samples of each kernel begin; their rows and columns; their weights in each sector."""
    kernels = [
        _kernel(radius, stretch, orientation, shape)
        for orientation in range(ORIENTATIONS)
        for shape in range(ANISOTROPIES)
    ]
    places, weights = (np.concatenate(parts) for parts in zip(*kernels, strict=True))
    return np.cumsum([0] + [len(each) for each, _ in kernels]), places, weights.astype(np.float32)


def _kernel(radius: float, stretch: float, orientation: int, shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the samples in an ellipse, n x 2, and their weights in each sector, n x 8."""
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
    return np.argwhere(inside) - reach, weights / weights.sum(axis=0)


@compiled(fastmath=True)
def _filter(around, columns, chosen, kernels, sharpness, sums, out):  # type: ignore[no-untyped-def]
    """Each channel's mean over the sectors of the chosen kernel; `around` holds four numbers a pixel."""
    zero, one, levels = np.float32(0), np.float32(1), np.float32(255)
    starts, offsets, weights = kernels
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            kernel, pixel = chosen[row, x], 4 * (row * columns + x)
            weighted_sums(around, pixel, offsets, weights, starts[kernel], starts[kernel + 1], sums)
            total, red, green, blue = zero, zero, zero, zero
            for sector in range(SECTORS):
                r, g, b = sums[0, sector], sums[1, sector], sums[2, sector]
                variance = levels * abs(sums[3, sector] - r * r - g * g - b * b)
                for _ in range(sharpness):
                    variance *= variance
                share = one / (one + variance)
                total += share
                red += share * r
                green += share * g
                blue += share * b
            out[row, x, 0], out[row, x, 1], out[row, x, 2] = red / total, green / total, blue / total
