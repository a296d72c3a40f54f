"""How the numbers of a plan follow the controls of a style, as tables that a page interpolates.

So a page without Python needs none of our formulas: each control is moved here, and what changes is recorded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.gpu.compile.es import COMPONENTS
from vidstyle.style import Style, set_values
from vidstyle.style.panel import panel

SLIDER_POSITIONS = 5
"""Positions of a slider that are tried where the numbers do not follow it linearly."""
INTEGER_TYPES = ("bool", "int", "ivec2")
MakePlan = Callable[[Style], dict[str, Any]]
ValuesAt = Callable[[object], list[float] | None]
"""The values of the plan with another value of a control; None if its passes are others."""


def main_controls(style: Style) -> list[dict[str, Any]]:
    """The controls that the style recommends, then its colours, as `panel` describes them."""
    entries = [entry for entry in panel(style, style)["entries"] if entry["main"]]
    recommended = [entry for entry in entries if entry["step"]]
    colors = ("ink", "paper") if style.lines else ("paper",)
    return recommended + [entry for entry in entries if entry["path"] in colors]


def with_tints(style: Style) -> Style:
    """The style with grays one code off in blue, so that its plan has room for every colour."""
    return replace(style, ink=_tint(style.ink), paper=_tint(style.paper))


def _tint(text: str) -> str:
    """A gray one code off; any other colour as it is.

    >>> _tint("#ffffff"), _tint("#14101a")
    ('#fffffe', '#14101a')
    """
    is_gray = text[1:3] == text[3:5] == text[5:]
    return f"{text[:5]}{int(text[5:], 16) ^ 1:02x}" if is_gray else text


def tables_of(
    style: Style, base: dict[str, Any], control: dict[str, Any], make: MakePlan
) -> list[dict[str, Any]]:
    """How the values of a plan follow a control: a table, or three for a colour; none if the passes do.

    A table holds positions `at`, and under `set` for each number that changes its index in `values`, what it
    is at each position, and whether it is the nearest of them that counts instead of what lies between.

    Args:
        base: the plan of the style itself.
        control: as `panel` describes it.
        make: a plan of the same size.
    """

    @cache
    def values_at(value: object) -> list[float] | None:
        try:
            plan = make(set_values(style, {control["path"]: value}))
        except VidstyleError:
            return None
        return plan["values"] if is_same(plan, base) else None

    if control["kind"] == "color":
        codes = bytes.fromhex(control["value"][1:])
        return _complete([_of_primary(codes, part, base, values_at) for part in range(3)])
    return _complete([_of_control(control, base, values_at)])


def _complete(tables: list[dict[str, Any] | None]) -> list[dict[str, Any]]:
    found = [table for table in tables if table is not None]
    return found if len(found) == len(tables) else []


def _of_primary(codes: bytes, part: int, base: dict[str, Any], values_at: ValuesAt) -> dict[str, Any] | None:
    """The table of one primary of a colour, on which all numbers depend linearly."""
    far = 254 if codes[part] < 128 else 1
    found = values_at("#" + bytes([*codes[:part], far, *codes[part + 1 :]]).hex())
    return None if found is None else _described([codes[part], far], [base["values"], found], base)


def _of_control(control: dict[str, Any], base: dict[str, Any], values_at: ValuesAt) -> dict[str, Any] | None:
    if control["kind"] != "slider":
        return _of_positions(_options(control), control["value"], base, values_at)
    low, high, now = control["low"], control["high"], control["value"]
    if now in (low, high):
        now = (low + high) // 2 if control["whole"] else (low + high) / 2
    at = [low, now, high]
    found = _found_of([number for number in at if number != control["value"]], values_at)
    found[control["value"]] = base["values"]
    if all(number in found for number in at) and _is_linear(at, [found[number] for number in at]):
        return _described([low, high], [found[low], found[high]], base)
    whole = round if control["whole"] else float
    evenly = {whole(float(number)) for number in np.linspace(low, high, SLIDER_POSITIONS)}
    return _of_positions(sorted(evenly | {control["value"]}), control["value"], base, values_at)


def _options(control: dict[str, Any]) -> list[Any]:
    return [False, True] if control["kind"] == "switch" else control["options"]


def _of_positions(
    values: Sequence[Any], now: object, base: dict[str, Any], values_at: ValuesAt
) -> dict[str, Any] | None:
    """The table of those values about the present one at which the passes stay as they are."""
    place = values.index(now)
    sides = (values[:place][::-1], values[place + 1 :])
    below, above = (_found_of(side, values_at) for side in sides)
    found = dict([*list(below.items())[::-1], (now, base["values"]), *above.items()])
    if len(found) == 1:
        return None
    at = (
        list(found)
        if isinstance(now, int | float) and not isinstance(now, bool)
        else map(values.index, found)
    )
    return _described(list(at), list(found.values()), base)


def _found_of(values: Sequence[Any], values_at: ValuesAt) -> dict[Any, list[float]]:
    """What is found for these values, up to the first at which the passes are others."""
    found: dict[Any, list[float]] = {}
    for value in values:
        if (numbers := values_at(value)) is None:
            break
        found[value] = numbers
    return found


def _is_linear(at: Sequence[float], tried: Sequence[Any]) -> bool:
    low, middle, high = (np.array(values) for values in tried)
    expected = low + (high - low) * (at[1] - at[0]) / (at[2] - at[0])
    return bool(np.allclose(middle, expected, rtol=1e-5, atol=1e-7))


def _described(at: Sequence[float], found: Sequence[Any], base: dict[str, Any]) -> dict[str, Any]:
    columns = np.array(found)
    integers = set(_integers(base))
    changed = [int(index) for index in np.flatnonzero((columns != columns[0]).any(axis=0))]
    return {
        "at": list(at),
        "set": [
            {
                "index": index,
                "numbers": columns[:, index].tolist(),
                "nearest": index in integers and len(at) > 2,
            }
            for index in changed
        ],
    }


def _integers(base: dict[str, Any]) -> Iterator[int]:
    """The indices in `values` of numbers that are integers."""
    index = len(base["pages"]) - 1
    for each in base["passes"]:
        for _, kind, count in each["uniforms"]:
            length = COMPONENTS[kind] * max(count, 1)
            yield from range(index, index + length) if kind in INTEGER_TYPES else ()
            index += length


def holds(tables: list[dict[str, Any]], control: dict[str, Any], plan: dict[str, Any]) -> bool:
    """Whether tables of one plan serve another that is alike.

    They do if they give what it has at the present value of their control, and change no size at which passes
    run: how far that may go depends on the size of the picture.
    """
    value = control["value"]
    if control["kind"] == "color":
        positions: list[Any] = list(bytes.fromhex(value[1:]))
    else:
        positions = [value] if control["kind"] == "slider" else [_options(control).index(value)]
    return all(
        change["index"] >= len(plan["pages"]) - 1
        and np.isclose(
            _interpolated(table["at"], change["numbers"], position), plan["values"][change["index"]]
        )
        for table, position in zip(tables, positions[: len(tables)], strict=True)
        for change in table["set"]
    )


def _interpolated(at: list[float], numbers: list[float], position: float) -> float:
    order = np.argsort(at)
    return float(np.interp(position, np.array(at)[order], np.array(numbers)[order]))


def is_alike(plan: dict[str, Any], base: dict[str, Any]) -> bool:
    """Whether two plans differ in values and in the contents of textures alone."""
    passes = [re.sub(r"'texture': '\w+'", "", repr(each["passes"])) for each in (plan, base)]
    keys = ("pages", "images", "measures", "shaders")
    return passes[0] == passes[1] and all(plan[key] == base[key] for key in keys)


def is_same(plan: dict[str, Any], base: dict[str, Any]) -> bool:
    """Whether two plans differ in values alone."""
    return all(plan[key] == base[key] for key in base if key not in ("values", "size"))
