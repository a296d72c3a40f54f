"""Edge tangent flow: smoothing along edges and not across them, which looks brushed."""

from __future__ import annotations

import numpy as np

from vidstyle.blade.references.line_integral import average_along_lines, structure_tensor
from vidstyle.blade.references.rows import require_positive


def edge_tangent_flow(luma: np.ndarray, sigma: float = 2.0, rho: float = 2.0) -> np.ndarray:
    """Luma averaged along its edges.

    Paper, section 5.4.2, equation 12: diffusion along the tangent of the smoothed structure tensor, whatever
    the strength of the gradient, as a line integral convolution with second-order Runge-Kutta steps of one
    pixel.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        sigma: standard deviation in pixels along the line; diffusion for the time sigma^2 / 2.
        rho: standard deviation in pixels of the tensor's smoothing; larger ones give broader strokes.

    Returns:
        H x W float32, new, within the range of luma.

    Raises:
        UsageError: a length is not above 0.
    """
    require_positive(sigma=sigma, rho=rho)
    planes = luma.astype(np.float64)[..., np.newaxis]
    return average_along_lines(planes, structure_tensor(luma, rho), sigma)[..., 0].astype(np.float32)
