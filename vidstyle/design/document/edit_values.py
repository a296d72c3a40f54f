"""What edits share: their result, the names of steps, and values that are read and set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from vidstyle.block import Block, Parameter
from vidstyle.block.search import suggest_block
from vidstyle.blocks import all_blocks
from vidstyle.design.document.content import Content, PlacedStep, ValueRef
from vidstyle.errors import UsageError, suggest
from vidstyle.style.model import FIELDS
from vidstyle.style.values import read_values

NewNumber = Callable[[], int]
"""Returns the number of a new step."""


@dataclass(frozen=True)
class EditResult:
    """The result of an edit: content, label for the history, and the number of a new step, if any."""

    content: Content
    label: str
    step: int | None = None


def label_of(step: PlacedStep) -> str:
    """Return the name of a step in plain words."""
    block = all_blocks().get(str(step.table.get("block")))
    return block.label if block else name_of(step)


def name_of(step: PlacedStep) -> str:
    """Return the name of a step as the style file has it: usually its block."""
    return str(step.table.get("block") or step.table.get("from") or step.table.get("save"))


def find_block(name: str) -> Block | None:
    """Return a block; None for an empty name."""
    if name and name not in all_blocks():
        raise UsageError(name, "is not a block", suggest_block(name, all_blocks()))
    return all_blocks()[name] if name else None


def parameter_of(step: PlacedStep, name: str) -> Parameter:
    """Return the declaration of a parameter of a step."""
    block = find_block(str(step.table.get("block", "")))
    parameters = block.parameters if block else {}
    if name not in parameters:
        raise UsageError(f"{name_of(step)} {name}", "is not a parameter", suggest(name, parameters))
    return parameters[name]


def declaration_of(content: Content, ref: ValueRef) -> Parameter:
    """Return the declaration of a parameter of a step, or of a field of the style."""
    if ref.step is not None:
        return parameter_of(content.place_of(ref.step)[2], ref.name)
    if ref.name not in FIELDS:
        raise UsageError(ref.name, "is not a field of a style", suggest(ref.name, FIELDS))
    return FIELDS[ref.name]


def parse_value(parameter: Parameter, value: object) -> Any:
    """Return a valid value of a parameter."""
    mistakes: list[str] = []
    values = read_values({parameter.name: parameter}, {parameter.name: value}, "", mistakes)
    if mistakes:
        name, _, reason = mistakes[0].partition(": ")
        raise UsageError(name, reason)
    return values[parameter.name]


def with_value(content: Content, step: PlacedStep, parameter: Parameter, value: Any) -> Content:
    """Return the content with a value of a step set, or removed if it is the default."""
    table = dict(step.table)
    if value == parameter.default:
        table.pop(parameter.name, None)
    else:
        table[parameter.name] = value
    return content.with_step(step.number, table)


def value_text(value: Any) -> str:
    """Return a value as text for the history."""
    return f"{value:g}" if isinstance(value, float) else str(value).lower() if value is not None else "none"
