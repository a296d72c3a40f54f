"""The layout of a style's graph: each block in a lane below its main input."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from vidstyle.diagram.graph_blocks import GraphBlock, blocks_of
from vidstyle.style import Style


class Move(NamedTuple):
    """A line changes its lane in the gap above a row."""

    row: int
    lane: int
    to: int


@dataclass(frozen=True)
class DiagramEdge:
    """The line of a picture from a block to one that uses it.

    Attributes:
        start, end: the indices of the blocks.
        names: the names by which it is used; none for the previous block's picture.
        continues: whether a later block uses it too.
        moves: its changes of lanes, from top to bottom.
    """

    start: int
    end: int
    names: tuple[str, ...]
    continues: bool
    moves: tuple[Move, ...]


@dataclass(frozen=True)
class DiagramNode:
    """A block at its position.

    Attributes:
        row, lane: its position; a row may hold several blocks.
        edges: its inputs; the first, from directly above, is the main one.
        aside: the lane to which the main input moves because it is used later; None if it ends here.
        used: whether a later block uses its picture.
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
    """A picture that is still needed: its lane, the first free row there, and its moves so far."""

    lane: int
    row: int
    moves: tuple[Move, ...] = ()


class _Lanes:
    """Keeps track of the picture's line in each lane.

    Args:
        uses: the number of blocks that use each block's picture.
    """

    def __init__(self, uses: Counter[int]) -> None:
        self._uses = uses
        self._lines: dict[int, _Line] = {}
        self._free: dict[int, int] = {}
        """The lanes without a line, and the first row that is empty in each."""

    def place(self, number: int, block: GraphBlock) -> DiagramNode:
        """Place a block below its main input, whose line moves aside if it is needed later."""
        lines = [self._lines[given] for given in block.inputs]
        row = max((line.row for line in lines), default=0)
        lane = lines[0].lane if lines else self._take(0)
        edges, aside = [], None
        for position, (given, names) in enumerate(block.inputs.items()):
            line = self._lines[given]
            self._uses[given] -= 1
            continues = self._uses[given] > 0
            moves = line.moves if line.lane == lane else (*line.moves, Move(row, line.lane, lane))
            edges.append(DiagramEdge(given, number, tuple(names), continues, moves))
            if position == 0 and continues:
                aside = self._take(row)
                self._lines[given] = _Line(aside, row, (*line.moves, Move(row, lane, aside)))
            elif continues:
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
        """Take a lane that is free from a row on."""
        free = [lane for lane, first in self._free.items() if first <= row]
        lane = min(free, default=len(self._free) + len(self._lines))
        self._free.pop(lane, None)
        return lane
