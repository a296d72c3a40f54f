"""The control of numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from random import Random
from typing import Any, cast

from vidstyle.block.controls import Control

RANDOM_DIGIT_COUNT = 3
"""Significant digits of a random value: further digits have no visible effect and make style files harder to
read."""
ANGLE_DEVIATION = 90
"""Standard deviation, in degrees, of a random angle from another one at a spread of 1."""


@dataclass(frozen=True)
class Slider(Control):
    """A number in a range; an integer where the parameter is annotated `int`.

    Attributes:
        low, high: ends of the range, both included.
        help: one line, without a full stop.
        unit: "px" for lengths that scale with the picture, "s", "degrees", "of 255" and so on.
        explore: the range for random styles; None keeps the default.
        power: the power of the picture's size that the value is proportional to, in styles with a `height`: 1
            for the slope of edges and for lengths (implied by "px"); -1 for the width of a ramp of tones.
        grows_if: a switch of the block that must be on for the value to scale.
        max_detail: level of detail (focus) above which a length becomes no finer; 1 for dots, lines, grain
            and blurs that need one size in the whole picture.
        finest: the length to which small pictures reduce longer ones, as finer dots would not be seen; less
            with more detail (focus).
        stride: what variations change an integer by, or a multiple of it; 2 keeps odd numbers odd.
    """

    low: float
    high: float
    help: str
    unit: str = ""
    explore: tuple[float, float] | None = None
    power: int = 0
    grows_if: str = ""
    max_detail: float = math.inf
    finest: float = -math.inf
    stride: int = 1
    changes_structure = False
    takes_text = False

    def __post_init__(self) -> None:
        if self.unit == "px":
            object.__setattr__(self, "power", 1)

    def check(self, value: object, is_integer: bool) -> int | float:
        """Return the value as a number.

        Raises:
            ValueError: it is not a number in the range; the message names the range.
        """
        is_number = not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value)
        if not is_number or (is_integer and value != int(cast(float, value))):
            raise ValueError(f"{value!r} is not a {'whole ' if is_integer else ''}number")
        value = cast(float, value)
        if not self.low <= value <= self.high:
            raise ValueError(f"{value:g} is outside {self.range_text}")
        return int(value) if is_integer else float(value)

    @property
    def range_text(self) -> str:
        """The range and unit as text: "0.5 to 8 px"."""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()

    def schema(self, is_integer: bool) -> dict[str, Any]:
        kind = "integer" if is_integer else "number"
        return {"type": kind, "minimum": self.low, "maximum": self.high}

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        ends = {"low": self.low, "high": self.high, "unit": self.unit}
        return {"kind": "slider", "whole": is_integer} | ends

    def draw(self, random: Random, default: Any, is_integer: bool) -> Any:
        return self.draw_between(random, self.explore, is_integer) if self.explore else default

    def draw_between(self, random: Random, ends: tuple[float, float], is_integer: bool) -> float:
        """Return a uniformly distributed random value between two others."""
        if is_integer:
            return random.randint(*map(int, ends))
        return self.nearest(random.uniform(*ends), is_integer)

    def is_drawn(self, value: Any) -> bool:
        return self.explore is not None and self.explore[0] <= value <= self.explore[1]

    def draw_near(self, random: Random, value: Any, spread: float, is_integer: bool) -> Any:
        if self.unit == "degrees":
            angle = value + random.gauss(0, ANGLE_DEVIATION * spread)
            # Angles wrap around at the ends of the range.
            return self.nearest((angle - self.low) % (self.high - self.low) + self.low, is_integer)
        changed = value * math.exp(random.gauss(0, spread))
        if not is_integer:
            return self.nearest(changed, is_integer)
        moved = self._moved(value, changed - value)
        if moved == value and random.random() < spread:
            moved = self._moved(value, random.choice((-self.stride, self.stride)))
        return moved

    def _moved(self, value: int, change: float) -> int:
        """Return an integer moved by about `change`, in whole strides and within the range."""
        down, up = (value - self.low) // self.stride, (self.high - value) // self.stride
        return int(value + self.stride * min(max(round(change / self.stride), -down), up))

    def nearest(self, value: float, is_integer: bool) -> float:
        """Return the value, rounded and clipped to the range."""
        if is_integer:
            value = round(value)
        elif value:
            value = round(value, RANDOM_DIGIT_COUNT - 1 - math.floor(math.log10(abs(value))))
        return self.check(min(max(value, self.low), self.high), is_integer)

    def between(self, one: Any, other: Any, share: float, is_integer: bool) -> Any:
        if one is None or other is None:
            return super().between(one, other, share, is_integer)
        value = one + (other - one) * share
        return round(value) if is_integer else value

    def text(self, value: Any) -> str:
        return f"{value:g}"

    def least_scaled(self, value: float, fineness: float = 1) -> float:
        """Return the least value to which this one is scaled in small pictures."""
        return max(self.low, min(value, self.finest / fineness))

    def scale(self, value: Any, growth: float, values: Mapping[str, Any], fineness: float = 1) -> Any:
        if not self.power or (self.grows_if and not values[self.grows_if]):
            return value
        if self.unit != "px":
            # With other slopes, even areas near a threshold would be brighter or darker.
            return min(max(value * growth**self.power, self.least_scaled(value)), self.high)
        fineness = min(fineness, self.max_detail)
        return max(value * growth / fineness, self.least_scaled(value, fineness))
