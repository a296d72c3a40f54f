"""Learned: any bank, the user's own included."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.blade.bank import load_bank, shipped_banks
from vidstyle.blade.inference import BankRun
from vidstyle.block import Asset, Slider, Switch, block


@block("learned", on="luma")
def learned(
    bank: Annotated[
        Any, Asset("a bank file (.npz), or the name of a shipped bank", load_bank, shipped_banks)
    ] = "etf",
    amount: Annotated[float, Slider(0, 1, "0 for no effect", explore=(0.5, 1))] = 1,
    passes: Annotated[int, Slider(1, 8, "number of passes", explore=(1, 3))] = 1,
    reselect: Annotated[bool, Switch("select the filters in each pass")] = True,
) -> BankRun:
    """Apply a bank of learned filters to luma; `vidstyle train` makes banks.

    Paper, section 5, equation 2. Of a bank with several parts only the first is used.
    """
    weights = (amount, *[0.0] * (len(bank.filters) - 1))
    return BankRun(bank, weights, 1 - amount, passes=passes, reselect=reselect)
