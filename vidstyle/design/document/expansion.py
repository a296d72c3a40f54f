"""Expansion of recipes into steps that a style file can hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError, UsageError
from vidstyle.style import Style, expand, style_from_table
from vidstyle.style.model import Step

if TYPE_CHECKING:
    from vidstyle.design.document.content import Content, PlacedStep

COMPARED_SIZE = (64, 48)
"""Picture size for which plans are compared, width and height."""


def expand_recipe(content: Content, step: PlacedStep) -> list[dict[str, Any]]:
    """Return the tables of the steps of a recipe.

    The steps of a luma recipe may process colour when used separately: to_gray is then added before them, and
    to_color after them if needed. Plans are compared to ensure the same result.

    Raises:
        UsageError: the step is not a recipe, or no expansion produces the same picture.
    """
    name = str(step.table.get("block", ""))
    block = all_blocks().get(name)
    if block is None or block.kind != "recipe":
        raise UsageError(name or "the step", "is not a recipe", "choose a step whose block is a recipe")
    table = content.table()
    try:
        before = _plan(style_from_table(table, "style"))
        layer, place, _ = content.place_of(step.number)
        for parts in _candidates(step.table):
            steps = table[layer]
            changed = {**table, layer: [*steps[:place], *parts, *steps[place + 1 :]]}
            for key in ("knobs", "labels", "variants"):
                changed.pop(key, None)
            if _plan(style_from_table(changed, "style")) == before:
                return parts
    except StyleError as error:
        raise UsageError(name, f"cannot be expanded: {error.mistakes[0]}") from error
    raise UsageError(name, "cannot be expanded here", "its separate steps would produce another picture")


def _candidates(table: Mapping[str, Any]) -> Iterator[list[dict[str, Any]]]:
    others = {key: table[key] for key in ("from", "save", "mute") if key in table}
    values = {key: value for key, value in table.items() if key not in (*others, "block")}
    parts = [_table(each) for each in expand(Style("", lines=(Step(table["block"], values),))).lines]
    gray, color = {"block": "to_gray"}, {"block": "to_color"}
    for steps in (parts, [gray, *parts], [gray, *parts, color]):
        if "mute" in others:
            steps = [{**each, "mute": True} for each in steps]
        first, last = dict(steps[0]), dict(steps[-1])
        first |= {key: others[key] for key in ("from",) if key in others}
        last |= {key: others[key] for key in ("save",) if key in others}
        yield [{**first, **last}] if len(steps) == 1 else [first, *steps[1:-1], last]


def _table(step: Step) -> dict[str, Any]:
    parameters = all_blocks()[step.block].parameters
    return {"block": step.block} | {
        name: value for name, value in step.values.items() if value != parameters[name].default
    }


def _plan(style: Style) -> dict[str, Any]:
    from vidstyle.gpu.compile.es import es_plan

    plan = es_plan(style, *COMPARED_SIZE)
    measures = [{**each, "step": ""} for each in plan["measures"]]
    return {**plan, "measures": measures}
