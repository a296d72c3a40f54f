"""Fine tuning on a tuning pad: the two values of a style to which the picture is most sensitive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from vidstyle.explore.look import Look, NewLooks, look_distance
from vidstyle.style import Style, set_values
from vidstyle.style.panel import panel

PROBE_SHARE = 0.08
"""Share of its range by which a value is changed to measure its effect."""
MIN_STEPS = 4
"""Integer ranges with fewer steps are not used as an axis."""
MIN_FACTOR_RATIO = 100
"""Ranges with at least this ratio use a logarithmic axis."""
AXIS_DISTANCE = 1.6
"""Approximate `look_distance` between the middle and the ends of an axis."""
MIN_CHANGE_DISTANCE = 0.02
"""Smallest `look_distance` at which a value counts as effective."""
MIN_END_DISTANCE = 0.15
"""Smallest `look_distance` between the middle and each end of an axis: half of the one between two tiles."""
MAX_TRIED_AXES = 8
"""Number of axes whose ends are drawn to find two visible ones."""


@dataclass(frozen=True)
class Axis:
    """An axis: a value and the part of its range on the pad.

    Attributes:
        path: its path, see `set_values`.
        label: its name in plain words.
        low, high: the ends of the axis.
        is_whole: whether the value is an integer.
        is_factor: whether the axis is logarithmic.
    """

    path: str
    label: str
    low: float
    high: float
    is_whole: bool
    is_factor: bool

    def at(self, place: float) -> float:
        """Return the value at a position, 0..1."""
        if self.is_factor:
            return float(self.low * (self.high / self.low) ** place)
        value = self.low + place * (self.high - self.low)
        return round(value) if self.is_whole else value

    def place(self, value: float) -> float:
        """Return the position of a value, 0..1."""
        if self.is_factor:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class TuningPad:
    """A style and the two axes on which it is tuned."""

    style: Style
    axes: tuple[Axis, Axis]

    def style_at(self, x: float, y: float) -> Style:
        """Return the style at a point; x runs from left to right and y from bottom to top, both 0..1."""
        places = zip(self.axes, (x, y), strict=True)
        return set_values(self.style, {axis.path: axis.at(place) for axis, place in places})

    @property
    def start(self) -> tuple[float, float]:
        """The point of the style itself."""
        values = {each["path"]: each["value"] for each in sliders_of(self.style)}
        x, y = (axis.place(values[axis.path]) for axis in self.axes)
        return x, y


def tuning_pad_of(style: Style, looks: NewLooks) -> TuningPad | None:
    """Return the tuning pad of a style; None if fewer than two values have an effect.

    Prefer the knobs of the style, other values that change the picture in both directions, and values of
    different steps, since values of one step often have similar effects.
    """
    middle, candidates = _find_axes(style, looks)
    if middle is None or len(candidates) < 2:
        return None
    visible = (each for each in candidates[:MAX_TRIED_AXES] if _is_visible(style, each[1], middle, looks))
    first = next(visible, candidates[0])
    apart = [each for each in candidates if each[0] != first[0]]
    rest = apart or [each for each in candidates if each is not first]
    second = next((each for each in visible if each in rest), rest[0])
    return TuningPad(style, (first[1], second[1]))


def _find_axes(style: Style, looks: NewLooks) -> tuple[Look | None, list[tuple[str, Axis]]]:
    """Return the look of a style, and its axes with their steps: knobs, then strong effects first."""
    sliders = sliders_of(style)
    probed = [_shift_value(each, PROBE_SHARE) for each in sliders]
    tried = [set_values(style, {each["path"]: at}) for each, at in zip(sliders, probed, strict=True)]
    middle, *others = looks([style, *tried])
    if middle is None:
        return None, []
    axes = []
    for slider, look in zip(sliders, others, strict=True):
        change = look_distance(middle, look) if look is not None else 0.0
        if change > MIN_CHANGE_DISTANCE:
            axes.append((change, slider["step"], _axis(slider, change)))
    axes = [each for each in axes if not each[2].is_whole or each[2].high - each[2].low >= MIN_STEPS]
    axes.sort(key=lambda each: (each[2].path not in style.knobs, -each[0]))
    return middle, [(step, axis) for _, step, axis in axes]


def _is_visible(style: Style, axis: Axis, middle: Look, looks: NewLooks) -> bool:
    """Whether an axis is a knob of the style, or the picture changes toward both of its ends."""
    if axis.path in style.knobs:
        return True
    ends = looks([set_values(style, {axis.path: axis.at(place)}) for place in (0, 1)])
    return all(end is not None and look_distance(middle, end) >= MIN_END_DISTANCE for end in ends)


def sliders_of(style: Style) -> list[dict[str, Any]]:
    """Return the sliders of all steps, as described by `panel`."""
    return [each for each in panel(style, style)["entries"] if each["kind"] == "slider" and each["step"]]


def _is_factor(slider: dict[str, Any]) -> bool:
    return not slider["whole"] and slider["low"] > 0 and slider["high"] / slider["low"] >= MIN_FACTOR_RATIO


def moved_value(slider: dict[str, Any], part: float) -> float:
    """Return the value moved up by a share of its range, or down if it is negative; within the range."""
    low, high, value = slider["low"], slider["high"], slider["value"]
    if _is_factor(slider):
        return float(min(max(value * (high / low) ** (part / 2), low), high))
    # Many ranges are far wider than usual values.
    step = part * min(high - low, max(4 * abs(value), (high - low) / 4))
    if slider["whole"]:
        step = math.copysign(max(1, round(abs(step))), step)
    return float(min(max(value + step, low), high))


def _shift_value(slider: dict[str, Any], part: float) -> float:
    """Return the value moved by a share of its range, away from the nearer end."""
    low, high, value = slider["low"], slider["high"], slider["value"]
    return moved_value(slider, part if high - value >= value - low else -part)


def _axis(slider: dict[str, Any], change: float) -> Axis:
    """Return an axis whose ends differ from the middle by about `AXIS_DISTANCE`."""
    low, high, value = slider["low"], slider["high"], slider["value"]
    parts = min(AXIS_DISTANCE / change, 10.0)
    moved = _shift_value(slider, PROBE_SHARE)
    if _is_factor(slider):
        factor = (moved / value if moved > value else value / moved) ** parts
        return Axis(
            slider["path"], slider["label"], max(low, value / factor), min(high, value * factor), False, True
        )
    half = abs(moved - value) * parts
    half = max(1, round(half)) if slider["whole"] else half
    return Axis(
        slider["path"],
        slider["label"],
        max(low, value - half),
        min(high, value + half),
        slider["whole"],
        False,
    )
