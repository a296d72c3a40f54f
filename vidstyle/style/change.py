"""Styles made from other styles: with values set by hand, and with recipes written out."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from vidstyle.block import Asset, Block, Choice, Color, Control, On, SavedRef
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError, UsageError
from vidstyle.style.check import style_from_table
from vidstyle.style.model import LAYERS, Step, Style, table_from_style
from vidstyle.style.paths import find_place
from vidstyle.style.variants import varied_table


def override(style: Style, assignments: Iterable[str]) -> Style:
    """The style with some values set, as `--set` does.

    Args:
        style: any style that holds its recipes as such.
        assignments: "posterize.levels=5"; where a block occurs more than once, "lines.posterize.levels=5"
            or "posterize#2.levels=5"; or a field of the style, "ink=#202040".

    Raises:
        UsageError: with all that is wrong with the assignments.
    """
    assignments = list(assignments)
    table = table_from_style(style)
    mistakes = [mistake for text in assignments if (mistake := _assign(table, text))]
    try:
        changed = style_from_table(table, style.name, folder=style.folder)
    except StyleError as error:
        mistakes += error.mistakes
    if mistakes:
        raise UsageError(", ".join(assignments), "; ".join(mistakes))
    return changed


def apply_variant(style: Style, variant: str) -> Style:
    """The style with the values of one of its variants set, named "ink:dark-blue".

    Raises:
        StyleError: it has no such variant.
    """
    return style_from_table(varied_table(style, variant), style.name, folder=style.folder)


def expand(style: Style) -> Style:
    """The style with every recipe replaced by the steps that it is made of."""
    layers: dict[str, Any] = {
        layer: tuple(part for step in getattr(style, layer) for part in _expand_step(step))
        for layer in LAYERS
    }
    return replace(style, **layers)


def _expand_step(step: Step) -> tuple[Step, ...]:
    """A recipe's steps: the first starts where the recipe did, the last saves what the recipe saved."""
    block = all_blocks().get(step.block)
    if block is None or block.kind != "recipe":
        return (step,)
    on: On | None = "luma" if "luma" in (step.on, block.on) else step.on
    made = [Step(part.name, values, on=on) for part, values in _run_recipe(block, step.values)]
    made = made or [Step("")]
    made[0] = replace(made[0], source=step.source)
    made[-1] = replace(made[-1], save=step.save)
    return tuple(part for each in made for part in _expand_step(each))


def _run_recipe(recipe: Block, values: dict[str, Any]) -> list[tuple[Block, dict[str, Any]]]:
    defaults = {name: parameter.default for name, parameter in recipe.parameters.items()}
    steps: list[tuple[Block, dict[str, Any]]] = recipe.function(**defaults | values)
    return steps


def _assign(table: dict[str, Any], text: str) -> str:
    """Set one value in the table of a style; returns what is wrong, or nothing."""
    path, equals, value = text.partition("=")
    if not equals:
        return f"{text!r} is not written as step.parameter=value"
    try:
        place = find_place(table, path)
    except ValueError as error:
        return str(error)
    place.table[place.parameter.name] = _value(place.parameter.control, value)
    return ""


def _value(control: Control, text: str) -> object:
    """What is written after "=": a TOML value, or a bare word where a text is wanted."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    value = parsed.get("value") if len(parsed) == 1 else None
    wants_text = isinstance(control, Choice | Color | SavedRef | Asset)
    if value is None or (wants_text and not isinstance(value, str)):
        return text.strip()
    return value
