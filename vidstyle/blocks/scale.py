"""Scale: a smaller or larger working size."""

from __future__ import annotations

from typing import Annotated

from vidstyle.block import Choice, Slider, block
from vidstyle.core.resample import METHODS, scaled_shape


@block(
    "resize",
    on="channels",
    label="Working size",
    category="size",
    aliases="resize, bigger, smaller, resolution, shrink, enlarge, coarser, zoom, speed",
)
def scale(
    size: tuple[int, int],
    factor: Annotated[
        float,
        Slider(
            0.05, 4, "working size, relative to the current size", explore=(0.33, 1), label="Working size"
        ),
    ] = 0.5,
    method: Annotated[
        str, Choice(tuple(METHODS), "interpolation to the working size", label="Way to reduce")
    ] = "area",
    back: Annotated[
        str, Choice(tuple(METHODS), "interpolation back to the output size", label="Way to enlarge")
    ] = "bicubic",
) -> tuple[int, int]:
    """Work on a smaller or larger copy: later steps become coarser and faster, or finer.

    Paper, section 4.2 B.
    """
    return scaled_shape(size, factor)
