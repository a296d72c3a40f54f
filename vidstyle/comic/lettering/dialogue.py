"""Assignment of dialogue lines to panels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.lettering.subtitle_lines import Line

# The limits of a panel.
MAX_DISTANCE_SECONDS = 10.0
"""Maximum time between a line and the key frame of its panel."""
MAX_PANEL_LINES, _EASY_PANEL_LINES = 3, 2
"""Maximum number of lines in a panel, and the number that is read in the right order at a glance."""
MAX_PANEL_LETTERS = 150
"""Maximum number of letters in a panel, unless a single line has more."""
EASY_PANEL_LETTERS = 75
"""Number of letters that are read at a glance; more crowd a panel."""

# The costs of an assignment.
_OMISSION_COST = 4.0
"""Cost of omitting a line, up to half as much more if it is long; above the highest cost of a place."""
_CROWDING_COST, _MAX_CROWDING_COST = 1.0, 1.5
"""Cost of twice `EASY_PANEL_LETTERS`, growing with the square of the excess, and its limit."""
_THIRD_LINE_COST = 0.6
"""Cost of a line beyond `_EASY_PANEL_LINES` in a panel."""
_DISTANCE_COST, _LATENESS_COST = 0.5, 0.3
"""Cost of a line `MAX_DISTANCE_SECONDS` from the key frame, and of a line that ends before it."""
_NO_FACE_COST = 0.5
"""Cost of speech in a picture without a visible face."""

# Sentences that continue in the next line.
_MAX_SENTENCE_LETTERS = 260
"""Parts of a sentence are joined up to this number of letters; the rest follows after an ellipsis."""
_MAX_SENTENCE_PAUSE_SECONDS = 2.5
"""Maximum time between the parts of a sentence."""
ANSWERING_VOICE = "*"
"""Voice of an unknown speaker who answers another one."""
_ELLIPSIS_MARKS = "…", "..."
_SENTENCE_ENDINGS = tuple('.!?…:"”»)]')


@dataclass(frozen=True)
class _Assignment:
    """An assignment of the lines so far: its cost, and the text in the last panel that has any."""

    cost: float
    panel: int = 0
    letters: int = 0
    count: int = 0
    before: _Assignment | None = None
    line: Line | None = None


def count_panels(lines: Sequence[Line]) -> int:
    """Return the number of panels that lines need without crowding."""
    return math.ceil(sum(len(line.text) for line in lines) / EASY_PANEL_LETTERS)


def find_voices(lines: Sequence[Line]) -> list[str]:
    """Return who speaks each line of a panel: an unknown speaker who answers a question is another one.

    Otherwise the answer would have a tail to the mouth of the person who asks.
    """
    voices, asks = list[str](), False
    for line in lines:
        is_answer = asks and voices[-1] != ANSWERING_VOICE
        voices.append(line.speaker or (ANSWERING_VOICE if is_answer else ""))
        asks = not line.narrated and not line.speaker and line.text.rstrip('"”»').endswith("?")
    return voices


def assign_lines(
    lines: Sequence[Line], key_frames: Sequence[KeyFrame]
) -> tuple[list[list[Line]], list[Line]]:
    """Assign each line to a panel or to none, in order, with the lowest total cost; dynamic programming.

    The cost of a line grows with its distance in time from the panel's key frame, and is higher after its end
    and for speech without a visible face; crowded panels and omitted lines cost more. No line is further than
    `MAX_DISTANCE_SECONDS` from its key frame, and no panel has more than `MAX_PANEL_LINES` lines with
    `MAX_PANEL_LETTERS` letters. Parts of a sentence are joined.

    Args:
        lines, key_frames: in the order of time.

    Returns:
        The lines of each panel, and the lines that no panel has.
    """
    joined, states = _mark_continuations(_join_sentences(lines)), [_Assignment(0.0)]
    for line in joined:
        states = _add_line(states, line, key_frames)
    last: _Assignment | None = min(states, key=lambda each: each.cost)
    panels: list[list[Line]] = [[] for _ in key_frames]
    lost = list(joined)
    while last is not None:
        if last.line is not None:
            panels[last.panel].insert(0, last.line)
            lost.remove(last.line)
        last = last.before
    if panels and panels[0] and not key_frames[0].faces:
        # A voice over a first picture without faces belongs to a narrator.
        panels[0][0] = replace(panels[0][0], narrated=True)
    return panels, lost


def _add_line(states: Sequence[_Assignment], line: Line, key_frames: Sequence[KeyFrame]) -> list[_Assignment]:
    """Return the cheapest states with another line in any panel, or in none."""
    near = [
        number for number, each in enumerate(key_frames) if _distance(line, each.time) <= MAX_DISTANCE_SECONDS
    ]
    if not near:
        return list(states)
    best: dict[tuple[int, int, int], _Assignment] = {}
    for each in states:
        omission = _OMISSION_COST * (1 + 0.5 * min(1.0, len(line.text) / MAX_PANEL_LETTERS))
        tried = [replace(each, cost=each.cost + omission)]
        tried += [
            after
            for number in near
            if (after := _place_line(each, line, number, key_frames[number])) is not None
        ]
        for after in tried:
            # The content of completed panels no longer matters.
            key = (after.panel, after.letters, after.count) if after.panel >= near[0] else (-1, 0, 0)
            if key not in best or after.cost < best[key].cost:
                best[key] = after
    return list(best.values())


def _place_line(before: _Assignment, line: Line, panel: int, key_frame: KeyFrame) -> _Assignment | None:
    """Return the state with the line in a panel; None if that is full, or before an assigned line."""
    same = panel == before.panel
    letters, count = (before.letters, before.count) if same else (0, 0)
    added = letters + len(line.text)
    if panel < before.panel or (count and (count == MAX_PANEL_LINES or added > MAX_PANEL_LETTERS)):
        return None
    cost = _DISTANCE_COST * _distance(line, key_frame.time) / MAX_DISTANCE_SECONDS + _LATENESS_COST * (
        key_frame.time > line.end
    )
    cost += _THIRD_LINE_COST * (count >= _EASY_PANEL_LINES)
    cost += _NO_FACE_COST * (not line.narrated and not key_frame.faces)
    return _Assignment(
        before.cost + cost + _crowding(added) - _crowding(letters), panel, added, count + 1, before, line
    )


def _crowding(letters: int) -> float:
    return min(_MAX_CROWDING_COST, _CROWDING_COST * max(0.0, letters / EASY_PANEL_LETTERS - 1) ** 2)


def _distance(line: Line, time: float) -> float:
    return max(0.0, line.start - time, time - line.end)


def _join_sentences(lines: Sequence[Line]) -> list[Line]:
    joined: list[Line] = []
    for line in lines:
        last = joined[-1] if joined else None
        if last is not None and _is_one_sentence(last, line):
            rest = line.text.lstrip("….") if last.text.endswith(_ELLIPSIS_MARKS) else line.text
            text, continued = f"{last.text} {rest.lstrip()}", (*last.continued, *line.times)
            joined[-1] = replace(last, end=line.end, text=text, continued=continued)
        else:
            joined.append(line)
    return joined


def _mark_continuations(lines: Sequence[Line]) -> list[Line]:
    """Return the lines with an ellipsis where a sentence is too long for one of them."""
    marked = list(lines)
    for number, (line, after) in enumerate(pairwise(lines)):
        if _is_one_sentence(line, after, math.inf) and not line.text.endswith(_ELLIPSIS_MARKS):
            marked[number] = replace(marked[number], text=f"{marked[number].text}…")
            marked[number + 1] = replace(after, text=f"…{after.text}")
    return marked


def _is_one_sentence(line: Line, after: Line, most: float = _MAX_SENTENCE_LETTERS) -> bool:
    """Whether a sentence continues in the next line.

    A line that begins in lower case and has no speaker continues the sentence of any speaker.
    """
    same = (line.narrated, line.speaker) == (after.narrated, after.speaker)
    begins = after.text.lstrip("*….")[:1]
    hangs = line.text.endswith(_ELLIPSIS_MARKS) and (
        after.text.startswith(_ELLIPSIS_MARKS) or begins.islower()
    )
    return (
        (same or not (after.narrated or after.speaker or begins.isupper()))
        and "sound" not in (line.manner, after.manner)
        and after.start - line.end <= _MAX_SENTENCE_PAUSE_SECONDS
        and (hangs or not line.text.endswith(_SENTENCE_ENDINGS))
        and len(line.text) + len(after.text) < most
    )
