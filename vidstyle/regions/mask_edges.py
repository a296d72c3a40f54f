"""Edges of coarse masks, moved to the edges of the picture."""

from __future__ import annotations

import cv2
import numpy as np

MAX_SIDE_PX = 480
"""Maximum side of the copy in which masks are compared with luma."""
RADIUS_RATIO = 1 / 80
"""Radius of the neighbourhood, relative to the copy's longer side."""
MIN_VARIANCE = 4e-4
"""Variance of luma, 0..1, below which a mask is only smoothed."""
EDGE_LEVELS = 0.3, 0.8
"""Levels of a coarse mask that become 0 and 1: networks are never certain."""


def refine(mask: np.ndarray, luma: np.ndarray) -> np.ndarray:
    """Return a mask of the size of luma whose edges follow the edges in luma, also along hair.

    A guided filter (He et al. 2013): near each pixel, the mask is a linear function of luma. The function is
    found in a small copy and applied at full size.

    Args:
        mask: h x w float32, 0..1, of any size.
        luma: H x W float32, 0..1.

    Returns:
        H x W uint8.
    """
    size = luma.shape[1], luma.shape[0]
    scale = min(1.0, MAX_SIDE_PX / max(size))
    small = max(1, round(size[0] * scale)), max(1, round(size[1] * scale))
    guide = cv2.resize(luma, small, interpolation=cv2.INTER_AREA)
    slope, offset = _linear_model(cv2.resize(mask, small, interpolation=cv2.INTER_LINEAR), guide)
    low, high = EDGE_LEVELS
    gain = np.float32(255 / (high - low))
    slope, offset = (
        cv2.resize(each, size, interpolation=cv2.INTER_LINEAR)
        for each in (gain * slope, gain * (offset - np.float32(low)))
    )
    # Rounds, and clips to 0..255.
    return np.asarray(cv2.add(cv2.multiply(slope, luma, dst=slope), offset, dtype=cv2.CV_8U))


def _linear_model(mask: np.ndarray, guide: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return slope and offset of the mask as a function of the guide, smoothed over the neighbourhood."""
    side = 2 * max(1, round(RADIUS_RATIO * max(guide.shape))) + 1

    def mean(plane: np.ndarray) -> np.ndarray:
        return cv2.blur(plane, (side, side), borderType=cv2.BORDER_REPLICATE)

    guide_mean, mask_mean = mean(guide), mean(mask)
    variance = np.maximum(mean(guide * guide) - guide_mean * guide_mean, 0)
    slope = (mean(guide * mask) - guide_mean * mask_mean) / (variance + np.float32(MIN_VARIANCE))
    return mean(slope), mean(mask_mean - slope * guide_mean)
