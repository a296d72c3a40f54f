"""Posterization: a few flat tones in each channel."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, block
from vidstyle.core.kernels import TIE_LIFT, compiled, interleaved


@block(
    "pixel",
    on="channels",
    label="Posterize",
    category="color",
    aliases=(
        "poster, flat, fewer colours, few colours, screen print, pop art, tones, simplify, levels, "
        "bands, steps, warhol, vector, cut paper"
    ),
)
def posterize(
    picture: np.ndarray,
    out: ResultRows,
    levels: Annotated[
        int,
        # Odd numbers have a middle tone, in which small differences from gray disappear.
        Slider(2, 32, "number of tones in each channel", explore=(5, 12), label="Number of tones", stride=2),
    ] = 10,
    softness: Annotated[
        float,
        Slider(
            0, 1, "share of each step that is a ramp; reduces flicker", power=-1, label="Soft transitions"
        ),
    ] = 0.15,
) -> np.ndarray:
    """Reduce the picture to a few flat tones, like a screen print.

    Red, green and blue keep a few tones each, so that similar colours become one.

    Values outside 0..1 become the darkest or lightest tone. Paper, section 4.2 A; the soft steps are
    similar to Winnemoeller 2006, with a cubic ramp that joins the flat tones smoothly.
    """
    _quantize(interleaved(picture), TIE_LIFT, np.float32(levels), np.float32(softness), interleaved(out))
    return out


@compiled(fastmath=True)
def _quantize(values, lift, levels, softness, out):  # type: ignore[no-untyped-def]
    # Row by row: numbers after the last whole vector round differently, but identically in any band.
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    sharpness, step = one / max(softness, np.float32(1e-6)), one / (levels - one)
    for row in range(values.shape[0]):
        for x in range(values.shape[1]):
            position = (values[row, x] + lift) * levels
            border = min(max(np.floor(position + half), one), levels - one)
            if softness > 0:
                ramp = min(max((position - border) * sharpness + half, zero), one)
                ramp = ramp * ramp * (np.float32(3) - np.float32(2) * ramp)
            else:
                ramp = one if position >= border else zero
            out[row, x] = (border - one + ramp) * step
