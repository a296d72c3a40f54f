"""To color: colours back onto luma."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import SavedRef, block


@block("pixel", on="luma", is_identity=True)
def to_color(
    luma: np.ndarray,
    chroma: Annotated[Any, SavedRef("the picture whose colours are taken", on="chroma")] = "chroma",
) -> np.ndarray:
    """Give luma the colours of a saved picture, by default those that to_gray put aside.

    Paper, section 4.2 A.
    """
    return luma
