"""Hue: rotation of hues, and a tint."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, Slider, block
from vidstyle.core.color.deferred_color import Mixed


@block(
    "pixel",
    on="color",
    label="Hue and tint",
    category="color",
    aliases=(
        "recolor, temperature, white balance, warm, cold, colour cast, colour balance, shift colours, "
        "rotate colours"
    ),
)
def hue(
    picture: np.ndarray,
    weights: LumaWeights,
    angle: Annotated[
        float, Slider(-180, 180, "rotation in the chroma plane", "degrees", (-60, 60), label="Hue")
    ] = 60,
    red: Annotated[float, Slider(-255, 255, "amount added to red", "of 255", (-30, 30), label="Red")] = 0,
    green: Annotated[
        float, Slider(-255, 255, "amount added to green", "of 255", (-30, 30), label="Green")
    ] = 0,
    blue: Annotated[float, Slider(-255, 255, "amount added to blue", "of 255", (-30, 30), label="Blue")] = 0,
) -> Mixed:
    """Shift all colours around the colour wheel, and add a tint.

    Hues are rotated, luma is kept. Rotates (blue difference, red difference), then adds a bias in RGB;
    the result is clipped to 0..1. Paper, section 4.2 A.
    """
    return Mixed(picture, _matrix(tuple(weights), math.radians(angle), (red, green, blue)))


@lru_cache(maxsize=16)
def _matrix(weights: tuple[np.float32, ...], angle: float, tint: tuple[float, ...]) -> np.ndarray:
    """Return the RGB matrix: rotates chroma anticlockwise (blue difference to the right), adds the tint."""
    luma, (red, _, blue) = np.array(weights), map(float, weights)
    to_chroma = np.array([luma, ([0, 0, 1] - luma) / (2 - 2 * blue), ([1, 0, 0] - luma) / (2 - 2 * red)])
    cosine, sine = math.cos(angle), math.sin(angle)
    turn = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    turned = np.linalg.inv(to_chroma) @ turn @ to_chroma
    return np.column_stack([turned, np.array(tint) / 255]).astype(np.float32)
