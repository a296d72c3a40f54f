"""Which lines stand in which panel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.moment import Moment
from vidstyle.comic.subtitles import Line

REACH = 8.0
"""Seconds from a panel's moment beyond which what is said does not belong to its picture any more."""
MOST = 3
"""Lines of a panel."""
LETTERS = 170
"""Letters of a panel, unless one line alone has more."""

_ONE_SENTENCE = 80
"""Letters up to which two parts of a sentence become one line."""
_BREATH = 1.5
"""Seconds between them."""
_ENDINGS = tuple('.!?…:"”»)]')


@dataclass(frozen=True)
class Words:
    """The lines of each panel, and how many lines there are in all and stand in none."""

    panels: list[list[Line]]
    lines: int
    left_out: int


def match(lines: Sequence[Line], moments: Sequence[Moment]) -> Words:
    """Give each panel what is said at its moment, and from then on until the next one's.

    A line belongs to the first panel in whose moment it is on the screen; else to the last one before it; or
    to the first panel if it is before all. Halves of a short sentence are joined. Of what lies further than
    `REACH` from a moment nothing is shown, and of the rest at most `MOST` lines with `LETTERS` letters: those
    that are nearest to the moment.

    Args:
        lines, moments: in the order of time.
    """
    panels: list[list[Line]] = [[] for _ in moments]
    for line in lines:
        panel = _panel_of(line, moments)
        if _distance(line, moments[panel].time) <= REACH:
            panels[panel].append(line)
    joined = [_joined(panel) for panel in panels]
    chosen = [_nearest(panel, moment.time) for panel, moment in zip(joined, moments, strict=True)]
    lost = sum(map(len, joined)) - sum(map(len, chosen))
    far = len(lines) - sum(map(len, panels))
    if chosen and chosen[0] and not moments[0].faces:
        # A voice over the first picture, in which nobody is to be seen, is a narrator's.
        chosen[0][0] = replace(chosen[0][0], narrated=True)
    return Words(chosen, len(lines), lost + far)


def _panel_of(line: Line, moments: Sequence[Moment]) -> int:
    for number, moment in enumerate(moments):
        if line.start <= moment.time <= line.end:
            return number
    before = [number for number, moment in enumerate(moments) if moment.time < line.start]
    return before[-1] if before else 0


def _distance(line: Line, time: float) -> float:
    return max(0.0, line.start - time, time - line.end)


def _joined(lines: Sequence[Line]) -> list[Line]:
    joined: list[Line] = []
    for line in lines:
        last = joined[-1] if joined else None
        if last is not None and _is_one_sentence(last, line):
            joined[-1] = replace(last, end=line.end, text=f"{last.text} {line.text}")
        else:
            joined.append(line)
    return joined


def _is_one_sentence(line: Line, after: Line) -> bool:
    return (
        (line.narrated, line.speaker) == (after.narrated, after.speaker)
        and after.start - line.end <= _BREATH
        and not line.text.endswith(_ENDINGS)
        and len(line.text) + len(after.text) < _ONE_SENTENCE
    )


def _nearest(lines: Sequence[Line], time: float) -> list[Line]:
    kept: list[int] = []
    for number in sorted(range(len(lines)), key=lambda number: (_distance(lines[number], time), number)):
        letters = sum(len(lines[each].text) for each in [*kept, number])
        if kept and (len(kept) == MOST or letters > LETTERS):
            break
        kept.append(number)
    return [lines[number] for number in sorted(kept)]
