"""Relief: luma as a height, lit from the side."""

from __future__ import annotations

import math
from typing import Annotated

import cv2
import numpy as np

from vidstyle.block import Slider, block


@block("filter", on="luma", radius=lambda: 1, chroma="dropped")
def relief(
    luma: np.ndarray,
    depth: Annotated[float, Slider(0, 16, "strength of light and shade", explore=(0.5, 3))] = 1,
    angle: Annotated[float, Slider(-180, 180, "where the light comes from: 90 from above", "degrees")] = 135,
) -> np.ndarray:
    """Light luma as a relief: gray where it is flat, bright towards the light, dark away from it.

    Half white plus depth times the slope towards the light (3 x 3 Sobel, divided by 8), cut off at black and
    white. Lay it over a picture with `blend` and the mode grain_merge, for thick paint or rough paper.
    """
    turn = math.radians(angle)
    across, down = (
        cv2.Sobel(luma, cv2.CV_32F, *order, scale=depth / 8 * part, borderType=cv2.BORDER_REPLICATE)
        for order, part in (((1, 0), -math.cos(turn)), ((0, 1), math.sin(turn)))
    )
    return np.clip(across + down + np.float32(0.5), 0, 1)
