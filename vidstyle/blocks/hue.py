"""Hue: turns the colours round and shifts them."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, Slider, block
from vidstyle.core.kernels import mix_channels


@block("pixel", on="color")
def hue(
    picture: np.ndarray,
    weights: LumaWeights,
    angle: Annotated[float, Slider(-180, 180, "rotation in the chroma plane", "degrees", (-60, 60))] = 60,
    red: Annotated[float, Slider(-255, 255, "added to red", "levels of 255", (-30, 30))] = 0,
    green: Annotated[float, Slider(-255, 255, "added to green", "levels of 255", (-30, 30))] = 0,
    blue: Annotated[float, Slider(-255, 255, "added to blue", "levels of 255", (-30, 30))] = 0,
) -> np.ndarray:
    """Rotate all hues, keeping luma, and add a tint.

    A rotation of (blue difference, red difference) and a bias in RGB, clipped to 0..1. Paper,
    section 4.2 A.
    """
    matrix = np.empty((3, 4))
    matrix[:, :3] = _turn(weights, math.radians(angle))
    matrix[:, 3] = red / 255, green / 255, blue / 255
    return mix_channels(picture, matrix)


def _turn(weights: np.ndarray, angle: float) -> np.ndarray:
    """The 3 x 3 matrix on RGB that turns chroma anticlockwise, blue difference to the right."""
    red, _, blue = (float(weight) for weight in weights)
    to_chroma = np.array(
        [weights, (-weights + [0, 0, 1]) / (2 - 2 * blue), (-weights + [1, 0, 0]) / (2 - 2 * red)]
    )
    cosine, sine = math.cos(angle), math.sin(angle)
    turn = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    return np.asarray(np.linalg.inv(to_chroma) @ turn @ to_chroma)
