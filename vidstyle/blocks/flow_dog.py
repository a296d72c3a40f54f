"""Flow difference of Gaussians: what XDoG thresholds."""

from __future__ import annotations

from typing import Annotated

from vidstyle.blade.bank import shipped_bank
from vidstyle.blade.inference import BankRun
from vidstyle.block import Slider, block

LEARNED = {0.5: "flow_dog_fine", 1.0: "flow_dog"}
"""The banks by their sigma in pixels; for other values one of them runs on a reduced picture."""


@block("learned", on="luma")
def flow_dog(
    sigma: Annotated[float, Slider(0.5, 24, "width of the lines", "px", explore=(0.5, 8))] = 1.4,
    p: Annotated[float, Slider(0, 60, "strength of the sharpening", explore=(1, 40))] = 20,
) -> BankRun:
    """Sharpen across the edges and smooth along them.

    (1 + p) G - p G', with Gaussians of sigma and 1.6 sigma across the edge, then smoothed along it, learned.
    The result goes beyond black and white. Paper, section 4.2 C; Winnemoeller, Kyprianidis and Olsen 2012.
    """
    near = max(learned for learned in LEARNED if learned <= sigma)
    return BankRun(shipped_bank(LEARNED[near]), (1.0, p), scale=near / sigma, is_wide=True)
