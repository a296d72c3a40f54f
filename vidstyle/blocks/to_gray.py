"""To grayscale: luma only."""

from __future__ import annotations

import numpy as np

from vidstyle.block import block


@block(
    "pixel",
    on="luma",
    chroma="dropped",
    saves="chroma",
    is_identity=True,
    label="Grayscale",
    category="color",
    aliases="gray, grey, greyscale, black and white, monochrome, desaturate, remove colour, noir",
)
def to_gray(luma: np.ndarray) -> np.ndarray:
    """Remove the colours; the block Bring back colour can restore them.

    Discards chroma, and saves the input as "chroma" for `to_color`. Paper, section 4.2 A.
    """
    return luma
