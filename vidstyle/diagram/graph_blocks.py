"""The blocks of a style's graph, in the order in which they run, and their inputs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from vidstyle.block import SavedRef
from vidstyle.blocks import all_blocks
from vidstyle.style import LAYERS, SOURCE, Step, Style


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

    def add_input(self, number: int, name: str = "") -> None:
        """Add the picture of a block."""
        names = self.inputs.setdefault(number, [])
        if name and name not in names:
            names.append(name)


def blocks_of(style: Style) -> list[GraphBlock]:
    """The source, the steps and the result; steps without a block only name pictures."""
    found = _BlockList()
    ends: dict[str, int] = {}
    for layer in LAYERS:
        current = ends.get("base", 0)
        for step in getattr(style, layer):
            current = found.add_step(layer, step, current)
        ends[layer] = current
    found.add_result(style, ends)
    return found.blocks


class _BlockList:
    """Follows the steps of a style and keeps track of the saved pictures."""

    def __init__(self) -> None:
        self.blocks = [GraphBlock("", SOURCE, "source")]
        self.named = {SOURCE: 0}

    def add_step(self, layer: str, step: Step, current: int) -> int:
        """Add a step; returns the index of the block whose picture is current after it."""
        if step.source:
            current = self.find(step.source)
        block = all_blocks().get(step.block)
        if block is not None:
            added = GraphBlock(layer, block.name, block.kind, _settings(step), step.source)
            added.add_input(current, step.source)
            for name in _references(step):
                added.add_input(self.find(name), name)
            self.blocks.append(added)
            current = len(self.blocks) - 1
            if block.saves:
                self.named[block.saves] = current
        if step.save:
            self.named[step.save] = current
            self.find(step.save)
        return current

    def find(self, name: str) -> int:
        """The index of the block that saves a name, which is recorded there."""
        number = self.named[name]
        if name != SOURCE and name not in self.blocks[number].saves:
            self.blocks[number].saves.append(name)
        return number

    def add_result(self, style: Style, ends: dict[str, int]) -> None:
        """Add the result of all layers."""
        over = style.background or not style.lines
        title = "ink over colour" if style.lines and over else "ink on paper" if style.lines else "result"
        used = {"ink": style.ink} if style.lines else {}
        used |= {"paper": style.paper} if style.paper != Style.paper else {}
        result = GraphBlock("", title, "result", used)
        if over:
            result.add_input(ends["background"])
        if style.lines:
            result.add_input(ends["lines"])
        self.blocks.append(result)


def _settings(step: Step) -> dict[str, str]:
    parameters = all_blocks()[step.block].parameters
    return {
        name: value_text(value)
        for name, value in step.values.items()
        if value != parameters[name].default or isinstance(parameters[name].control, SavedRef)
    }


def _references(step: Step) -> list[str]:
    """The names of the saved pictures that a step uses."""
    parameters = all_blocks()[step.block].parameters.values()
    names = (
        step.values.get(each.name, each.default) for each in parameters if isinstance(each.control, SavedRef)
    )
    return [name for name in names if name]


def value_text(value: Any) -> str:
    """A value as text: 3.0 as 3, a truth value as in a style file.

    >>> value_text(3.0), value_text(True), value_text("multiply")
    ('3', 'true', 'multiply')
    """
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, int | float) else str(value)
