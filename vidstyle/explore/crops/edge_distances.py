"""Distances of pixels from the edges of a picture."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.explore.measure import gradient_of


def edge_distances(luma: np.ndarray, deviation: float, percentile: float, min_gradient: float) -> np.ndarray:
    """Return the distance of each pixel from the nearest edge in pixels, H x W float32.

    Args:
        luma: H x W float32, 0..1.
        deviation: standard deviation of the blur before edges are found.
        percentile: percentile of gradients from which they are edges.
        min_gradient: gradient of the weakest edge.
    """
    gradient = gradient_of(cv2.GaussianBlur(luma, (0, 0), deviation))
    edges = gradient > max(float(np.percentile(gradient, percentile)), min_gradient)
    return cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 3)
