"""Edge tangent flow: brush strokes along the edges."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Choice, Slider, Switch, block

BRUSHES = {"fine": "etf", "broad": "etf_broad"}
"""The banks by the name of their brush."""


@block("learned", on="luma")
def etf(
    passes: Annotated[int, Slider(1, 12, "more for longer strokes", explore=(1, 6))] = 3,
    rho: Annotated[
        float,
        Slider(0.5, 8, "smoothing of the structure tensor: more for broader strokes", "pixels", (1, 4)),
    ] = 2,
    reselect: Annotated[bool, Switch("select the filters in each pass: more accurate, slower")] = False,
    brush: Annotated[
        str, Choice(tuple(BRUSHES), "fine tidies edges; broad paints, best with rho 4 to 8", tuple(BRUSHES))
    ] = "fine",
) -> BankRun:
    """Smooth luma along the edges, like brush strokes.

    Line integral convolution along the edge tangent flow, learned: with the fine brush a pass is a Gaussian
    of 2 pixels along the edge, with the broad one of 4. Squares of 2 x 2 pixels share a filter. Paper,
    sections 4.2 C and 5.4.2, whose tensor is that of each pass; here that takes `reselect`.
    """
    return BankRun(shipped_bank(BRUSHES[brush]), rho=rho, passes=passes, reselect=reselect)
