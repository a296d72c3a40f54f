"""The graph of a style: its blocks with their inputs, each laid out in a lane below its main input."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from vidstyle.blocks import all_blocks
from vidstyle.style import SOURCE, Step, Style
from vidstyle.style.wiring import WiredStep, wire_layers


@dataclass
class GraphBlock:
    """One block of the graph: a step, the source or the result.

    Attributes:
        layer: the layer of the step; empty for the source and the result.
        title: the name of the step's block, or a description.
        kind: the kind of the block; "source" or "result".
        settings: values that differ from their defaults and the saved pictures that it uses, as text.
        source: the name of its input, where that is not the previous block's picture.
        saves: the names under which its picture is saved.
        inputs: the indices of the blocks whose pictures it uses, each with the names by which it refers to
            them; the first is its main input.
    """

    layer: str
    title: str
    kind: str
    settings: dict[str, str] = field(default_factory=dict)
    source: str = ""
    saves: list[str] = field(default_factory=list)
    inputs: dict[int, list[str]] = field(default_factory=dict)

    @property
    def words(self) -> list[str]:
        """Where it starts from, and its settings."""
        start = [f"from {self.source}"] * bool(self.source)
        return [*start, *(f"{name} = {text}" for name, text in self.settings.items())]

    def add_input(self, number: int, name: str = "") -> None:
        """Add the picture of a block."""
        names = self.inputs.setdefault(number, [])
        if name and name not in names:
            names.append(name)


def blocks_of(style: Style) -> list[GraphBlock]:
    """The source, the steps and the result; steps without a block only name pictures."""
    found = _BlockList()
    ends = {"base": 0}
    for wired in wire_layers(style.layers, style.masks):
        ends[wired.layer] = found.add_step(wired)
    found.add_result(style, ends)
    return found.blocks


class _BlockList:
    """Adds the blocks of a style in running order."""

    def __init__(self) -> None:
        self.blocks = [GraphBlock("", SOURCE, "source")]
        self._positions: dict[int | None, int] = {None: 0}
        """The index of the block whose picture each step ends with."""

    def add_step(self, wired: WiredStep) -> int:
        """Add a step; return the index of the block whose picture is current after it."""
        block, step = wired.wiring.block, wired.step
        current = self._positions[wired.start]
        for name in wired.wiring.reads.values():
            self._name(self._positions[wired.savers[name]], name)
        if block is not None:
            title = f"{block.name} (muted)" if step.mute else block.name
            added = GraphBlock(wired.layer, title, block.kind, _settings(step), step.source)
            added.add_input(current, step.source)
            for name in wired.wiring.pictures.values():
                added.add_input(self._positions[wired.savers[name]], name)
            self.blocks.append(added)
            current = len(self.blocks) - 1
        self._positions[len(self._positions) - 1] = current
        if step.save:
            self._name(current, step.save)
        return current

    def _name(self, number: int, name: str) -> None:
        """Record that a block saves a picture under a name."""
        if name != SOURCE and name not in self.blocks[number].saves:
            self.blocks[number].saves.append(name)

    def add_result(self, style: Style, ends: dict[str, int]) -> None:
        """Add the result of all layers."""
        over = style.background or not style.lines
        title = "ink over colour" if style.lines and over else "ink on paper" if style.lines else "result"
        used = {"ink": style.ink} if style.lines else {}
        used |= {"paper": style.paper} if style.paper != Style.paper else {}
        result = GraphBlock("", title, "result", used)
        if over:
            result.add_input(ends.get("background", ends["base"]))
        if style.lines:
            result.add_input(ends["lines"])
        self.blocks.append(result)


def _settings(step: Step) -> dict[str, str]:
    block = all_blocks()[step.block]
    return {
        name: value_text(value)
        for name, value in step.values.items()
        if value != block.parameters[name].default or name in block.saved_refs
    }


def value_text(value: Any) -> str:
    """A value as text: 3.0 as 3, a truth value as in a style file.

    >>> value_text(3.0), value_text(True), value_text("multiply")
    ('3', 'true', 'multiply')
    """
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, int | float) else str(value)


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
