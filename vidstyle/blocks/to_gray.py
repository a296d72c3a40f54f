"""To grayscale: luma alone."""

from __future__ import annotations

import numpy as np

from vidstyle.block import block


@block("pixel", on="luma", chroma="dropped", saves="chroma", is_identity=True)
def to_gray(luma: np.ndarray) -> np.ndarray:
    """Drop chroma; the input is saved as "chroma" for to_color.

    Paper, section 4.2 A.
    """
    return luma
