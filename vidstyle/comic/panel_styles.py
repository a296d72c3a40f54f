"""Which style each panel has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.cues.cue_list import CueList
from vidstyle.cues.style_change import StyleChange
from vidstyle.style import Style


@dataclass(frozen=True)
class PanelStyles:
    """The styles of a comic.

    Attributes:
        styles: the styles that take turns.
        change: where the next style follows; None: with each panel.
        cues: styles over time, instead of both.
    """

    styles: Sequence[Style]
    change: StyleChange | None = None
    cues: CueList | None = None

    def of(self, key_frames: Sequence[KeyFrame]) -> list[Style]:
        """Return the style of each panel; `key_frames`: of the panels, in reading order."""
        if self.cues is not None:
            return [_style_at(self.cues, each.time) for each in key_frames]
        return [self.styles[number] for number in self.numbers(key_frames)]

    def numbers(self, key_frames: Sequence[KeyFrame]) -> list[int]:
        """Return the number of the style of each panel."""
        parts = groupby(enumerate(key_frames), lambda each: self._part(*each))
        return [turn % len(self.styles) for turn, (_, panels) in enumerate(parts) for _ in panels]

    def _part(self, number: int, key_frame: KeyFrame) -> int:
        """Return the part of the film that a panel shows; panels of one part have the same style."""
        if self.change is None:
            return number
        place = key_frame.scene if self.change.kind == "scene" else key_frame.time
        return int(place // self.change.step)


def _style_at(cues: CueList, time: float) -> Style:
    """Return the style of a time; in a transition, the one that is seen more."""
    moment = cues.at(time)
    return (moment.ending if moment.ending and moment.share < 0.5 else moment.active).style
