"""What makes a crop look drawn: light rims beside edges, small marks, and faces that stand out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.explore.colors import oklab
from vidstyle.explore.measure import band_pass, gradient_of, luma_of_codes

EDGE_DEVIATION_PX, EDGE_PERCENTILE, MIN_EDGE = 1, 85, 0.01
"""Blur before edges are found, the percentile of gradients that are edges, and the weakest edge."""
RIM_DISTANCES_PX = 3, 10
"""Distances from an edge between which rims lie."""
RIM_DEVIATION_PX, RIM_WIDTH_PX = 1.2, 15
"""Blur that removes grain, and the width from which a light part is no rim."""
SMALL_BAND_PX, LARGE_BAND_PX, MIN_BAND = (4, 8), (8, 16), 0.003
"""Standard deviations of the two blurs between which marks of a size are seen, and what is added to both."""
SURROUNDINGS_RATIO = 0.25
"""Width of the surroundings of a face relative to the face."""


class Drawing(NamedTuple):
    """See `FullSizeMetrics`."""

    rims: float
    mark_smallness: float
    face_lift: float


class SourceDrawing:
    """Edges and faces of a source, H x W x 3 uint8, to be compared with a style.

    Args:
        faces: rows and columns of each.
    """

    def __init__(self, source: np.ndarray, faces: Sequence[tuple[slice, slice]]) -> None:
        luma = luma_of_codes(source)
        gradient = gradient_of(cv2.GaussianBlur(luma, (0, 0), EDGE_DEVIATION_PX))
        edges = gradient > max(float(np.percentile(gradient, EDGE_PERCENTILE)), MIN_EDGE)
        away = cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 3)
        self._beside = (away > RIM_DISTANCES_PX[0]) & (away < RIM_DISTANCES_PX[1])
        self._rims, self._faces = self._rim_height(luma), faces
        self._lift = self._face_lift(source)

    def measure(self, result: np.ndarray) -> Drawing:
        """Return what a style, H x W x 3 uint8, does to edges and faces."""
        luma = luma_of_codes(result)
        small, large = (
            float(band_pass(luma, *band).std()) + MIN_BAND for band in (SMALL_BAND_PX, LARGE_BAND_PX)
        )
        return Drawing(
            rims=self._rim_height(luma) - self._rims,
            mark_smallness=float(np.log(small / large)),
            face_lift=self._face_lift(result) - self._lift,
        )

    def _rim_height(self, luma: np.ndarray) -> float:
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (RIM_WIDTH_PX, RIM_WIDTH_PX))
        rims = cv2.morphologyEx(cv2.GaussianBlur(luma, (0, 0), RIM_DEVIATION_PX), cv2.MORPH_TOPHAT, disc)
        return float(rims[self._beside].mean()) if self._beside.any() else 0.0

    def _face_lift(self, picture: np.ndarray) -> float:
        lifts = [_lift(picture, *face) for face in self._faces]
        return float(np.mean(lifts)) if lifts else 0.0


def _lift(picture: np.ndarray, rows: slice, columns: slice) -> float:
    """Return how much lighter a face is than its surroundings, in Oklab."""
    margin = round(SURROUNDINGS_RATIO * (columns.stop - columns.start))
    top, left = max(rows.start - margin, 0), max(columns.start - margin, 0)
    lightness = oklab(picture[top : rows.stop + margin, left : columns.stop + margin] / 255.0)[..., 0]
    face = np.zeros(lightness.shape, bool)
    face[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left] = True
    return float(lightness[face].mean() - lightness[~face].mean()) if not face.all() else 0.0
