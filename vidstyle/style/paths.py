"""The paths by which the values of a style are named: "ink", "posterize.levels", "lines.blend#2.opacity"."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from vidstyle.block import Parameter
from vidstyle.blocks import all_blocks
from vidstyle.style.model import FIELDS, LAYERS
from vidstyle.style.values import listed, nearest, shown

_STEP = re.compile(rf"(?:({'|'.join(LAYERS)})\.)?(\w+)(?:#([0-9]{{1,3}}))?")


class ValuePath(NamedTuple):
    """Where a value is kept: the table of the style or of one of its steps, and what it is there."""

    table: dict[str, Any]
    parameter: Parameter


class _Target(NamedTuple):
    """A step that a value can be set on."""

    layer: str
    block: str
    table: dict[str, Any]


def find_place(table: dict[str, Any], path: str) -> ValuePath:
    """The place in the table of a style that a path means.

    Args:
        table: a style as `table_from_style` gives it.
        path: a field, or "posterize.levels"; where a block occurs more than once, "lines.posterize.levels"
            or "posterize#2.levels".

    Raises:
        ValueError: there is no such place, or there are several.
    """
    step, dot, name = path.strip().rpartition(".")
    if not dot:
        if name not in FIELDS:
            raise ValueError(
                f"{shown(name)} is not a field of a style; {nearest(name, FIELDS)}; a step has step.parameter"
            )
        return ValuePath(table, Parameter(name, FIELDS[name], None, whole=False))
    target = _find_step(table, step)
    parameters = all_blocks()[target.block].parameters
    if name not in parameters:
        raise ValueError(f"{step}: {shown(name)} is not a parameter; {nearest(name, parameters)}")
    return ValuePath(target.table, parameters[name])


def step_paths(table: dict[str, Any]) -> list[str]:
    """The shortest paths of all steps that have a block, in the order in which they run.

    >>> step_paths({"base": [{"block": "gaussian"}], "lines": [{"block": "gaussian"}, {"block": "sobel"}]})
    ['base.gaussian', 'lines.gaussian', 'sobel']
    """
    return _paths(_targets(table))


def _targets(table: dict[str, Any]) -> list[_Target]:
    return [
        _Target(layer, step["block"], step)
        for layer in LAYERS
        for step in table.get(layer, [])
        if "block" in step
    ]


def _find_step(table: dict[str, Any], path: str) -> _Target:
    targets = _targets(table)
    parsed = _STEP.fullmatch(path)
    layer, block, number = parsed.groups() if parsed else ("", path, None)
    found = [target for target in targets if target.block == block and layer in (None, target.layer)]
    if number is not None:
        found = found[int(number) - 1 : int(number)] if int(number) else []
    if not found:
        raise ValueError(f"there is no step {shown(path)}; {nearest(path, _paths(targets))}")
    if len(found) > 1:
        raise ValueError(f"{shown(path)} may be {listed(_paths(found), ' or ')}")
    return found[0]


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
