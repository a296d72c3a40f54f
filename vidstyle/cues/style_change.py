"""Chooses a style for each part of a film."""

from __future__ import annotations

import random
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeVar

from vidstyle.cues.times import parse_seconds, seconds_text
from vidstyle.errors import UsageError

T = TypeVar("T")
ChangeKind = Literal["scene", "like", "seconds"]
MAX_PARTS = 10_000
CHANGE_HELP = "'scene', 'shot:3', '30s' or 'like'"


@dataclass(frozen=True)
class StyleChange:
    """Where a film changes its style.

    Attributes:
        kind: "scene": at every Nth scene cut; "like": at each, to the style that suits the scene;
            "seconds": at fixed intervals.
        step: the number of scenes or seconds.
    """

    kind: ChangeKind
    step: Fraction = Fraction(1)

    @classmethod
    def parse(cls, text: str) -> StyleChange:
        """Return the change that a text describes: "scene", "shot:3", "30s" or "like".

        Raises:
            ValueError: it describes none.

        >>> StyleChange.parse("shot:3")
        StyleChange(kind='scene', step=Fraction(3, 1))
        """
        if text in ("scene", "like"):
            return cls("scene" if text == "scene" else "like")
        if match := re.fullmatch(r"shot:([1-9]\d{0,5})", text, re.ASCII):
            return cls("scene", Fraction(match[1]))
        if text.endswith("s") and text[:-1]:
            seconds = parse_seconds(text[:-1])
            if seconds > 0:
                return cls("seconds", seconds)
        raise ValueError(f"{text!r} is not {CHANGE_HELP}")

    def starts(self, end: Fraction) -> list[Fraction]:
        """Return where the parts of a film begin that is divided by time, in seconds; `end`: of the film.

        Raises:
            UsageError: there would be too many parts.
        """
        count = max(1, -(-end // self.step))
        if count > MAX_PARTS:
            interval = seconds_text(self.step)
            raise UsageError("--by", f"would make {count} parts of {interval} s", f"{MAX_PARTS} are possible")
        return [number * self.step for number in range(count)]


def in_turn(styles: Sequence[T], count: int, seed: int | None) -> list[T]:
    """Return a style for each part: in turn, or with a seed at random, but never the same twice in a row."""
    if seed is None or len(styles) == 1:
        return [styles[number % len(styles)] for number in range(count)]
    draw, chosen = random.Random(seed), [-1]
    for _ in range(count):
        chosen.append(draw.choice([number for number in range(len(styles)) if number != chosen[-1]]))
    return [styles[number] for number in chosen[1:]]
