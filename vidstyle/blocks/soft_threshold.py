"""Soft threshold: white above a cut-off, a tanh ramp to black below it."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, Switch, block
from vidstyle.core.kernels import compiled

SLOPE_CONTROL = Slider(
    0.001,
    1,
    "more for harder borders of black and white",
    "",
    explore=(0.013, 0.059),
    power=1,
    grows_if="edges",
    label="Edge hardness",
)


@block(
    "pixel",
    on="channels",
    label="Black and white",
    category="tone",
    aliases=(
        "threshold, ink, stencil, silhouette, high contrast, photocopy, noir, woodcut, linocut, "
        "binary, stamp, banksy"
    ),
)
def soft_threshold(
    picture: np.ndarray,
    out: ResultRows,
    phi: Annotated[float, SLOPE_CONTROL] = 0.03,
    epsilon: Annotated[
        float,
        Slider(
            0,
            255,
            "the darkest tone that becomes white; 255 leaves nearly all black",
            "of 255",
            explore=(50, 110),
            label="Amount of black",
        ),
    ] = 110,
    edges: Annotated[
        bool, Switch("keep the ramp equally narrow on larger pictures; for lines", label="Keep lines sharp")
    ] = False,
) -> np.ndarray:
    """Turn the picture black and white: bright parts become white, dark parts fade to black.

    Above the threshold everything is white; below it, tones fall to black.

    The ramp is 1 + tanh(min(0, phi (input - epsilon))): paper, section 4.2 A, equation 1; Winnemoeller 2012.

    Use `edges` for lines: their slope decreases as a picture grows, so phi must grow with it. Leave it off
    for a curve of tones.
    """
    rows = len(picture), -1
    values = np.ascontiguousarray(picture).reshape(rows)
    _ramp(values, np.float32(phi * 255), np.float32(epsilon / 255), out.reshape(rows))
    return out


@compiled(fastmath=True)
def _ramp(values, slope, cut_off, out):  # type: ignore[no-untyped-def]
    # 1 + tanh(x) is 2 / (1 + e^t) with t = -2x. The compiler does not vectorize exponentials, so this is the
    # 32nd power of a polynomial for e^(t/32), off by 1e-8, and t ends at 16, where the ramp is at 2e-7.
    # Row by row: numbers after the last whole vector round differently, but identically in any band.
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
