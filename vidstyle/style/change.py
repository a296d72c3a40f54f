"""Styles made from other styles: with values set, with a variant applied, with recipes expanded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from vidstyle.block import Block, Control, On
from vidstyle.core.file_checks import parse_toml
from vidstyle.errors import StyleError, UsageError
from vidstyle.style.check import style_from_table
from vidstyle.style.model import Step, Style, table_from_style
from vidstyle.style.paths import find_value
from vidstyle.style.variants import table_of_variant
from vidstyle.style.wiring import wiring_of


def set_values(style: Style, values: Mapping[str, object]) -> Style:
    """Return the style with some values set.

    Args:
        style: any style, its recipes not expanded.
        values: by their paths: "posterize.levels"; where a block occurs more than once,
            "lines.posterize.levels" or "posterize#2.levels"; or a field of the style, "ink".

    Raises:
        UsageError: names all mistakes.
    """
    return _changed(style, list(values), lambda table, path: find_value(table, path).set(values[path]))


def override(style: Style, assignments: Iterable[str]) -> Style:
    """Return the style with some values set, given as text: "posterize.levels=5", "ink=#202040".

    Raises:
        UsageError: names all mistakes.
    """

    def assign(table: dict[str, Any], text: str) -> None:
        path, equals, value = text.partition("=")
        if not equals:
            raise ValueError(f"{text!r} is not written as step.parameter=value")
        found = find_value(table, path)
        found.set(_parse(found.parameter.control, value))

    return _changed(style, list(assignments), assign)


def apply_variant(style: Style, variant: str) -> Style:
    """Return the style with the values of one of its variants, named "ink:dark-blue".

    Raises:
        StyleError: it has no such variant.
    """
    table = table_of_variant(replace(style, behind=None), variant)
    return _with_behind(style_from_table(table, style.name, folder=style.folder), style)


def expand(style: Style) -> Style:
    """Return the style as it runs: every recipe replaced by its steps, muted steps by what they save.

    Lines of which all steps are muted are not laid over the background.
    """
    layers: dict[str, Any] = {
        layer: tuple(part for step in steps for part in _expand_step(step))
        for layer, steps in style.layers.items()
    }
    if all(step.mute for step in style.lines):
        layers["lines"] = ()
    return replace(style, **layers)


def _expand_step(step: Step) -> tuple[Step, ...]:
    """Return a recipe's steps: the first has the recipe's input, the last saves what the recipe saved."""
    wiring = wiring_of(step)
    block = wiring.block
    if step.mute:
        return tuple(Step("", save=save, source=step.source) for save in wiring.saves or ("",))
    if block is None or block.kind != "recipe":
        return (step,)
    on: On | None = "luma" if "luma" in (step.on, block.on) else step.on
    defaults = {name: parameter.default for name, parameter in block.parameters.items()}
    parts: list[tuple[Block, dict[str, Any]]] = block.function(**defaults | step.values)
    steps = [Step(part.name, values, on=on) for part, values in parts] or [Step("")]
    steps[0] = replace(steps[0], source=step.source)
    steps[-1] = replace(steps[-1], save=step.save)
    return tuple(part for each in steps for part in _expand_step(each))


def _changed(style: Style, texts: list[str], assign: Callable[[dict[str, Any], str], None]) -> Style:
    """Return the style after `assign` was called with its table for each text."""
    table = table_from_style(replace(style, behind=None))
    mistakes: list[str] = []
    for text in texts:
        try:
            assign(table, text)
        except ValueError as error:
            mistakes.append(str(error))
    try:
        changed = style_from_table(table, style.name, folder=style.folder)
    except StyleError as error:
        mistakes += error.mistakes
    if mistakes:
        raise UsageError(", ".join(texts), "; ".join(mistakes))
    is_chosen = style.keeps_detail or "height" in (text.partition("=")[0].strip() for text in texts)
    return replace(_with_behind(changed, style), keeps_detail=is_chosen)


def _with_behind(changed: Style, style: Style) -> Style:
    """Return a changed style with `behind` as before: its files may be in another folder."""
    return replace(changed, behind=style.behind)


def _parse(control: Control, text: str) -> object:
    """Return the value written after "=": in TOML, or a bare word where the control takes text."""
    try:
        parsed = parse_toml(f"value = {text}")
    except ValueError:
        parsed = {}
    value = parsed.get("value") if len(parsed) == 1 else None
    if value is None or (control.takes_text and not isinstance(value, str)):
        return text.strip()
    return value
