"""Edge tangent flow: brush strokes along the edges."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, Switch, block


@block("learned", on="luma")
def etf(
    passes: Annotated[int, Slider(1, 12, "more for longer strokes", explore=(1, 6))] = 3,
    rho: Annotated[
        float,
        Slider(0.5, 4, "smoothing of the structure tensor: more for broader strokes", "pixels", (1, 3)),
    ] = 2,
    reselect: Annotated[bool, Switch("select the filters in each pass: more accurate, slower")] = False,
) -> BankRun:
    """Smooth luma along the edges, like brush strokes.

    Line integral convolution along the edge tangent flow, learned. Paper, sections 4.2 C and 5.4.2.
    """
    return BankRun(shipped_bank("etf"), rho=rho, passes=passes, reselect=reselect)
