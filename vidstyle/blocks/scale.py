"""Scale: a smaller or larger working size."""

from __future__ import annotations

from typing import Annotated

from vidstyle.block import Choice, Slider, block
from vidstyle.core.resample import METHODS


@block("resize", on="channels")
def scale(
    size: tuple[int, int],
    factor: Annotated[float, Slider(0.05, 4, "working size by present size", explore=(0.33, 1))] = 0.5,
    method: Annotated[str, Choice(tuple(METHODS), "how the working size is reached")] = "area",
    back: Annotated[str, Choice(tuple(METHODS), "how the output's size is reached again")] = "bicubic",
) -> tuple[int, int]:
    """Go on at another size: filters after it act coarser and faster, or finer.

    Paper, section 4.2 B. Sizes are rounded, halves up, and never below one pixel.
    """
    height, width = (max(1, int(side * factor + 0.5)) for side in size)
    return height, width
