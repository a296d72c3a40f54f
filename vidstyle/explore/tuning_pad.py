"""Fine tuning on a tuning pad: the two values of a style to which the picture is most sensitive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vidstyle.explore.look import NewLooks, look_distance
from vidstyle.style import Style, set_values
from vidstyle.style.panel import panel

PROBE_SHARE = 0.08
"""By how much of its range a value is moved to see what it changes."""
MIN_STEPS = 4
"""Whole numbers with fewer steps make no axis."""
MIN_FACTOR_RATIO = 100
"""A range of such a ratio is taken by factors instead of differences."""
AXIS_DISTANCE = 1.6
"""How far the picture changes from the middle of the tuning pad to an end of an axis, about (`look_distance`)."""
MIN_CHANGE_DISTANCE = 0.02
"""Change below which a value does nothing here."""


@dataclass(frozen=True)
class Axis:
    """One value and the part of its range that the tuning pad shows.

    Attributes:
        path: as for `set_values`.
        low, high: ends of the axis.
        is_whole: whether it takes whole numbers only.
        is_factor: whether equal distances are equal factors.
    """

    path: str
    low: float
    high: float
    is_whole: bool
    is_factor: bool

    def at(self, place: float) -> float:
        """The value at a place of the axis, from 0 to 1."""
        if self.is_factor:
            return float(self.low * (self.high / self.low) ** place)
        value = self.low + place * (self.high - self.low)
        return round(value) if self.is_whole else value

    def place(self, value: float) -> float:
        """Where on the axis a value is, from 0 to 1."""
        if self.is_factor:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class TuningPad:
    """Two axes, and the style that is tuned on them."""

    style: Style
    axes: tuple[Axis, Axis]

    def style_at(self, x: float, y: float) -> Style:
        """The style at a point; x from left to right and y from bottom to top, both 0 to 1."""
        places = zip(self.axes, (x, y), strict=True)
        return set_values(self.style, {axis.path: axis.at(place) for axis, place in places})

    @property
    def start(self) -> tuple[float, float]:
        """Where the style itself is."""
        values = {each["path"]: each["value"] for each in _sliders(self.style)}
        x, y = (axis.place(values[axis.path]) for axis in self.axes)
        return x, y


def tuning_pad_of(style: Style, looks: NewLooks) -> TuningPad | None:
    """The tuning pad of a style; None if fewer than two values change anything.

    Two values of different steps are preferred: those of one step often do the same.
    """
    sliders = _sliders(style)
    probed = [_moved(each, PROBE_SHARE) for each in sliders]
    tried = [set_values(style, {each["path"]: at}) for each, at in zip(sliders, probed, strict=True)]
    middle, *others = looks([style, *tried])
    if middle is None:
        return None
    axes = []
    for slider, look in zip(sliders, others, strict=True):
        change = look_distance(middle, look) if look is not None else 0.0
        if change > MIN_CHANGE_DISTANCE:
            axes.append((change, slider["step"], _axis(slider, change)))
    axes = [each for each in axes if not each[2].is_whole or each[2].high - each[2].low >= MIN_STEPS]
    axes.sort(key=lambda each: -each[0])
    if len(axes) < 2:
        return None
    other = next((each for each in axes[1:] if each[1] != axes[0][1]), axes[1])
    return TuningPad(style, (axes[0][2], other[2]))


def _sliders(style: Style) -> list[dict[str, Any]]:
    """The numbers of the steps of a style, as `panel` describes them."""
    return [each for each in panel(style, style)["entries"] if each["kind"] == "slider" and each["step"]]


def _is_factor(slider: dict[str, Any]) -> bool:
    return not slider["whole"] and slider["low"] > 0 and slider["high"] / slider["low"] >= MIN_FACTOR_RATIO


def _moved(slider: dict[str, Any], part: float) -> float:
    """The value moved by a part of its range, away from its nearer end."""
    low, high, value = slider["low"], slider["high"], slider["value"]
    sign = 1 if high - value >= value - low else -1
    if _is_factor(slider):
        return float(np.clip(value * (high / low) ** (sign * part / 2), low, high))
    # Many ranges are far wider than what is usual.
    step = part * min(high - low, max(4 * abs(value), (high - low) / 4))
    return float(np.clip(value + sign * (max(1, round(step)) if slider["whole"] else step), low, high))


def _axis(slider: dict[str, Any], change: float) -> Axis:
    """The axis on which the picture changes by about `AXIS_DISTANCE` to both sides."""
    low, high, value = slider["low"], slider["high"], slider["value"]
    parts = min(AXIS_DISTANCE / change, 10.0)
    moved = _moved(slider, PROBE_SHARE)
    if _is_factor(slider):
        factor = (moved / value if moved > value else value / moved) ** parts
        return Axis(slider["path"], max(low, value / factor), min(high, value * factor), False, True)
    half = abs(moved - value) * parts
    half = max(1, round(half)) if slider["whole"] else half
    return Axis(slider["path"], max(low, value - half), min(high, value + half), slider["whole"], False)
