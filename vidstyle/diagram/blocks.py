"""What the graph of a style is made of: its blocks in the order in which they run, and what each is given."""

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
        title: the name of the step's block, or what happens.
        kind: the kind of the block; "source" or "result".
        settings: the values that differ from their defaults, and the saved pictures that it uses, as text.
        source: the name of the picture that it goes on from, where that is not the one before.
        saves: the names under which others find its picture.
        inputs: the numbers of the blocks whose pictures it is given, each with the names by which it asks
            for them; the first is the one that it goes on from.
    """

    layer: str
    title: str
    kind: str
    settings: dict[str, str] = field(default_factory=dict)
    source: str = ""
    saves: list[str] = field(default_factory=list)
    inputs: dict[int, list[str]] = field(default_factory=dict)

    def take(self, number: int, name: str = "") -> None:
        """Let it be given the picture of a block."""
        names = self.inputs.setdefault(number, [])
        if name and name not in names:
            names.append(name)


def blocks_of(style: Style) -> list[GraphBlock]:
    """The source, the steps and the result; a step without a block only gives pictures names."""
    found = _Blocks()
    ends: dict[str, int] = {}
    for layer in LAYERS:
        current = ends.get("base", 0)
        for step in getattr(style, layer):
            current = found.follow(layer, step, current)
        ends[layer] = current
    found.end(style, ends)
    return found.blocks


class _Blocks:
    """Follows the steps of a style, and knows which pictures have names."""

    def __init__(self) -> None:
        self.blocks = [GraphBlock("", SOURCE, "source")]
        self.named = {SOURCE: 0}

    def follow(self, layer: str, step: Step, current: int) -> int:
        """The number of the block whose picture there is after a step."""
        if step.source:
            current = self.found(step.source)
        block = all_blocks().get(step.block)
        if block is not None:
            added = GraphBlock(layer, block.name, block.kind, _settings(step), step.source)
            added.take(current, step.source)
            for asked in _asked(step):
                added.take(self.found(asked), asked)
            self.blocks.append(added)
            current = len(self.blocks) - 1
            if block.saves:
                self.named[block.saves] = current
        if step.save:
            self.named[step.save] = current
            self.found(step.save)
        return current

    def found(self, name: str) -> int:
        """The number of the block whose picture has a name, which is noted there."""
        number = self.named[name]
        if name != SOURCE and name not in self.blocks[number].saves:
            self.blocks[number].saves.append(name)
        return number

    def end(self, style: Style, ends: dict[str, int]) -> None:
        """Add the result: what the layers become together."""
        over = style.background or not style.lines
        title = "ink over colour" if style.lines and over else "ink on paper" if style.lines else "result"
        used = {"ink": style.ink} if style.lines else {}
        used |= {"paper": style.paper} if style.paper != Style.paper else {}
        result = GraphBlock("", title, "result", used)
        if over:
            result.take(ends["background"])
        if style.lines:
            result.take(ends["lines"])
        self.blocks.append(result)


def _settings(step: Step) -> dict[str, str]:
    parameters = all_blocks()[step.block].parameters
    return {
        name: value_text(value)
        for name, value in step.values.items()
        if value != parameters[name].default or isinstance(parameters[name].control, SavedRef)
    }


def _asked(step: Step) -> list[str]:
    """The names of the saved pictures that a step uses."""
    parameters = all_blocks()[step.block].parameters.values()
    asked = (
        step.values.get(each.name, each.default) for each in parameters if isinstance(each.control, SavedRef)
    )
    return [name for name in asked if name]


def value_text(value: Any) -> str:
    """A value for people: 3.0 is 3, a truth value as in a style file, a text as it is.

    >>> value_text(3.0), value_text(True), value_text("multiply")
    ('3', 'true', 'multiply')
    """
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, int | float) else str(value)
