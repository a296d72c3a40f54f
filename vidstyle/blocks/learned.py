"""Learned: any bank, the user's own included."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.blade.bank import load_bank, shipped_banks
from vidstyle.blade.inference import BankRun
from vidstyle.block import Asset, Slider, Switch, block


@block("learned", on="luma")
def learned(
    bank: Annotated[
        Any, Asset("a bank file (.npz), or the name of one of ours", load_bank, shipped_banks)
    ] = "etf",
    amount: Annotated[float, Slider(0, 1, "0 leaves the picture", explore=(0.5, 1))] = 1,
    passes: Annotated[int, Slider(1, 8, "how often it runs", explore=(1, 3))] = 1,
    reselect: Annotated[bool, Switch("choose the filters anew in each pass")] = True,
) -> BankRun:
    """Run a bank of learned filters over luma; `vidstyle train` makes one from any filter.

    Paper, section 5, equation 2. A bank with several parts runs with the weight 1 for its first one alone.
    """
    weights = (amount, *[0.0] * (len(bank.filters) - 1))
    return BankRun(bank, weights, 1 - amount, passes=passes, reselect=reselect)
