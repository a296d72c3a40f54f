"""Cues: which style a film has from which time on, how the style begins, and how its values move."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Literal, get_args

from vidstyle.cues.moving import differ_in_values_only, style_between
from vidstyle.cues.times import seconds_text
from vidstyle.errors import UsageError
from vidstyle.style import PLAIN, Style

Transition = Literal["cut", "fade", "wipe"]
"""How a style begins: at once, by a cross-fade, or from left to right."""
Curve = Literal["hold", "linear", "ease"]
"""Interpolation of values until the next cue: none, linear, or slow at both ends."""

TRANSITIONS: tuple[Transition, ...] = get_args(Transition)
CURVES: tuple[Curve, ...] = get_args(Curve)
TIME_TOLERANCE = Fraction(1, 2000)
"""Seconds by which a frame may precede a cue that it belongs to: times in files are rounded."""


@dataclass(frozen=True)
class Cue:
    """The style of a film from a time on.

    Attributes:
        time: in the film, in seconds.
        style: with the values of the cue.
        transition: how the style begins.
        seconds: duration of the transition; 0 for a cut.
        curve: interpolation of values until the next cue, if both styles differ only in values.
    """

    time: Fraction
    style: Style
    transition: Transition = "cut"
    seconds: Fraction = Fraction(0)
    curve: Curve = "hold"

    @property
    def end(self) -> Fraction:
        """When its transition ends."""
        return self.time + self.seconds


@dataclass(frozen=True)
class ActiveStyle:
    """A style at one time.

    Attributes:
        run: number of the run of cues it belongs to; see `CueList.runs`.
        style: with its values at that time.
    """

    run: int
    style: Style


UNCHANGED = ActiveStyle(0, Style(PLAIN))
"""The style before the first cue: none."""


@dataclass(frozen=True)
class Moment:
    """What a cue list asks for at one time.

    Attributes:
        active: the style, or the style that begins.
        ending: during a transition, the style that ends.
        transition: of the two.
        share: part of the transition that is over, 0 to 1.
    """

    active: ActiveStyle
    ending: ActiveStyle | None = None
    transition: Transition = "cut"
    share: float = 1.0


@dataclass(frozen=True)
class CueList:
    """The cues of a film in the order of time. Before the first cue the film is unchanged.

    Raises:
        UsageError: there are no cues, times do not rise, or a transition is longer than its cue.
    """

    cues: tuple[Cue, ...]

    def __post_init__(self) -> None:
        if mistakes := list(_mistakes(self.cues)):
            raise UsageError("cues", "; ".join(mistakes))

    @classmethod
    def of(cls, style: Style) -> CueList:
        """Return a list with one style for the whole film."""
        return cls.at_times([Fraction(0)], [style])

    @classmethod
    def at_times(cls, times: Sequence[Fraction], styles: Sequence[Style]) -> CueList:
        """Return a list with a cut to a style at each time, in seconds."""
        return cls(tuple(Cue(time, style) for time, style in zip(times, styles, strict=True)))

    @property
    def styles(self) -> list[Style]:
        """The styles of all cues."""
        return [cue.style for cue in self.cues]

    @property
    def name(self) -> str:
        """A name for messages."""
        return "cues"

    @property
    def is_plain(self) -> bool:
        """Whether it changes no picture."""
        return all(style.is_plain for style in self.styles)

    @property
    def focus(self) -> float:
        """The strongest focus of its styles."""
        return max(0.0 if style.is_plain else style.focus for style in self.styles)

    def moved(self, seconds: Fraction) -> CueList:
        """Return the list with all cues later by this time; cues may then begin before 0."""
        return CueList(tuple(replace(cue, time=cue.time + seconds) for cue in self.cues))

    @cached_property
    def runs(self) -> list[int]:
        """For each cue the number of its run, from 1 on.

        A run is a series of cues whose styles differ in values only; it keeps its memory of earlier frames. A
        cue with a transition begins a run.
        """
        runs = [1]
        for before, cue in zip(self.cues, self.cues[1:], strict=False):
            continues = not cue.seconds and differ_in_values_only(before.style, cue.style)
            runs.append(runs[-1] + (not continues))
        return runs

    def at(self, time: float | Fraction) -> Moment:
        """Return the styles to show at a time of the film, in seconds."""
        now = Fraction(time) + TIME_TOLERANCE
        number = bisect_right(self._times, now) - 1
        active = self._active(number, now)
        if number < 0 or now >= self.cues[number].end:
            return Moment(active)
        cue = self.cues[number]
        return Moment(
            active, self._active(number - 1, now), cue.transition, float((now - cue.time) / cue.seconds)
        )

    @cached_property
    def _times(self) -> list[Fraction]:
        return [cue.time for cue in self.cues]

    def _active(self, number: int, now: Fraction) -> ActiveStyle:
        """Return the style of a cue with its values at a time; number -1: the unchanged film."""
        if number < 0:
            return UNCHANGED
        run, cue = self.runs[number], self.cues[number]
        if cue.curve == "hold" or number + 1 == len(self.cues) or run != self.runs[number + 1]:
            return ActiveStyle(run, cue.style)
        after = self.cues[number + 1]
        share = min(1.0, float((now - cue.time) / (after.time - cue.time)))
        if cue.curve == "ease":
            share = share * share * (3 - 2 * share)
        return ActiveStyle(run, style_between(cue.style, after.style, share))


def _mistakes(cues: tuple[Cue, ...]) -> Iterator[str]:
    if not cues:
        yield "there are none"
    for number, (cue, after) in enumerate(zip(cues, cues[1:], strict=False), 1):
        if after.time <= cue.time:
            yield f"cue {number + 1} begins at {seconds_text(after.time)} s, not after cue {number}"
        elif cue.end > after.time:
            rest, taken = seconds_text(after.time - cue.time), seconds_text(cue.seconds)
            yield f"the {cue.transition} of cue {number} takes {taken} s, but the next begins after {rest} s"
