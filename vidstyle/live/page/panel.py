"""All that can be set on a style, as data for the sliders of a page."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from typing import Any

from vidstyle.block import Asset, Block, Choice, Color, Control, SavedRef, Slider, Switch
from vidstyle.blocks import all_blocks
from vidstyle.style import SOURCE, Style, set_values, table_from_style
from vidstyle.style.model import FIELDS, LAYERS
from vidstyle.style.paths import find_value, step_paths

WORDS = re.compile(r"`([^`]+)`")
"""What a note names as worth changing."""


def panel(style: Style, start: Style) -> dict[str, Any]:
    """What a page needs to show and change a style.

    Args:
        start: the style as it was when it was chosen, or the one whose variant was; what differs from it
            or from the variant has been changed by hand.
    """
    entries = list(_entries(style, start))
    variant = _variant(style, start)
    before = table_from_style(_varied(start, variant))
    changed = [entry for entry in entries if entry["value"] != _held(before, entry["path"])]
    name = f"{start.name}:{variant}" if variant else start.name
    return {
        "name": start.name,
        "note": style.note,
        "variant": variant,
        "variants": [_swatch(start, name) for name in start.variants],
        "entries": entries,
        "text": " ".join(["--style", shlex.quote(name), *(_setting(entry) for entry in changed)]),
    }


def _entries(style: Style, start: Style) -> Iterator[dict[str, Any]]:
    """One for each value: its path, what it may be, what it is and was at the start."""
    table, before = table_from_style(style), table_from_style(start)
    for path, parameter in FIELDS.items():
        if getattr(style, path) is not None:
            # Lengths are meant for one height, which is no matter of taste.
            place = {"path": path, "name": path, "layer": "", "step": "", "main": path != "height"}
            held = {"value": _held(table, path), "start": _held(before, path)}
            yield place | held | _described(parameter.control, False, [])
    named = _named(style, table)
    for step, (layer, block, saved) in zip(step_paths(table), _blocks(style), strict=True):
        for parameter in block.parameters.values():
            path = f"{step}.{parameter.name}"
            place = {"path": path, "name": parameter.name, "layer": layer, "step": step}
            held = {"value": _held(table, path), "start": _held(before, path)}
            about = {"about": block.help, "main": path in named}
            yield place | held | about | _described(parameter.control, parameter.is_integer, saved)


def _blocks(style: Style) -> Iterator[tuple[str, Block, list[str]]]:
    """Of each step that has a block: its layer, the block, and the pictures that are there by then."""
    saved = {SOURCE: None}
    for layer in LAYERS:
        for step in getattr(style, layer):
            block = all_blocks().get(step.block)
            if block is not None:
                yield layer, block, list(saved)
            saved |= dict.fromkeys(filter(None, [block.saves if block else "", step.save]))


def _described(control: Control, whole: bool, names: list[str]) -> dict[str, Any]:
    """The kind of a control and what belongs to it."""
    match control:
        case Slider():
            ends = {"low": control.low, "high": control.high, "whole": whole, "unit": control.unit}
            kind: dict[str, Any] = {"kind": "slider"} | ends
        case Switch():
            kind = {"kind": "switch"}
        case Color():
            kind = {"kind": "color"}
        case Choice():
            kind = {"kind": "choice", "options": list(control.options)}
        case SavedRef():
            kind = {"kind": "choice", "options": [""] * control.optional + names}
        case Asset():
            kind = {"kind": "choice", "options": ["", *sorted(control.shipped())]}
    return kind | {"help": control.help}


def _named(style: Style, table: dict[str, Any]) -> set[str]:
    """The full paths of the values that the note of the style names."""
    found = set()
    steps = {id(_step(table, path)): path for path in step_paths(table)}
    for word in WORDS.findall(style.note):
        try:
            place = find_value(table, word)
        except ValueError:  # a word that names no single value, such as that of a block
            continue
        found.add(f"{steps.get(id(place.table), '')}.{place.parameter.name}")
    return found


def _step(table: dict[str, Any], path: str) -> dict[str, Any]:
    block = path.rpartition(".")[2].partition("#")[0]
    parameters = all_blocks()[block].parameters
    return find_value(table, f"{path}.{next(iter(parameters))}").table if parameters else {}


def _held(table: dict[str, Any], path: str) -> Any:
    """The value in the table of a style that a path means."""
    return find_value(table, path).get()


def _variant(style: Style, start: Style) -> str:
    """The variant that the style is by its name, or whose values it has, all of them; or ""."""
    chosen = style.name.removeprefix(f"{start.name}:")
    if chosen in start.variants:
        return chosen
    table = table_from_style(style)
    for name, values in start.variants.items():
        if values and all(_held(table, path) == value for path, value in values.items()):
            return name
    return ""


def _varied(start: Style, variant: str) -> Style:
    values = start.variants.get(variant, {})
    return set_values(start, values)


def _swatch(start: Style, variant: str) -> dict[str, str]:
    varied = _varied(start, variant)
    return {"name": variant, "ink": varied.ink, "paper": varied.paper}


def _setting(entry: dict[str, Any]) -> str:
    value = entry["value"]
    if entry["kind"] == "slider":
        value = f"{value:g}"
    elif entry["kind"] == "switch":
        value = str(value).lower()
    return "--set " + shlex.quote(f"{entry['path']}={value}")
