"""TV flow: flat areas with clean edges."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.blade.bank_file import shipped_bank, shipped_parts
from vidstyle.blade.inference import BankRun
from vidstyle.block import Choice, Slider, Switch, block

PASS_TIME = 2.0
"""Time of a pass of curvature flow, in pixels^2."""
STEPS_PER_PASS = 3
"""A single pass runs in this number of steps, with filters for a third of its time: 1.7 dB closer than one
step."""


@block(
    "learned",
    on="luma",
    label="Flatten texture",
    category="smooth",
    aliases=(
        "denoise, noise reduction, remove grain, smooth, soften, skin, flat, calm, simplify, cartoon, "
        "abstract, watercolor, watercolour, wash, bleed"
    ),
)
def tvf(
    passes: Annotated[
        int, Slider(1, 12, "number of passes: more for flatter areas", explore=(1, 4), label="Flatness")
    ] = 2,
    amount: Annotated[
        float, Slider(0, 1, "0 for no effect", explore=(0.5, 1), label="Flattening strength")
    ] = 1,
    flow: Annotated[
        str,
        Choice(
            ("curvature", "variation"),
            "curvature rounds shapes and keeps contrast, variation creates areas of uniform tone",
            ("curvature", "variation"),
            label="Kind of flattening",
        ),
    ] = "curvature",
    time: Annotated[
        float,
        Slider(
            1,
            12,
            "time of each pass of variation",
            "levels x px",
            (4, 12),
            label="Flatness of a pass",
        ),
    ] = 6,
    accurate: Annotated[
        bool,
        Switch("variation keeps edges sharper, above all in several passes; slower", label="More accurate"),
    ] = False,
) -> BankRun:
    """Flatten texture and preserve edges.

    Learned. `curvature` is total variation flow in the form of Marquina and Osher, which the paper trains:
    mean curvature motion. A single pass runs in three steps, which is more accurate. `variation` is the true
    flow: a disc of radius r loses 2 time / r levels in each pass; `accurate` gives it filters with clipped
    differences. Paper, sections 4.2 C and 5.4.1.
    """
    if flow == "curvature":
        part, passes = (1, STEPS_PER_PASS) if passes == 1 else (0, passes)
        return BankRun(shipped_parts("tvf", part, part + 1), (amount,), 1 - amount, passes=passes)
    bank = shipped_bank("tvf_flat_clipped" if accurate else "tvf_flat")
    times = (0.0, *bank.about["times"])
    identity, *weights = (float(np.interp(time, times, row)) for row in np.eye(len(times)))
    return BankRun(
        bank, tuple(amount * each for each in weights), 1 - amount + amount * identity, passes=passes
    )
