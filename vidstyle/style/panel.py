"""The parameters of a style as data for the controls of a page."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.style import Style, set_values, table_from_style
from vidstyle.style.change import apply_variant
from vidstyle.style.knobs import knobs_of, labelled_values
from vidstyle.style.mask_declarations import MaskRef
from vidstyle.style.model import FIELDS
from vidstyle.style.paths import find_value, steps_by_path
from vidstyle.style.wiring import wire_layers


def panel(style: Style, start: Style) -> dict[str, Any]:
    """Everything that a page needs to show and change a style.

    Args:
        start: the selected style without a variant; values that differ from it or from its variant are
            overrides.
    """
    entries = list(_entries(style, start))
    variant = _variant(style, start)
    before = table_from_style(_with_variant(start, variant))
    changed = _changed(entries, before)
    name = f"{start.name}:{variant}" if variant else start.name
    return {
        "name": start.name,
        "note": style.note,
        "variant": variant,
        "variants": [_swatch(start, name) for name in start.variants],
        "entries": entries,
        "text": " ".join(["--style", shlex.quote(name), *(_option(before, entry) for entry in changed)]),
    }


def switch_variant(style: Style, start: Style, variant: str) -> Style:
    """Return another variant of a style; changed values stay, unless either variant sets them.

    Args:
        style: with changed values.
        start: the style without a variant and changes.
        variant: its name; "" for the style itself.

    Raises:
        StyleError: it has no such variant.
    """
    present = _variant(style, start)
    table = table_from_style(_with_variant(start, present))
    varied = apply_variant(start, variant) if variant else start
    kept = {entry["path"]: entry["value"] for entry in _changed(list(_entries(style, start)), table)}
    either = [start.variants[name] for name in (present, variant) if name] or start.variants.values()
    for path in {path for values in either for path in values}:
        kept.pop(path, None)
    return set_values(varied, kept)


def _changed(entries: list[dict[str, Any]], table: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the entries whose value differs from the value in the table of a style."""
    return [entry for entry in entries if entry["value"] != _value(table, entry["path"])]


def _entries(style: Style, start: Style) -> Iterator[dict[str, Any]]:
    """For each parameter its path, its control, its value and its value at the start."""
    table, before = table_from_style(style), table_from_style(start)

    def values(path: str) -> dict[str, Any]:
        return {"path": path, "value": _value(table, path), "start": _value(before, path)}

    named, knobs = labelled_values(style, table), knobs_of(style, table)
    for name, parameter in FIELDS.items():
        # A page cannot compute masks.
        if getattr(style, name) is not None and not isinstance(parameter.control, MaskRef):
            # `height` is the reference for lengths, not a parameter to adjust.
            place = {"name": name, "layer": "", "step": "", "main": name != "height"}
            yield place | values(name) | named.get(name, parameter).describe([])
    wired_blocks = [wired for wired in wire_layers(style.layers, style.masks) if wired.wiring.block]
    for step, wired in zip(steps_by_path(table), wired_blocks, strict=True):
        block = all_blocks()[wired.step.block]
        layer, saved = wired.layer, list(wired.savers)
        for name, parameter in block.parameters.items():
            path = f"{step}.{name}"
            place = {"name": name, "layer": layer, "step": step, "about": block.help, "main": path in knobs}
            described = named.get(path, parameter).describe(saved)
            yield place | values(path) | described | {"block_label": block.label}


def _value(table: dict[str, Any], path: str) -> Any:
    """Return the value at a path in the table of a style."""
    return find_value(table, path).get()


def _variant(style: Style, start: Style) -> str:
    """Return the variant that the style is: by its name, or because it has all of its values; else ""."""
    chosen = style.name.removeprefix(f"{start.name}:")
    if chosen in start.variants:
        return chosen
    table = table_from_style(style)
    for name, values in start.variants.items():
        if values and all(_value(table, path) == value for path, value in values.items()):
            return name
    return ""


def _with_variant(start: Style, variant: str) -> Style:
    return set_values(start, start.variants.get(variant, {}))


def _swatch(start: Style, variant: str) -> dict[str, Any]:
    varied, values = _with_variant(start, variant), start.variants[variant]
    others = [value for path, value in values.items() if path not in FIELDS and is_color(value)]
    return {"name": variant, "ink": varied.ink, "paper": varied.paper, "colors": others}


def is_color(value: object) -> bool:
    """Whether a value of a style is a colour.

    >>> is_color("#ff9460"), is_color("soft"), is_color(3)
    (True, False, False)
    """
    return isinstance(value, str) and value.startswith("#")


def _option(table: dict[str, Any], entry: dict[str, Any]) -> str:
    """Return the option of the command line that sets the value of an entry."""
    control = find_value(table, entry["path"]).parameter.control
    return "--set " + shlex.quote(f"{entry['path']}={control.text(entry['value'])}")
