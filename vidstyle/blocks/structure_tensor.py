"""Structure tensor: the direction of edges, as a picture."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.block import LumaWeights, block


@block("filter", on="color", radius=lambda: 1)
def structure_tensor(picture: np.ndarray, weights: LumaWeights) -> np.ndarray:
    """Draw direction and strength of edges as colours, for `kuwahara`; smooth them with `gaussian`.

    With s the square root of the luma gradient's magnitude (3 x 3 Sobel, divided by 4, cut off at 1) and t
    its direction, red is (1 + s cos 2t) / 2, green (1 + s sin 2t) / 2 and blue s: doubled angles may be
    averaged, and opposite gradients count as one direction. Smoothed, it is the structure tensor of the
    paper's section 5.3, equations 6 to 8, weighted by s in place of the squared magnitude, so that the
    strongest edge nearby does not drown all others.
    """
    luma = picture @ weights
    across, down = (cv2.Sobel(luma, cv2.CV_32F, *order, scale=0.25, borderType=cv2.BORDER_REPLICATE)
                    for order in ((1, 0), (0, 1)))  # fmt: skip
    squared = across * across + down * down
    # (x^2 - y^2, 2 x y) has the square of the length and twice the angle.
    length = np.sqrt(squared)
    strength = np.sqrt(np.minimum(length, 1))
    half = np.float32(0.5) * strength / np.maximum(squared, np.float32(1e-20))
    red = np.float32(0.5) + half * (across * across - down * down)
    green = np.float32(0.5) + half * (2 * across * down)
    return np.dstack([red, green, strength])
