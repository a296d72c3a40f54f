"""Learned: any bank, including the user's."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.blade.bank_file import load_bank, shipped_banks
from vidstyle.blade.inference import BankRun
from vidstyle.block import Asset, Slider, Switch, block


@block(
    "learned",
    on="luma",
    label="Trained filter",
    category="parts",
    aliases="blade, bank, custom filter, machine learning",
)
def learned(
    bank: Annotated[
        Any, Asset("name of a bank, or a bank file (.npz)", load_bank, shipped_banks, label="Filter bank")
    ] = "etf",
    amount: Annotated[float, Slider(0, 1, "0 for no effect", explore=(0.5, 1), label="Filter strength")] = 1,
    passes: Annotated[int, Slider(1, 8, "number of passes", explore=(1, 3), label="Passes")] = 1,
    reselect: Annotated[bool, Switch("select filters in every pass", label="More accurate")] = True,
    first: Annotated[
        float,
        Slider(
            0, 1, "position of the bank's first slider, 0 for its low end", label="First slider of the bank"
        ),
    ] = 0.5,
    second: Annotated[
        float, Slider(0, 1, "position of the bank's second slider", label="Second slider of the bank")
    ] = 0.5,
    third: Annotated[
        float, Slider(0, 1, "position of the bank's third slider", label="Third slider of the bank")
    ] = 0.5,
) -> BankRun:
    """Apply filters that were trained from examples.

    A bank of learned filters, which `vidstyle train` makes.

    A bank may declare sliders, which weight its parts after the first; other parts are not used. It may also
    filter chroma. Paper, section 5, equation 2. All banks differ from the paper as follows: windows of the
    structure tensor have an even number of pixels and end at two rho; the weights of each filter add up to 1,
    or to 0 for differences, or each filter has its own sum and adds a constant; the weight of the smoothness
    of a filter is relative to the energy of its samples; filters may also be selected by the curvature of
    lines, the local mean, the difference from it, or structure at a second scale; they may also weight
    differences that are clipped, as a bilateral filter does; a bank may have a second stage; and a colour
    matrix, a tone curve through percentiles or a local mode may come before all passes.
    """
    weights = tuple(amount * weight for weight in bank.weights_at((first, second, third)))
    return BankRun(bank, weights, 1 - amount, passes=passes, reselect=reselect, scale=bank.scale)
