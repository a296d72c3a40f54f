"""Local exposure: brightens shadows and darkens lights, relative to their surroundings."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import Limits, ResultRows, SavedRef, Slider, block
from vidstyle.core.kernels import compiled, interleaved

MAX_LIFT_LUMA = np.float32(0.8)
"""Largest value of lift times shade: shadows become at most five times as bright."""
MAX_ABOVE_NEAR_LUMA = np.float32(0.12)
"""How much brighter than `near` a pixel is still in its shade; a wall next to a dark figure is not."""


@block(
    "pixel",
    on="channels",
    label="Brighten shadows",
    category="tone",
    aliases=(
        "fill light, shadows and highlights, backlit face, dodge and burn, tone mapping, HDR, exposure, "
        "local contrast, recover shadows, relight, night, too dark"
    ),
)
def local_exposure(
    picture: np.ndarray,
    out: ResultRows,
    limits: Limits,
    near: Annotated[
        Any,
        SavedRef("brightness near each pixel, smoothed up to edges", on="luma", label="Brightness nearby"),
    ] = "source",
    wide: Annotated[
        Any, SavedRef("brightness of the wide surroundings, blurred", on="luma", label="Brightness around")
    ] = "source",
    lift: Annotated[
        float,
        Slider(
            0,
            2,
            "how much shadows are brightened; only what is darker than its surroundings is a shadow",
            explore=(0.6, 1.4),
            label="Brighter shadows",
        ),
    ] = 1.2,
    even: Annotated[
        float,
        Slider(
            0,
            1,
            "how much dark regions are brightened and light ones darkened, wherever they are",
            explore=(0.2, 0.8),
            label="Even light",
        ),
    ] = 0.5,
) -> np.ndarray:
    """Brighten shadows and darken lights, so that both have detail.

    With n and w the luma of `near` and `wide`, the picture is first divided by 1 - lift max(w - n, 0): a face
    in the shade becomes brighter, and a picture of a night stays dark. The negative of n is then laid over
    the result in soft light, with opacity `even`. Where the mean of the channels exceeds n by more than
    0.12, n rises with it: `near` is blurred, and a dark figure would get a bright rim on a bright wall.
    """
    ends = np.float32(limits[0]), np.float32(limits[1])
    light = np.ascontiguousarray(near), np.ascontiguousarray(wide)
    _expose(interleaved(picture), *light, np.float32(lift), np.float32(even), ends, interleaved(out))
    return out


@compiled(fastmath=True, noalias=True)
def _expose(picture, near, wide, lift, even, ends, out):  # type: ignore[no-untyped-def]
    """Write each row; `near` and `wide` are H x W, and `picture` has 1 or 3 numbers for each pixel."""
    for row in range(out.shape[0]):
        given, light, around, made = picture[row], near[row], wide[row], out[row]
        if made.size == light.size:
            for x in range(light.size):
                local = _local_light(given[x], light[x])
                made[x] = _exposed(given[x], local, around[x], lift, even, ends)
        else:
            for x in range(light.size):
                i, j, k = 3 * x, 3 * x + 1, 3 * x + 2
                local = _local_light((given[i] + given[j] + given[k]) * np.float32(1 / 3), light[x])
                made[i] = _exposed(given[i], local, around[x], lift, even, ends)
                made[j] = _exposed(given[j], local, around[x], lift, even, ends)
                made[k] = _exposed(given[k], local, around[x], lift, even, ends)


@compiled(fastmath=True)
def _local_light(level, light):  # type: ignore[no-untyped-def]
    return min(light + max(level - light - MAX_ABOVE_NEAR_LUMA, np.float32(0)), np.float32(1))


@compiled(fastmath=True)
def _exposed(value, light, around, lift, even, ends):  # type: ignore[no-untyped-def]
    zero, one, two = np.float32(0), np.float32(1), np.float32(2)
    gain = one / (one - min(lift * max(around - light, zero), MAX_LIFT_LUMA))
    dark = two * (one - light)
    lifted = min(value * gain, max(value, one))
    softened = lifted * (dark + lifted * (one - dark))
    return min(max(lifted + even * (softened - lifted), ends[0]), ends[1])
