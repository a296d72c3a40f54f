"""Detail control: less detail, or more."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, block


@block("learned", on="luma")
def detail(
    delta: Annotated[
        float, Slider(-100, 60, "-100 for the smooth base, above 0 to enhance", "percent", (-100, 60))
    ] = -60,
) -> BankRun:
    """Remove fine detail, or enhance it.

    luma + delta (luma - base), where the base is smoothed without crossing edges, learned. Paper, sections
    4.2 C and 5.4.4; Talebi and Milanfar 2016.
    """
    return BankRun(shipped_bank("detail"), (-delta / 100,), 1 + delta / 100)
