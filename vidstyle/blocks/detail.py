"""Detail control: less detail, or more."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, block

CONTRASTS = (40.0, 57.0, 80.0)
"""Levels of 255 that the layers' smoothings take for detail: the kernels are powers of one another."""
WHOLE = 20
"""The delta that removes a layer of factor 1, or doubles it."""


@block("learned", on="luma")
def detail(
    delta: Annotated[float, Slider(-100, 100, "below 0 to smooth, above 0 to enhance", "", (-100, 60))] = -20,
    fine: Annotated[float, Slider(0, 2, "share of the finest detail", explore=(0.5, 1))] = 1,
    middle: Annotated[float, Slider(0, 2, "share of detail of more contrast", explore=(0.2, 1))] = 0.5,
    coarse: Annotated[float, Slider(0, 2, "share of the most contrast", explore=(0.2, 0.5))] = 0.2,
) -> BankRun:
    """Remove detail, or enhance it, layer by layer.

    luma + the sum over three layers of a (their detail), where a is delta / 20 times the layer's factor, but
    not below -1, which removes it: at -100 all are gone. Layers are differences of smoothings that cross no
    edges, of 40, 57 and 80 levels of contrast, learned. Paper, sections 4.2 C and 5.4.4; Talebi and Milanfar
    2016, whose S-curves and mask of structure are left out so that the result stays linear in each factor.
    """
    first, second, third = (max(delta / WHOLE * factor, -1.0) for factor in (fine, middle, coarse))
    return BankRun(shipped_bank("detail"), (second - first, third - second, -third), 1 + first)
