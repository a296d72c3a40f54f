"""TV flow: flat areas with clean edges."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, block


@block("learned", on="luma")
def tvf(
    passes: Annotated[int, Slider(1, 12, "more for flatter areas", explore=(1, 4))] = 2,
    amount: Annotated[float, Slider(0, 1, "0 for no effect", explore=(0.5, 1))] = 1,
) -> BankRun:
    """Flatten texture and preserve edges.

    Total variation flow in the form of Marquina and Osher, learned. Paper, sections 4.2 C and
    5.4.1.
    """
    return BankRun(shipped_bank("tvf"), (amount,), 1 - amount, passes=passes)
