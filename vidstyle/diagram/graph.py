"""Where the blocks of a style's graph stand: each below the one that it goes on from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from vidstyle.diagram.blocks import GraphBlock, blocks_of
from vidstyle.style import Style


class Move(NamedTuple):
    """A line changes its lane just above a row."""

    row: int
    lane: int
    to: int


@dataclass(frozen=True)
class DiagramEdge:
    """A picture on its way from a block to one that is given it.

    Attributes:
        start, end: the numbers of the blocks.
        names: by which it is asked for; none for that of the block before.
        goes_on: whether it is needed later as well.
        moves: on its way from lane to lane, downwards.
    """

    start: int
    end: int
    names: tuple[str, ...]
    goes_on: bool
    moves: tuple[Move, ...]


@dataclass(frozen=True)
class DiagramNode:
    """A block in its place.

    Attributes:
        row, lane: its place; several blocks may stand in one row.
        edges: what it is given; the first, from right above, is what it goes on from.
        aside: the lane to which that one moves, to be needed later; None where it ends here.
        used: whether a later block is given its picture.
    """

    block: GraphBlock
    row: int
    lane: int
    edges: tuple[DiagramEdge, ...]
    aside: int | None
    used: bool


def graph_of(style: Style) -> tuple[DiagramNode, ...]:
    """The graph of a style: the source, its steps in the order in which they run, and the result."""
    blocks = blocks_of(style)
    lanes = _Lanes(Counter(number for block in blocks for number in block.inputs))
    return tuple(lanes.place(number, block) for number, block in enumerate(blocks))


class _Line(NamedTuple):
    """A picture that is still needed: its lane, the first row there that a block may take, and its way."""

    lane: int
    row: int
    moves: tuple[Move, ...] = ()


class _Lanes:
    """Knows which picture's line, if any, is in each lane.

    Args:
        uses: how many blocks are given the picture of each block.
    """

    def __init__(self, uses: Counter[int]) -> None:
        self._uses = uses
        self._lines: dict[int, _Line] = {}
        self._free: dict[int, int] = {}
        """The lanes without a line, and the first row that is empty in each."""

    def place(self, number: int, block: GraphBlock) -> DiagramNode:
        """Put a block below the one that it goes on from, whose line moves aside if it is needed later."""
        lines = [self._lines[given] for given in block.inputs]
        row = max((line.row for line in lines), default=0)
        lane = lines[0].lane if lines else self._take(0)
        edges, aside = [], None
        for position, (given, names) in enumerate(block.inputs.items()):
            line = self._lines[given]
            self._uses[given] -= 1
            goes_on = self._uses[given] > 0
            moves = line.moves if line.lane == lane else (*line.moves, Move(row, line.lane, lane))
            edges.append(DiagramEdge(given, number, tuple(names), goes_on, moves))
            if position == 0 and goes_on:
                aside = self._take(row)
                self._lines[given] = _Line(aside, row, (*line.moves, Move(row, lane, aside)))
            elif goes_on:
                self._lines[given] = line._replace(row=row)
            else:
                del self._lines[given]
                if position > 0:
                    self._free[line.lane] = row
        used = self._uses[number] > 0
        if used:
            self._lines[number] = _Line(lane, row + 1)
        else:
            self._free[lane] = row + 1
        return DiagramNode(block, row, lane, tuple(edges), aside, used)

    def _take(self, row: int) -> int:
        """A lane that is free from a row on."""
        free = [lane for lane, first in self._free.items() if first <= row]
        lane = min(free, default=len(self._free) + len(self._lines))
        self._free.pop(lane, None)
        return lane
