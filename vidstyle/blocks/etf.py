"""Edge tangent flow: brush strokes along the edges."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank_file import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Choice, Slider, Switch, block

BRUSH_BANKS = {"fine": "etf", "broad": "etf_broad"}
"""The bank of each brush."""


@block(
    "learned",
    on="luma",
    label="Brush along edges",
    category="paint",
    aliases="flow, swirl, van gogh, edge tangent flow, painterly, smear",
)
def etf(
    passes: Annotated[
        int, Slider(1, 12, "number of passes: more for longer strokes", explore=(1, 6), label="Stroke length")
    ] = 3,
    rho: Annotated[
        float,
        Slider(
            0.5,
            8,
            "standard deviation of the structure tensor: more for broader strokes",
            "pixels",
            (1, 4),
            label="Stroke breadth",
        ),
    ] = 2,
    reselect: Annotated[
        bool, Switch("select filters in every pass: more accurate, slower", label="More accurate")
    ] = False,
    brush: Annotated[
        str,
        Choice(
            tuple(BRUSH_BANKS),
            "fine tidies edges, broad paints (best with rho 4 to 8)",
            tuple(BRUSH_BANKS),
            label="Brush",
        ),
    ] = "fine",
) -> BankRun:
    """Smooth the picture along its edges, like brush strokes.

    Only luma is smoothed. Learned. Line integral convolution along the edge tangent flow: a pass is a
    Gaussian along the edge, of 2 pixels with the fine brush and of 4 with the broad one. Squares of 2 x 2
    pixels share a filter. Paper, sections 4.2 C and 5.4.2; unlike in the paper, the tensor is computed
    again in each pass only with `reselect`.
    """
    return BankRun(shipped_bank(BRUSH_BANKS[brush]), rho=rho, passes=passes, reselect=reselect)
