"""The paths by which the values of a style are named: "ink", "posterize.levels", "lines.blend#2.opacity"."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any, NamedTuple

from vidstyle.block import Parameter
from vidstyle.blocks import all_blocks
from vidstyle.errors import join_names, suggest
from vidstyle.style.model import FIELDS, LAYERS
from vidstyle.style.values import to_text

_STEP_PATTERN = re.compile(rf"(?:({'|'.join(LAYERS)})\.)?(\w+)(?:#([0-9]{{1,3}}))?")


class StyleValue(NamedTuple):
    """A value of a style: the table of the style or step that holds it, and its declaration."""

    table: dict[str, Any]
    parameter: Parameter

    def get(self) -> Any:
        return self.table.get(self.parameter.name, self.parameter.default)

    def set(self, value: object) -> None:
        self.table[self.parameter.name] = value


class _StepEntry(NamedTuple):
    """A step with a block, as the table of a style holds it."""

    layer: str
    block: str
    table: dict[str, Any]


def find_value(table: dict[str, Any], path: str) -> StyleValue:
    """Return the value in the table of a style that a path names.

    Args:
        table: as returned by `table_from_style`.
        path: a field, or "posterize.levels"; where a block occurs more than once, "lines.posterize.levels"
            or "posterize#2.levels".

    Raises:
        ValueError: there is no such value, or the path is ambiguous.
    """
    step, dot, name = path.strip().rpartition(".")
    if not dot:
        if name not in FIELDS:
            hint = suggest(name, FIELDS)
            raise ValueError(f"{to_text(name)} is not a field of a style; {hint}; a step has step.parameter")
        return StyleValue(table, FIELDS[name])
    found = _find_step(table, step)
    parameters = all_blocks()[found.block].parameters
    if name not in parameters:
        raise ValueError(f"{step} has no parameter {to_text(name)}; {suggest(name, parameters)}")
    return StyleValue(found.table, parameters[name])


def steps_by_path(table: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of all steps with a block by their shortest paths, in the order in which they run.

    >>> list(steps_by_path({"base": [{"block": "sobel"}], "lines": [{"block": "sobel"}, {"block": "hue"}]}))
    ['base.sobel', 'lines.sobel', 'hue']
    """
    entries = _entries(table)
    return dict(zip(_paths(entries), (entry.table for entry in entries), strict=True))


def _entries(table: dict[str, Any]) -> list[_StepEntry]:
    steps = ((layer, step) for layer in LAYERS for step in table.get(layer, []))
    return [_StepEntry(layer, step["block"], step) for layer, step in steps if "block" in step]


def _find_step(table: dict[str, Any], path: str) -> _StepEntry:
    entries = _entries(table)
    parsed = _STEP_PATTERN.fullmatch(path)
    layer, block, number = parsed.groups() if parsed else ("", path, None)
    found = [entry for entry in entries if entry.block == block and layer in (None, entry.layer)]
    if number is not None:
        found = found[int(number) - 1 : int(number)] if int(number) else []
    if not found:
        raise ValueError(f"there is no step {to_text(path)}; {suggest(path, _paths(entries))}")
    if len(found) > 1:
        raise ValueError(f"{to_text(path)} may be {join_names(_paths(found), ' or ')}")
    return found[0]


def _paths(entries: list[_StepEntry]) -> list[str]:
    of_block = Counter(entry.block for entry in entries)
    of_layer = Counter(entry[:2] for entry in entries)
    paths, before = [], Counter[tuple[object, ...]]()
    for entry in entries:
        step = entry[:2]
        before[step] += 1
        if of_block[entry.block] == 1:
            paths.append(entry.block)
        else:
            place = f"#{before[step]}" if of_layer[step] > 1 else ""
            paths.append(f"{entry.layer}.{entry.block}{place}")
    return paths
