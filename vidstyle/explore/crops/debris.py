"""What a style adds to a crop: structure in smooth areas, and halos along edges."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.explore.measure import band_pass, gradient_of

SMOOTH_DEVIATION_PX, MAX_SMOOTH_GRADIENT = 3, 0.0025
"""Blur that removes noise, and the gradient below which the source is smooth after it."""
SMOOTH_MARGIN_PX, MIN_SMOOTH_SHARE = 9, 0.03
"""Side of the square that must be smooth around a pixel, and the share of a crop from which it counts."""
ADDED_BAND_PX, NEIGHBOURHOOD_PX = (1, 6), 10
"""Standard deviations of the two blurs between which added structure is seen, and of its local mean."""
EDGE_DEVIATION_PX, EDGE_PERCENTILE, MIN_EDGE = 1.5, 92, 0.02
HALO_DISTANCES_PX, AREA_DISTANCES_PX = (3, 9), (14, 40)
"""Distances from an edge between which a halo is bright, and between which its area is compared."""
AREA_DEVIATION_PX, BRIGHT_DEVIATION_PX = 20, 12
MIN_AREA_WEIGHT, MIN_HALO_PIXELS = 0.02, 200
BLACK_PERCENTILE, WHITE_PERCENTILE, MIN_STRETCHED_RANGE = 1, 99, 0.1
"""Percentiles of luma that become black and white in a stretched picture, and their least distance."""


class Added(NamedTuple):
    """Mean height of structure in smooth areas, its deviation between places, and mean height of halos.

    The height of halos is less that of the source with the contrast stretched to the full range.
    """

    debris: float
    patchiness: float
    halo: float


class SourceAreas:
    """Smooth areas and surroundings of edges of a source, luma 0..1, H x W float32."""

    def __init__(self, luma: np.ndarray) -> None:
        smooth = gradient_of(_blurred(luma, SMOOTH_DEVIATION_PX)) < MAX_SMOOTH_GRADIENT
        square = np.ones((SMOOTH_MARGIN_PX, SMOOTH_MARGIN_PX))
        self._smooth = cv2.erode(smooth.astype(np.uint8), square).astype(np.float32)
        away = _edge_distances(luma)
        is_bright = luma > _blurred(luma, BRIGHT_DEVIATION_PX)
        self._near, self._far = (
            (is_bright & (away > low) & (away < high)).astype(np.float32)
            for low, high in (HALO_DISTANCES_PX, AREA_DISTANCES_PX)
        )
        # Detail of the picture is no halo, even if a style stretches contrast.
        self._own_halo = self._bright_rims(_stretched(luma))

    def added(self, luma: np.ndarray) -> Added:
        """Return what a style adds, from the luma of its result."""
        return Added(*self._structure(luma), self._bright_rims(luma) - self._own_halo)

    def _structure(self, luma: np.ndarray) -> tuple[float, float]:
        if self._smooth.mean() <= MIN_SMOOTH_SHARE:
            return 0.0, 0.0
        weights = np.maximum(_blurred(self._smooth, NEIGHBOURHOOD_PX), 0.05)
        local = _blurred(np.abs(band_pass(luma, *ADDED_BAND_PX)) * self._smooth, NEIGHBOURHOOD_PX) / weights
        inside = local[self._smooth > 0]
        return float(inside.mean()), float(inside.std())

    def _bright_rims(self, luma: np.ndarray) -> float:
        weights = _blurred(self._far, AREA_DEVIATION_PX)
        area = _blurred(luma * self._far, AREA_DEVIATION_PX) / np.maximum(weights, 1e-3)
        near = (self._near > 0) & (weights > MIN_AREA_WEIGHT)
        return float(np.clip(luma - area, 0, 1)[near].mean()) if near.sum() > MIN_HALO_PIXELS else 0.0


def _stretched(luma: np.ndarray) -> np.ndarray:
    low, high = np.percentile(luma, (BLACK_PERCENTILE, WHITE_PERCENTILE))
    return np.clip((luma - low) / max(high - low, MIN_STRETCHED_RANGE), 0, 1).astype(np.float32)


def _edge_distances(luma: np.ndarray) -> np.ndarray:
    """Return the distance of each pixel from the nearest edge in pixels."""
    gradient = gradient_of(_blurred(luma, EDGE_DEVIATION_PX))
    edges = gradient > max(float(np.percentile(gradient, EDGE_PERCENTILE)), MIN_EDGE)
    return cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 3)


def _blurred(luma: np.ndarray, deviation: float) -> np.ndarray:
    return cv2.GaussianBlur(luma, (0, 0), deviation)
