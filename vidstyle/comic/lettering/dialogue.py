"""Which lines stand in which panel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.lettering.subtitles import Line
from vidstyle.comic.moment import Moment

REACH = 8.0
"""Seconds from a panel's moment beyond which what is said does not belong to its picture any more."""
MAX_LINES = 3
"""Lines of a panel."""
MAX_LETTERS = 150
"""Letters of a panel, unless one line alone has more."""
EASY_LETTERS = 75
"""Letters that are read at a glance: more crowd a panel."""

_LEFT_OUT = 4.0
"""What it costs to leave a line out, and a half more if it is long: more than a place for it may cost."""
_CROWDED, _WORST = 1.0, 1.5
"""The price of twice as many letters as are easy, which grows with the square of the rest, and its limit."""
_FAR, _LATE = 0.5, 0.3
"""The price of a line `REACH` away from the moment, and of one that is over by then."""
_ONE_SENTENCE = 80
"""Letters up to which two parts of a sentence become one line."""
_BREATH = 1.5
"""Seconds between them."""
_ENDINGS = tuple('.!?…:"”»)]')


@dataclass(frozen=True)
class Dialogue:
    """The lines of each panel, and how many lines there are in all and stand in none."""

    panels: list[list[Line]]
    lines: int
    left_out: int


@dataclass(frozen=True)
class _Assignment:
    """An assignment of the lines so far: its cost, and the text in the last panel that has any."""

    cost: float
    panel: int = 0
    letters: int = 0
    count: int = 0
    before: _Assignment | None = None
    line: Line | None = None


def panels_for(lines: Sequence[Line]) -> int:
    """How many panels it takes for nothing to be crowded."""
    return math.ceil(sum(len(line.text) for line in lines) / EASY_LETTERS)


def match(lines: Sequence[Line], moments: Sequence[Moment]) -> Dialogue:
    """Give each line to a panel or to none, in order, at the least cost.

    A line belongs to the panel in whose moment it is on the screen; else rather to the one before it than to
    the one after, and to a near one; but where there is much to read it may go on to the next. None is
    further than `REACH` from its moment, and no panel holds more than `MAX_LINES` lines
    with `MAX_LETTERS` letters.
    Halves of a short sentence are joined.

    Args:
        lines, moments: in the order of time.
    """
    joined, options = _joined(lines), [_Assignment(0.0)]
    for line in joined:
        options = _with_line(options, line, moments)
    last: _Assignment | None = min(options, key=lambda each: each.cost)
    panels: list[list[Line]] = [[] for _ in moments]
    while last is not None:
        if last.line is not None:
            panels[last.panel].insert(0, last.line)
        last = last.before
    left_out = len(joined) - sum(map(len, panels))
    if panels and panels[0] and not moments[0].faces:
        # A voice over the first picture, in which nobody is to be seen, is a narrator's.
        panels[0][0] = replace(panels[0][0], narrated=True)
    return Dialogue(panels, len(joined), left_out)


def _with_line(options: Sequence[_Assignment], line: Line, moments: Sequence[Moment]) -> list[_Assignment]:
    """The cheapest ways on with a line in any panel, or in none."""
    near = [number for number, each in enumerate(moments) if _distance(line, each.time) <= REACH]
    if not near:
        return list(options)
    best: dict[tuple[int, int, int], _Assignment] = {}
    for each in options:
        omission = _LEFT_OUT * (1 + 0.5 * min(1.0, len(line.text) / MAX_LETTERS))
        tried = [replace(each, cost=each.cost + omission)]
        tried += [
            after for number in near if (after := _placed(each, line, number, moments[number])) is not None
        ]
        for after in tried:
            # What stands in panels that are done makes no difference any more.
            key = (after.panel, after.letters, after.count) if after.panel >= near[0] else (-1, 0, 0)
            if key not in best or after.cost < best[key].cost:
                best[key] = after
    return list(best.values())


def _placed(before: _Assignment, line: Line, panel: int, moment: Moment) -> _Assignment | None:
    """With the line in a panel; None if that has no room, or precedes an assigned line."""
    same = panel == before.panel
    letters, count = (before.letters, before.count) if same else (0, 0)
    added = letters + len(line.text)
    if panel < before.panel or (count and (count == MAX_LINES or added > MAX_LETTERS)):
        return None
    cost = _FAR * _distance(line, moment.time) / REACH + _LATE * (moment.time > line.end)
    return _Assignment(
        before.cost + cost + _crowding(added) - _crowding(letters), panel, added, count + 1, before, line
    )


def _crowding(letters: int) -> float:
    return min(_WORST, _CROWDED * max(0.0, letters / EASY_LETTERS - 1) ** 2)


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
