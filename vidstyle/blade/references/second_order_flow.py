"""The paper's scheme for total variation flow, for comparison with ours."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.blade.references.rows import require_positive

MAX_TIME_STEP = 0.25
"""Maximum time step; oscillations begin at 0.4."""
WHITE_LEVEL = 255
"""The flow runs on luma 0..255."""


def second_order_tv_flow(luma: np.ndarray, time: float = 2.0) -> np.ndarray:
    """Return luma after u_t = |grad u| div(grad u / |grad u|), by second-order differences.

    Marquina and Osher 2000: fluxes between two pixels, times the central gradient. The slope along the border
    between two pixels is the mean of the slopes of both; the slope of a pixel is the smaller of its two
    one-sided slopes, or 0 if their signs differ (minmod). Their upwinding is for a term that this flow lacks.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        time: in pixels^2.

    Returns:
        H x W float32, new.

    Raises:
        UsageError: time is not above 0.
    """
    require_positive(time=time)
    count = math.ceil(time / MAX_TIME_STEP)
    now = luma.astype(np.float64) * WHITE_LEVEL
    for _ in range(count):
        around = np.pad(now, 2, mode="edge")
        curvature = _divergence(around) + _divergence(around.T).T
        across, down = (around[2:-2, 3:-1] - around[2:-2, 1:-3]), (around[3:-1, 2:-2] - around[1:-3, 2:-2])
        now = now + time / count * curvature * np.hypot(across, down) / 2
    return (now / WHITE_LEVEL).astype(np.float32)


def _divergence(around: np.ndarray) -> np.ndarray:
    """Return the horizontal derivative of the horizontal flux, H x W; the picture has a border of 2."""
    rows = around[1:-1, 1:-1]
    slope = np.diff(rows, axis=1)
    above, below = rows - around[:-2, 1:-1], around[2:, 1:-1] - rows
    smaller = np.where(above * below > 0, np.sign(above) * np.minimum(abs(above), abs(below)), 0)
    beside = (smaller[:, 1:] + smaller[:, :-1]) / 2
    flux = slope / np.sqrt(slope**2 + beside**2 + 1e-6)
    return np.diff(flux, axis=1)[1:-1]
