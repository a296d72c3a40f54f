"""To color: restores the colours of luma."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import SavedRef, block


@block(
    "pixel",
    on="luma",
    is_identity=True,
    label="Bring back colour",
    category="color",
    aliases="restore colour, colours, chroma",
)
def to_color(
    luma: np.ndarray,
    chroma: Annotated[
        Any, SavedRef("picture whose chroma to use", on="chroma", label="Colours from")
    ] = "chroma",
) -> np.ndarray:
    """Bring back the colours that Grayscale has set aside.

    Combines luma with the chroma of a saved picture, by default the one that `to_gray` saves. Paper,
    section 4.2 A.
    """
    return luma
