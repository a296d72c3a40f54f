"""The edits of a style: pure functions that return new content.

An edit with invalid arguments is refused. An edit that makes the style invalid, such as by removing a picture
that another step reads, is accepted; the document then lists the mistakes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

from vidstyle.block import NAME_PATTERN, Asset, Block, Parameter, SavedRef
from vidstyle.block.search import suggest_block
from vidstyle.blocks import all_blocks
from vidstyle.design.document.content import Content, PlacedStep, ValueRef
from vidstyle.design.document.expansion import expand_recipe
from vidstyle.design.document.step_text import steps_in_text
from vidstyle.errors import UsageError, suggest
from vidstyle.style import LAYERS, SOURCE
from vidstyle.style.check import MAX_STEPS, TEXTS
from vidstyle.style.files import MAX_FILE
from vidstyle.style.knobs import MAX_KNOBS, MAX_LABEL_LENGTH, MAX_LABELS, is_label
from vidstyle.style.model import FIELDS, step_from_table
from vidstyle.style.values import read_values
from vidstyle.style.wiring import wiring_of
from vidstyle.web.messages import AnyValue, TextOrEmpty, text_between


@dataclass(frozen=True)
class EditResult:
    """The result of an edit: content, label for the history, and the number of a new step, if any."""

    content: Content
    label: str
    step: int | None = None


NewNumber = Callable[[], int]
NoteText = Annotated[str, text_between(0, 4 * TEXTS["note"])]
"""A note before its line breaks are joined."""
StepsText = Annotated[str, text_between(1, MAX_FILE)]


def add(content: Content, new: NewNumber, layer: str, index: int, block: TextOrEmpty) -> EditResult:
    """Add a step with default values; an empty `block` adds a step that restarts from the source."""
    _find_block(block)
    step = PlacedStep(new(), {"block": block} if block else {"from": SOURCE})
    return EditResult(_insert(content, layer, index, step), f"Add {label_of(step)}", step.number)


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
    parameter = _parameter_of(old, name)
    value = _parse_value(parameter, value)
    label = content.label_of(ValueRef(step, name), parameter)
    return EditResult(_with_value(content, old, parameter, value), f"{label}: {_text(value)}")


def set_field(content: Content, new: NewNumber, name: str, value: AnyValue | None) -> EditResult:
    """Set a field of the style; None resets it to its default."""
    if name not in FIELDS:
        raise UsageError(name, "is not a field of a style", suggest(name, FIELDS))
    default = FIELDS[name].default
    value = default if value is None else _parse_value(FIELDS[name], value)
    return EditResult(_with_field(content, name, value, default), f"{FIELDS[name].label}: {_text(value)}")


def refer(content: Content, new: NewNumber, step: int, name: str, value: TextOrEmpty) -> EditResult:
    """Set the input of a step ("from"), the name of its saved output ("save"), or a picture or file.

    Renaming a saved picture also renames it in the steps that read it.
    """
    _, _, old = content.place_of(step)
    if name not in ("from", "save"):
        if not isinstance(_parameter_of(old, name).control, SavedRef | Asset):
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


def knob(content: Content, new: NewNumber, step: int | None, name: str, on: bool) -> EditResult:
    """Pin a value to the style panel, or unpin it."""
    ref = ValueRef(step, name)
    label = content.label_of(ref, _declaration(content, ref))
    knobs = tuple(each for each in content.knobs if each != ref) if not on else content.knobs
    if on and ref not in knobs:
        knobs += (ref,)
    if len(knobs) > MAX_KNOBS:
        raise UsageError("knobs", f"are at most {MAX_KNOBS}", "remove one first")
    return EditResult(replace(content, knobs=knobs), f"{'Pin' if on else 'Unpin'} {label}")


def label(content: Content, new: NewNumber, step: int | None, name: str, text: TextOrEmpty) -> EditResult:
    """Set what a value is called in this style; an empty text restores the label of its parameter."""
    ref = ValueRef(step, name)
    parameter = _declaration(content, ref)
    text = " ".join(text.split())
    if text and not is_label(text):
        raise UsageError("label", f"is not a text of at most {MAX_LABEL_LENGTH} characters")
    labels = {each: old for each, old in content.labels.items() if each != ref}
    if text and text != parameter.label:
        labels[ref] = text
    if len(labels) > MAX_LABELS:
        raise UsageError("labels", f"are at most {MAX_LABELS}", "remove one first")
    return EditResult(replace(content, labels=labels), f"Rename {parameter.label}: {text or parameter.label}")


def variant(content: Content, new: NewNumber, name: str) -> EditResult:
    """Apply the values of a variant."""
    if name not in content.variants:
        raise UsageError(name, "is not a variant of this style", suggest(name, content.variants))
    for ref, value in content.variants[name]:
        if ref.step is None:
            content = _with_field(content, ref.name, value, FIELDS[ref.name].default)
        else:
            step = content.place_of(ref.step)[2]
            content = _with_value(content, step, _parameter_of(step, ref.name), value)
    return EditResult(content, f"Variant: {name}")


def rename(content: Content, new: NewNumber, name: str) -> EditResult:
    """Set the name of the style."""
    return EditResult(_with_field(content, "name", _line("name", name), ""), f"Name: {name}")


def note(content: Content, new: NewNumber, text: NoteText) -> EditResult:
    """Set the note of the style."""
    return EditResult(_with_field(content, "note", _line("note", text), ""), "Note")


def label_of(step: PlacedStep) -> str:
    """Return the name of a step in plain words."""
    block = all_blocks().get(str(step.table.get("block")))
    return block.label if block else name_of(step)


def name_of(step: PlacedStep) -> str:
    """Return the name of a step as the style file has it: usually its block."""
    return str(step.table.get("block") or step.table.get("from") or step.table.get("save"))


EDITS: Mapping[str, Callable[..., EditResult]] = {
    "add": add,
    "move": move,
    "remove": remove,
    "duplicate": duplicate,
    "paste": paste,
    "set": set_value,
    "field": set_field,
    "refer": refer,
    "mute": mute,
    "expand": expand,
    "knob": knob,
    "label": label,
    "variant": variant,
    "rename": rename,
    "note": note,
}
"""All edits by name. Each is a message of the page, whose fields are the parameters after `new`."""


def _check_layer(layer: str) -> str:
    if layer not in LAYERS:
        raise UsageError(layer, "is not a layer", suggest(layer, LAYERS))
    return layer


def _find_block(name: str) -> Block | None:
    if name and name not in all_blocks():
        raise UsageError(name, "is not a block", suggest_block(name, all_blocks()))
    return all_blocks()[name] if name else None


def _with(steps: tuple[PlacedStep, ...], index: int, step: PlacedStep) -> tuple[PlacedStep, ...]:
    if not 0 <= index <= len(steps):
        raise UsageError(f"position {index}", f"is not in the layer, which has {len(steps)} steps")
    return (*steps[:index], step, *steps[index:])


def _insert(content: Content, layer: str, index: int, step: PlacedStep) -> Content:
    if len(list(content.steps)) >= MAX_STEPS:
        raise UsageError(name_of(step), f"cannot be added: a style has at most {MAX_STEPS} steps")
    steps = _with(content.layers[_check_layer(layer)], index, step)
    return replace(content, layers={**content.layers, layer: steps})


def _parameter_of(step: PlacedStep, name: str) -> Parameter:
    block = _find_block(str(step.table.get("block", "")))
    parameters = block.parameters if block else {}
    if name not in parameters:
        raise UsageError(f"{name_of(step)} {name}", "is not a parameter", suggest(name, parameters))
    return parameters[name]


def _declaration(content: Content, ref: ValueRef) -> Parameter:
    if ref.step is not None:
        return _parameter_of(content.place_of(ref.step)[2], ref.name)
    if ref.name not in FIELDS:
        raise UsageError(ref.name, "is not a field of a style", suggest(ref.name, FIELDS))
    return FIELDS[ref.name]


def _parse_value(parameter: Parameter, value: object) -> Any:
    mistakes: list[str] = []
    values = read_values({parameter.name: parameter}, {parameter.name: value}, "", mistakes)
    if mistakes:
        name, _, reason = mistakes[0].partition(": ")
        raise UsageError(name, reason)
    return values[parameter.name]


def _with_value(content: Content, step: PlacedStep, parameter: Parameter, value: Any) -> Content:
    """Return the content with a value of a step set, or removed if it is the default."""
    table = dict(step.table)
    if value == parameter.default:
        table.pop(parameter.name, None)
    else:
        table[parameter.name] = value
    return content.with_step(step.number, table)


def _with_field(content: Content, name: str, value: Any, default: Any) -> Content:
    order = ("name", *TEXTS, *FIELDS)
    fields = {**content.fields, name: value}
    kept = {key: fields[key] for key in order if key in fields and (key != name or value != default)}
    return replace(content, fields=kept)


def _rename_picture(content: Content, before: str, after: str) -> Content:
    """Return the content with a saved picture renamed in the steps that read it."""
    if any(step.table.get("save") == before for _, _, step in content.steps):
        return content
    for _, _, step in content.steps:
        reads = wiring_of(step_from_table(step.table)).reads
        renamed = {key: after for key, name in reads.items() if name == before}
        content = content.with_step(step.number, {**step.table, **renamed})
    return content


def _line(key: str, text: str) -> str:
    line = " ".join(text.split())
    if len(line) > TEXTS[key] or not line.isprintable():
        raise UsageError(key, f"is not a text of at most {TEXTS[key]} characters")
    return line


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value).lower() if value is not None else "none"
