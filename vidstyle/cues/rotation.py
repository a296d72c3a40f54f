"""Styles that take turns in a film."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from vidstyle.cues.cue_list import CueList
from vidstyle.cues.style_change import StyleChange
from vidstyle.style import Style

Turn = tuple[Fraction, int]
"""The start of a part of a film, in seconds, and the number of its style in `StyleRotation.styles`."""


@dataclass(frozen=True)
class StyleRotation:
    """Styles that take turns; the film decides when.

    Attributes:
        styles: the styles.
        change: where the style changes.
        seed: random seed of the order; None: in turn.
    """

    styles: tuple[Style, ...]
    change: StyleChange
    seed: int | None

    def cue_list(self, turns: Iterable[Turn]) -> CueList:
        """Return the cues of a film with these turns."""
        starts, numbers = zip(*turns, strict=True)
        return CueList.at_times(starts, [self.styles[number] for number in numbers])


StyleChoice = Style | CueList | StyleRotation
"""The style of a film, or its styles over time."""


def styles_of(look: StyleChoice) -> list[Style]:
    """Return all its styles."""
    return [look] if isinstance(look, Style) else [*look.styles]
