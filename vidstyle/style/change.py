"""Styles made from other styles: with values set by hand, and with recipes written out."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

from vidstyle.block import Asset, Block, Choice, Color, Control, On, Saved
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError, UsageError
from vidstyle.style.check import style_from_table
from vidstyle.style.graph import FIELDS, LAYERS, Step, Style, table_from_style
from vidstyle.style.values import nearest

_STEP = re.compile(rf"(?:({'|'.join(LAYERS)})\.)?(\w+)(?:#([0-9]{{1,3}}))?")


class _Target(NamedTuple):
    """A step that a value can be set on."""

    layer: str
    block: str
    table: dict[str, Any]


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
    step, dot, name = path.strip().rpartition(".")
    if not equals:
        return f"{text!r} is not written as step.parameter=value"
    if not dot:
        if name not in FIELDS:
            return f"{name!r} is not a field of a style; {nearest(name, FIELDS)}; a step has step.parameter"
        table[name] = _value(FIELDS[name], value)
        return ""
    found = _find(table, step)
    if isinstance(found, str):
        return found
    parameters = all_blocks()[found.block].parameters
    if name not in parameters:
        return f"{step}: {name!r} is not a parameter; {nearest(name, parameters)}"
    found.table[name] = _value(parameters[name].control, value)
    return ""


def _find(table: dict[str, Any], path: str) -> _Target | str:
    """The one step that is meant, or what is wrong."""
    targets = [
        _Target(layer, step["block"], step)
        for layer in LAYERS
        for step in table.get(layer, [])
        if "block" in step
    ]
    parsed = _STEP.fullmatch(path)
    layer, block, number = parsed.groups() if parsed else ("", path, None)
    found = [target for target in targets if target.block == block and layer in (None, target.layer)]
    if not found:
        return f"there is no step {path!r}; {nearest(path, _paths(targets))}"
    if number is not None:
        found = found[int(number) - 1 : int(number)] if int(number) else []
        return found[0] if found else f"there is no step {path!r}; {nearest(path, _paths(targets))}"
    return found[0] if len(found) == 1 else f"{path!r} may be {' or '.join(_paths(found))}"


def _paths(targets: list[_Target]) -> list[str]:
    """The shortest ways to name each of the steps."""
    paths = []
    for number, target in enumerate(targets):
        alike = [other for other in targets if other.block == target.block]
        beside = [other for other in alike if other.layer == target.layer]
        order = 1 + sum(
            other.block == target.block and other.layer == target.layer for other in targets[:number]
        )
        if len(alike) == 1:
            paths.append(target.block)
        else:
            paths.append(f"{target.layer}.{target.block}" + (f"#{order}" if len(beside) > 1 else ""))
    return paths


def _value(control: Control, text: str) -> object:
    """What is written after "=": a TOML value, or a bare word where a text is wanted."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    value = parsed.get("value") if len(parsed) == 1 else None
    wants_text = isinstance(control, Choice | Color | Saved | Asset)
    if value is None or (wants_text and not isinstance(value, str)):
        return text.strip()
    return value
