"""Blend: lays a saved picture over the current one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Choice, SavedRef, Slider, block

MODES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "normal": lambda below, above: above,
    "multiply": lambda below, above: below * above,
    "screen": lambda below, above: below + above - below * above,
    "overlay": lambda below, above: _hard_light(above, below),
    "hard_light": lambda below, above: _hard_light(below, above),
    "soft_light": lambda below, above: below * (2 * above + below * (1 - 2 * above)),
    "darken": np.minimum,
    "lighten": np.maximum,
    "add": lambda below, above: np.minimum(below + above, 1),
    "subtract": lambda below, above: np.maximum(below - above, 0),
    "difference": lambda below, above: np.abs(below - above),
    "grain_extract": lambda below, above: np.clip(below - above + np.float32(0.5), 0, 1),
    "grain_merge": lambda below, above: np.clip(below + above - np.float32(0.5), 0, 1),
    "divide": lambda below, above: np.clip(below / np.maximum(above, 1 / 255), 0, 1),
    "dodge": lambda below, above: np.clip(below / np.maximum(1 - above, 1 / 255), 0, 1),
    "burn": lambda below, above: 1 - np.clip((1 - below) / np.maximum(above, 1 / 255), 0, 1),
}
"""The blend modes: functions of each channel of the picture below and the one above."""


@block("pixel", on="channels", overshoots=True)
def blend(
    picture: np.ndarray,
    other: Annotated[Any, SavedRef("picture blended over the current one")] = "source",
    mode: Annotated[str, Choice(tuple(MODES), "blend mode", explore=("multiply", "overlay"))] = "normal",
    opacity: Annotated[float, Slider(0, 1, "0 for no effect", explore=(0.3, 1))] = 0.5,
    mask: Annotated[
        Any, SavedRef("picture whose luma multiplies the opacity", on="luma", optional=True)
    ] = "",
) -> np.ndarray:
    """Blend a saved picture over the current one; over a gray one, its luma."""
    mixed = MODES[mode](picture, other)
    if mask is None and opacity == 1:
        return mixed
    weight = np.float32(opacity)
    if mask is not None:
        weight = weight * mask if picture.ndim == 2 else weight * mask[..., None]
    mixed = mixed - picture
    mixed *= weight
    mixed += picture
    return mixed


def _hard_light(below: np.ndarray, above: np.ndarray) -> np.ndarray:
    return np.where(above < 0.5, 2 * below * above, 1 - 2 * (1 - below) * (1 - above))
