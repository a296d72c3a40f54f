"""To color: colours back onto luma."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import SavedRef, block


@block("pixel", on="luma", is_identity=True)
def to_color(
    luma: np.ndarray,
    chroma: Annotated[Any, SavedRef("picture whose chroma is used", on="chroma")] = "chroma",
) -> np.ndarray:
    """Combine luma with the chroma of a saved picture, by default that saved by to_gray.

    Paper, section 4.2 A.
    """
    return luma
