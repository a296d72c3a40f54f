"""Posterization: a few flat tones in each channel."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Slider, block
from vidstyle.core.kernels import TIE_LIFT, compiled


@block("pixel", on="channels")
def posterize(
    picture: np.ndarray,
    levels: Annotated[int, Slider(2, 32, "tones in each channel", explore=(5, 12))] = 10,
    softness: Annotated[
        float, Slider(0, 1, "part of each step that is a ramp; reduces flicker", power=-1)
    ] = 0.15,
) -> np.ndarray:
    """Quantize each channel to a few flat tones.

    Values outside 0..1 become the end tones. Paper, section 4.2 A; the soft steps are in the spirit
    of Winnemoeller 2006, with a cubic ramp so that they meet the flats without a jump.
    """
    out = np.empty(picture.shape, np.float32)
    _quantize(picture.reshape(-1), TIE_LIFT, np.float32(levels), np.float32(softness), out.reshape(-1))
    return out


@compiled
def _quantize(values, lift, levels, softness, out):  # type: ignore[no-untyped-def]
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    sharpness = one / max(softness, np.float32(1e-6))
    for i in range(values.size):
        position = (values[i] + lift) * levels
        border = min(max(np.floor(position + half), one), levels - one)
        if softness > 0:
            ramp = min(max((position - border) * sharpness + half, zero), one)
            ramp = ramp * ramp * (np.float32(3) - np.float32(2) * ramp)
        else:
            ramp = one if position >= border else zero
        out[i] = (border - one + ramp) / (levels - one)
