"""Soft threshold: white above a cut-off, a tanh ramp to black below it."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, Switch, block
from vidstyle.core.kernels import compiled

SLOPE = Slider(
    0.001, 1, "slope of the ramp", "per level of 255", explore=(0.013, 0.059), power=1, grows_if="edges"
)


@block("pixel", on="channels")
def soft_threshold(
    picture: np.ndarray,
    out: ResultRows,
    phi: Annotated[float, SLOPE] = 0.03,
    epsilon: Annotated[
        float, Slider(0, 255, "threshold; everything above it is white", "levels of 255", explore=(50, 110))
    ] = 110,
    edges: Annotated[bool, Switch("keep the ramp as narrow on larger pictures, as for lines")] = False,
) -> np.ndarray:
    """Make everything above a threshold white, with a tanh ramp to black below it.

    1 + tanh(min(0, phi (input - epsilon))): paper, section 4.2 A, equation 1; Winnemoeller 2012.

    `edges` is for what makes lines: their slope falls as a picture grows, so that phi has to grow with it.
    For a curve of tones it stays off.
    """
    rows = len(picture), -1
    values = np.ascontiguousarray(picture).reshape(rows)
    _ramp(values, np.float32(phi * 255), np.float32(epsilon / 255), out.reshape(rows))
    return out


@compiled(fastmath=True)
def _ramp(values, slope, cut_off, out):  # type: ignore[no-untyped-def]
    # 1 + tanh(x) is 2 / (1 + e^t) with t = -2x. As the compiler makes no vectors of an exponential, it is the
    # 32nd power of a polynomial for e^(t/32), off by 1e-8, and t ends at 16, where the ramp is at 2e-7.
    # Row by row: what is left over after whole vectors is rounded otherwise, but alike in any band.
    one, steepness = np.float32(1), np.float32(1 / 16) * slope
    for row in range(values.shape[0]):
        for x in range(values.shape[1]):
            part = min(max(steepness * (cut_off - values[row, x]), np.float32(0)), np.float32(0.5))
            power = np.float32(0.040380687) + part * np.float32(0.010632662)
            power = np.float32(0.49996635) + part * (np.float32(0.16698425) + part * power)
            power = one + part * (np.float32(1.0000012) + part * power)
            power *= power
            power *= power
            power *= power
            power *= power
            power *= power
            out[row, x] = np.float32(2) / (one + power)
