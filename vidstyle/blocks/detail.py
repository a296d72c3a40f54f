"""Detail control: less detail, or more."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank_file import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, Switch, block

CONTRAST_LEVELS = (40.0, 57.0, 80.0)
"""Contrasts, in levels of 255, below which the smoothing of each layer removes detail. The kernels are powers
of one another."""
FULL_DELTA = 20
"""The `delta` that doubles a layer of factor 1; its negative removes the layer."""


@block(
    "learned",
    on="luma",
    label="Detail",
    category="smooth",
    aliases=(
        "sharpen, sharp, crisp, unsharp mask, clarity, structure, local contrast, texture, soften, "
        "smooth, blur"
    ),
)
def detail(
    delta: Annotated[
        float, Slider(-100, 100, "below 0 smooths, above 0 enhances", "", (-100, 60), label="Detail")
    ] = -20,
    fine: Annotated[
        float, Slider(0, 2, "share of the finest detail", explore=(0.5, 1), label="Fine detail")
    ] = 1,
    middle: Annotated[
        float, Slider(0, 2, "share of detail of middle contrast", explore=(0.2, 1), label="Medium detail")
    ] = 0.5,
    coarse: Annotated[
        float, Slider(0, 2, "share of detail of high contrast", explore=(0.2, 0.5), label="Coarse detail")
    ] = 0.2,
    accurate: Annotated[
        bool, Switch("closer to the reference filter where detail is enhanced; slower", label="More accurate")
    ] = False,
) -> BankRun:
    """Remove fine detail, or bring it out.

    Works layer by layer. Learned. The result is luma plus the sum over three layers of a times their
    detail, where a is delta / 20 times the layer's factor, but at least -1, which removes the layer: at
    -100 all layers are removed. Layers are differences between edge-preserving smoothings for contrasts
    of 40, 57 and 80 levels. Paper, sections 4.2 C and 5.4.4; Talebi and Milanfar 2016, without their
    S-curves and mask of structure, so that the result stays linear in each factor. `accurate` uses
    filters with clipped differences.
    """
    bank = shipped_bank("detail_clipped" if accurate else "detail")
    first, second, third = (max(delta / FULL_DELTA * factor, -1.0) for factor in (fine, middle, coarse))
    return BankRun(bank, (second - first, third - second, -third), 1 + first)
