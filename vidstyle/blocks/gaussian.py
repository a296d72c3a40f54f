"""Gaussian smoothing."""

from __future__ import annotations

import math
from typing import Annotated

import cv2
import numpy as np

from vidstyle.block import Slider, block


def _radius(sigma: float) -> int:
    return math.ceil(3 * sigma)


@block("filter", on="channels", radius=_radius)
def gaussian(
    picture: np.ndarray,
    sigma: Annotated[float, Slider(0, 50, "standard deviation", "px", explore=(0.5, 4))] = 2,
) -> np.ndarray:
    """Blur: remove noise and small detail.

    The kernel ends at three sigma; the border is repeated. Paper, section 4.2 B.
    """
    if sigma == 0:
        return picture
    size = 2 * _radius(sigma) + 1
    return cv2.GaussianBlur(picture, (size, size), sigma, borderType=cv2.BORDER_REPLICATE)
