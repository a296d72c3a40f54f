"""The edits of steps: pure functions that return new content, see `edits`."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Annotated

from vidstyle.block import NAME_PATTERN, Asset, SavedRef
from vidstyle.design.document.content import Content, PlacedStep, ValueRef
from vidstyle.design.document.edit_values import (
    EditResult,
    NewNumber,
    find_block,
    label_of,
    name_of,
    parameter_of,
    parse_value,
    value_text,
    with_value,
)
from vidstyle.design.document.expansion import expand_recipe
from vidstyle.design.document.step_text import steps_in_text
from vidstyle.errors import UsageError, suggest
from vidstyle.style import LAYERS, SOURCE
from vidstyle.style.check import MAX_STEPS
from vidstyle.style.files import MAX_FILE
from vidstyle.style.model import step_from_table
from vidstyle.style.wiring import wiring_of
from vidstyle.web.messages import AnyValue, TextOrEmpty, text_between

StepsText = Annotated[str, text_between(1, MAX_FILE)]

CATEGORY_LAYERS = {"lines": "lines", "smooth": "base", "size": "base", "parts": "base"}
"""The layers of blocks by category; blocks of other categories go to the background."""


def add(content: Content, new: NewNumber, layer: TextOrEmpty, index: int, block: TextOrEmpty) -> EditResult:
    """Add a step with default values; an empty `block` adds a step that restarts from the source.

    `layer`: an empty one stands for the layer of blocks of this category.
    """
    found = find_block(block)
    layer = layer or CATEGORY_LAYERS.get(found.category if found else "", "background")
    step = PlacedStep(new(), {"block": block} if block else {"from": SOURCE})
    return EditResult(_insert(content, layer, index, step), f"Add {label_of(step)}", step.number)


def show_behind_lines(content: Content, new: NewNumber) -> EditResult:
    """Show the picture behind lines on plain paper: add a background step that keeps it unchanged."""
    saved = {each.table.get("save") for _, _, each in content.steps}
    name = next(
        name for name in ("picture", *(f"picture-{n}" for n in range(2, MAX_STEPS))) if name not in saved
    )
    step = PlacedStep(new(), {"save": name})
    return EditResult(
        _insert(content, "background", 0, step), "Put the picture behind the lines", step.number
    )


def move(content: Content, new: NewNumber, step: int, layer: str, index: int) -> EditResult:
    """Move a step to an index in a layer; the index does not count the step itself."""
    old, place, moved = content.place_of(step)
    rest = content.layers[old][:place] + content.layers[old][place + 1 :]
    layers = {**content.layers, old: rest}
    layers[layer] = _with(layers[_check_layer(layer)], index, moved)
    return EditResult(replace(content, layers=layers), f"Move {label_of(moved)}")


def remove(content: Content, new: NewNumber, step: int) -> EditResult:
    """Remove a step, its knobs, and its values in variants."""
    layer, place, gone = content.place_of(step)
    rest = content.layers[layer][:place] + content.layers[layer][place + 1 :]
    return EditResult(content.with_layer(layer, rest), f"Remove {label_of(gone)}")


def duplicate(content: Content, new: NewNumber, step: int) -> EditResult:
    """Add a copy after a step; the copy does not save its output."""
    layer, place, old = content.place_of(step)
    copied = {key: value for key, value in old.table.items() if key != "save"}
    copy = PlacedStep(new(), copied if copied else {"from": SOURCE})
    return EditResult(_insert(content, layer, place + 1, copy), f"Duplicate {label_of(old)}", copy.number)


def paste(content: Content, new: NewNumber, layer: str, index: int, text: StepsText) -> EditResult:
    """Add the steps in a text."""
    steps = [PlacedStep(new(), table or {"from": SOURCE}) for table in steps_in_text(content, text)]
    for place, step in enumerate(steps, index):
        content = _insert(content, layer, place, step)
    label = label_of(steps[0]) if len(steps) == 1 else f"{len(steps)} steps"
    return EditResult(content, f"Paste {label}", steps[0].number)


def set_value(content: Content, new: NewNumber, step: int, name: str, value: AnyValue) -> EditResult:
    """Set a parameter of a step."""
    _, _, old = content.place_of(step)
    parameter = parameter_of(old, name)
    value = parse_value(parameter, value)
    label = content.label_of(ValueRef(step, name), parameter)
    return EditResult(with_value(content, old, parameter, value), f"{label}: {value_text(value)}")


def refer(content: Content, new: NewNumber, step: int, name: str, value: TextOrEmpty) -> EditResult:
    """Set the input of a step ("from"), the name of its saved output ("save"), or a picture or file.

    Renaming a saved picture also renames it in the steps that read it.
    """
    _, _, old = content.place_of(step)
    if name not in ("from", "save"):
        if not isinstance(parameter_of(old, name).control, SavedRef | Asset):
            raise UsageError(f"{name_of(old)} {name}", "is not a picture or a file")
        return set_value(content, new, step, name, value)
    if value and not re.fullmatch(NAME_PATTERN, value):
        raise UsageError(value, "is not a name of letters and digits")
    table = {key: each for key, each in old.table.items() if key != name} | ({name: value} if value else {})
    changed = content.with_step(step, table if table else {"from": SOURCE})
    before = old.table.get("save")
    if name == "save" and before and value:
        changed = _rename_picture(changed, str(before), value)
    return EditResult(changed, f"{label_of(old)}: {name} {value or 'nothing'}")


def mute(content: Content, new: NewNumber, step: int, on: bool) -> EditResult:
    """Bypass a step, or restore it."""
    _, _, old = content.place_of(step)
    table = {key: value for key, value in old.table.items() if key != "mute"} | ({"mute": True} if on else {})
    return EditResult(content.with_step(step, table), f"{'Mute' if on else 'Unmute'} {label_of(old)}")


def expand(content: Content, new: NewNumber, step: int) -> EditResult:
    """Replace a recipe with its steps, which produce the same picture."""
    layer, place, old = content.place_of(step)
    parts = [PlacedStep(new(), table) for table in expand_recipe(content, old)]
    steps = content.layers[layer]
    if len(list(content.steps)) + len(parts) - 1 > MAX_STEPS:
        raise UsageError(name_of(old), f"cannot be expanded: a style has at most {MAX_STEPS} steps")
    changed = content.with_layer(layer, (*steps[:place], *parts, *steps[place + 1 :]))
    return EditResult(changed, f"Expand {label_of(old)}", parts[0].number)


def _check_layer(layer: str) -> str:
    if layer not in LAYERS:
        raise UsageError(layer, "is not a layer", suggest(layer, LAYERS))
    return layer


def _with(steps: tuple[PlacedStep, ...], index: int, step: PlacedStep) -> tuple[PlacedStep, ...]:
    if not 0 <= index <= len(steps):
        raise UsageError(f"position {index}", f"is not in the layer, which has {len(steps)} steps")
    return (*steps[:index], step, *steps[index:])


def _insert(content: Content, layer: str, index: int, step: PlacedStep) -> Content:
    if len(list(content.steps)) >= MAX_STEPS:
        raise UsageError(name_of(step), f"cannot be added: a style has at most {MAX_STEPS} steps")
    steps = _with(content.layers[_check_layer(layer)], index, step)
    return replace(content, layers={**content.layers, layer: steps})


def _rename_picture(content: Content, before: str, after: str) -> Content:
    """Return the content with a saved picture renamed in the steps that read it."""
    if any(step.table.get("save") == before for _, _, step in content.steps):
        return content
    for _, _, step in content.steps:
        reads = wiring_of(step_from_table(step.table)).reads
        renamed = {key: after for key, name in reads.items() if name == before}
        content = content.with_step(step.number, {**step.table, **renamed})
    return content
