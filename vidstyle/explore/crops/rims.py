"""Light rims along the edges of a crop, which make it look drawn."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.explore.crops.edge_distances import edge_distances

EDGE_DEVIATION_PX, EDGE_PERCENTILE, MIN_EDGE = 1, 85, 0.01
"""Blur before edges are found, the percentile of gradients that are edges, and the weakest edge."""
RIM_DISTANCES_PX = 3, 10
"""Distances from an edge between which rims lie."""
RIM_DEVIATION_PX, RIM_WIDTH_PX = 1.2, 15
"""Blur that removes grain, and the width from which a light part is no rim."""


class SourceEdges:
    """Edges of a source, luma 0..1, H x W float32, to be compared with a style."""

    def __init__(self, luma: np.ndarray) -> None:
        away = edge_distances(luma, EDGE_DEVIATION_PX, EDGE_PERCENTILE, MIN_EDGE)
        self._beside = (away > RIM_DISTANCES_PX[0]) & (away < RIM_DISTANCES_PX[1])
        self._own_rims = self._rim_height(luma)

    def added_rims(self, luma: np.ndarray) -> float:
        """Return the mean height of light rims in a style, less the height in the source."""
        return self._rim_height(luma) - self._own_rims

    def _rim_height(self, luma: np.ndarray) -> float:
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (RIM_WIDTH_PX, RIM_WIDTH_PX))
        rims = cv2.morphologyEx(cv2.GaussianBlur(luma, (0, 0), RIM_DEVIATION_PX), cv2.MORPH_TOPHAT, disc)
        return float(rims[self._beside].mean()) if self._beside.any() else 0.0
