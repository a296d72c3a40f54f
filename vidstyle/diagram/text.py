"""The graph of a style as text: one line for each block, with its inputs on the left."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import chain, repeat

from vidstyle.diagram.graph import DiagramNode
from vidstyle.style import LAYERS

LANE_PITCH_CHARACTERS = 3
"""Distance between two lanes in characters."""
MIN_TEXT_CHARACTERS = 30
"""Minimum width of the text in characters."""

_ASCII_FALLBACKS = str.maketrans(dict(zip("●│─├┤╮╭╯╰┼◄►", "*|-+++++++<>", strict=True)) | {"→": "->"})
_NO_BREAK = "\N{NO-BREAK SPACE}"
"""Replaces spaces at which lines must not wrap."""


def graph_text(nodes: Sequence[DiagramNode], width: int = 80, encoding: str = "utf-8") -> list[str]:
    """Return the lines of the drawing.

    Args:
        nodes: from `graph_of`.
        width: in characters.
        encoding: the encoding of the terminal; without line characters, ASCII is used.
    """
    lanes = 1 + max(max(node.lane, node.aside or 0) for node in nodes)
    left = max(map(len, LAYERS)) + 2
    live: set[int] = set()
    lines: list[str] = []
    layer = ""
    for node in nodes:
        lines += (" " * left + row for row in _rows_above(node, live, lanes))
        words = _words(node, max(MIN_TEXT_CHARACTERS, width - left - lanes * LANE_PITCH_CHARACTERS))
        headings = chain([node.block.layer if node.block.layer != layer else ""], repeat(""))
        rows = _rows_of_block(node, len(words), live, lanes)
        lines += (
            f"{heading:{left}}{row}{part}" for row, part, heading in zip(rows, words, headings, strict=False)
        )
        layer = node.block.layer
    return [_encodable(line.rstrip(), encoding) for line in lines]


def _words(node: DiagramNode, room: int) -> list[str]:
    """Return the text next to a block, wrapped."""
    block = node.block
    unbroken = [part.replace(" ", _NO_BREAK) for part in block.words]
    saved = f"  → {', '.join(block.saves)}" if block.saves else ""
    text = f"{block.title}{'  ' if unbroken else ''}{', '.join(unbroken)}{saved}"
    return [line.replace(_NO_BREAK, " ") for line in textwrap.wrap(text, room, subsequent_indent="  ")]


def _rows_of_block(node: DiagramNode, count: int, live: set[int], lanes: int) -> Iterator[str]:
    """Yield the row of a block, and more rows for the rest of its text."""
    live.add(node.lane)
    yield _row(live, lanes, {node.lane * LANE_PITCH_CHARACTERS: "●"})
    if not node.used:
        live.remove(node.lane)
    yield from [_row(live, lanes)] * (count - 1)


def _rows_above(node: DiagramNode, live: set[int], lanes: int) -> Iterator[str]:
    """Yield the changes of lanes above a block, one per row."""
    if node.aside is not None:
        yield _fork(node.lane, node.aside, live, lanes)
        live.add(node.aside)
    for edge in node.edges[1:]:
        lane = edge.moves[-1].lane
        yield _join(lane, node.lane, edge.continues, live, lanes)
        if not edge.continues:
            live.remove(lane)


def _fork(lane: int, to: int, live: set[int], lanes: int) -> str:
    ends = {
        lane * LANE_PITCH_CHARACTERS: "├" if to > lane else "┤",
        to * LANE_PITCH_CHARACTERS: "╮" if to > lane else "╭",
    }
    return _row(live, lanes, _across(lane, to, live) | ends)


def _join(lane: int, to: int, continues: bool, live: set[int], lanes: int) -> str:
    from_right = lane > to
    turn = ("┤" if from_right else "├") if continues else ("╯" if from_right else "╰")
    head = {to * LANE_PITCH_CHARACTERS + 1: "◄"} if from_right else {to * LANE_PITCH_CHARACTERS - 1: "►"}
    return _row(
        live,
        lanes,
        _across(lane, to, live)
        | head
        | {lane * LANE_PITCH_CHARACTERS: turn, to * LANE_PITCH_CHARACTERS: "│"},
    )


def _across(lane: int, to: int, live: set[int]) -> dict[int, str]:
    """Return a horizontal line between two lanes that crosses those in between."""
    first, last = sorted((lane * LANE_PITCH_CHARACTERS, to * LANE_PITCH_CHARACTERS))
    crossed = {each * LANE_PITCH_CHARACTERS for each in live}
    return {at: "┼" if at in crossed else "─" for at in range(first + 1, last)}


def _row(live: set[int], lanes: int, drawn: dict[int, str] | None = None) -> str:
    row = [" "] * (lanes * LANE_PITCH_CHARACTERS)
    for at, character in ({lane * LANE_PITCH_CHARACTERS: "│" for lane in live} | (drawn or {})).items():
        row[at] = character
    return "".join(row)


def _encodable(line: str, encoding: str) -> str:
    try:
        line.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return line.translate(_ASCII_FALLBACKS)
    return line
