"""Assignment of dialogue lines to panels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.lettering.subtitle_lines import Line

REACH = 8.0
"""Maximum seconds between a line and the key frame of its panel."""
MAX_LINES = 3
"""Maximum number of lines in a panel."""
MAX_LETTERS = 150
"""Maximum number of letters in a panel, unless a single line has more."""
EASY_LETTERS = 75
"""Letters that are read at a glance; more crowd a panel."""

_LEFT_OUT = 4.0
"""Cost of leaving a line out, half as much more if it is long: above the highest cost of a place."""
_CROWDED, _WORST = 1.0, 1.5
"""Cost of twice `EASY_LETTERS`, growing with the square of the excess, and its limit."""
_FAR, _LATE = 0.5, 0.3
"""Cost of a line `REACH` away from the key frame, and of one that ends before it."""
_NOBODY = 0.5
"""Cost of what is said in a picture in which no face is seen."""
_ONE_SENTENCE = MAX_LETTERS
"""Parts of a sentence of no more letters are joined."""
_BREATH = 1.5
"""Maximum seconds between the parts of a sentence."""
_DOTS = "…", "..."
_ENDINGS = tuple('.!?…:"”»)]')


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
    """The number of panels that lines need so that none is crowded."""
    return math.ceil(sum(len(line.text) for line in lines) / EASY_LETTERS)


def match(lines: Sequence[Line], key_frames: Sequence[KeyFrame]) -> tuple[list[list[Line]], int]:
    """Assign each line to a panel or to none, in order, with the lowest total cost; dynamic programming.

    The cost of a line grows with its distance in time from the panel's key frame and is higher after its end,
    and where what is said has no face; crowded panels and omitted lines cost more. No line is further than
    `REACH` from its key frame, and no panel has more than `MAX_LINES` lines with `MAX_LETTERS` letters. Parts of
    a short sentence are joined.

    Args:
        lines, key frames: in the order of time.

    Returns:
        The lines of each panel, and the number of lines in all.
    """
    joined, states = _joined(lines), [_Assignment(0.0)]
    for line in joined:
        states = _with_line(states, line, key_frames)
    last: _Assignment | None = min(states, key=lambda each: each.cost)
    panels: list[list[Line]] = [[] for _ in key_frames]
    while last is not None:
        if last.line is not None:
            panels[last.panel].insert(0, last.line)
        last = last.before
    if panels and panels[0] and not key_frames[0].faces:
        # A voice over a first picture without faces is a narrator's.
        panels[0][0] = replace(panels[0][0], narrated=True)
    return panels, len(joined)


def _with_line(
    states: Sequence[_Assignment], line: Line, key_frames: Sequence[KeyFrame]
) -> list[_Assignment]:
    """The cheapest states with a further line in any panel, or in none."""
    near = [number for number, each in enumerate(key_frames) if _distance(line, each.time) <= REACH]
    if not near:
        return list(states)
    best: dict[tuple[int, int, int], _Assignment] = {}
    for each in states:
        omission = _LEFT_OUT * (1 + 0.5 * min(1.0, len(line.text) / MAX_LETTERS))
        tried = [replace(each, cost=each.cost + omission)]
        tried += [
            after for number in near if (after := _placed(each, line, number, key_frames[number])) is not None
        ]
        for after in tried:
            # The content of completed panels no longer matters.
            key = (after.panel, after.letters, after.count) if after.panel >= near[0] else (-1, 0, 0)
            if key not in best or after.cost < best[key].cost:
                best[key] = after
    return list(best.values())


def _placed(before: _Assignment, line: Line, panel: int, key_frame: KeyFrame) -> _Assignment | None:
    """The state with the line in a panel; None if that is full, or before an assigned line."""
    same = panel == before.panel
    letters, count = (before.letters, before.count) if same else (0, 0)
    added = letters + len(line.text)
    if panel < before.panel or (count and (count == MAX_LINES or added > MAX_LETTERS)):
        return None
    cost = _FAR * _distance(line, key_frame.time) / REACH + _LATE * (key_frame.time > line.end)
    cost += _NOBODY * (not line.narrated and not key_frame.faces)
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
            rest = line.text.lstrip("….") if last.text.endswith(_DOTS) else line.text
            joined[-1] = replace(last, end=line.end, text=f"{last.text} {rest.lstrip()}")
        else:
            joined.append(line)
    return joined


def _is_one_sentence(line: Line, after: Line) -> bool:
    """Whether one goes on in the other: what begins small, without a speaker of its own, may be anybody's."""
    same = (line.narrated, line.speaker) == (after.narrated, after.speaker)
    begins = after.text.lstrip("*….")[:1]
    hangs = line.text.endswith(_DOTS) and (after.text.startswith(_DOTS) or begins.islower())
    return (
        (same or not (after.narrated or after.speaker or begins.isupper()))
        and "sound" not in (line.manner, after.manner)
        and after.start - line.end <= _BREATH
        and (hangs or not line.text.endswith(_ENDINGS))
        and len(line.text) + len(after.text) < _ONE_SENTENCE
    )
