"""Tables that map the controls of a style to the numbers of a plan, for interpolation in a page.

The page then needs no formulas: each control is moved here, and its effect on the plan is recorded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.gpu.compile.es import COMPONENT_COUNTS, EsPlan
from vidstyle.style import Style, set_values
from vidstyle.style.panel import panel

SLIDER_POSITIONS = 5
"""Number of slider positions recorded for a nonlinear effect."""
INTEGER_TYPES = ("bool", "int", "ivec2")
MakePlan = Callable[[Style], EsPlan]
ValuesAt = Callable[[object], list[float] | None]
"""Returns the values of the plan for a value of a control; None if the passes differ."""


def main_controls(style: Style) -> list[dict[str, Any]]:
    """Return the recommended controls of the style, then its colours, as described by `panel`."""
    entries = [entry for entry in panel(style, style)["entries"] if entry["main"]]
    recommended = [entry for entry in entries if entry["step"]]
    colors = ("ink", "paper") if style.lines else ("paper",)
    return recommended + [entry for entry in entries if entry["path"] in colors]


def with_tints(style: Style) -> Style:
    """Return the style with grays changed by one code in blue, so that its plan supports all colours."""
    return replace(style, ink=_tint(style.ink), paper=_tint(style.paper))


def _tint(text: str) -> str:
    """Change a gray by one code; return other colours unchanged.

    >>> _tint("#ffffff"), _tint("#14101a")
    ('#fffffe', '#14101a')
    """
    is_gray = text[1:3] == text[3:5] == text[5:]
    return f"{text[:5]}{int(text[5:], 16) ^ 1:02x}" if is_gray else text


def tables_of(style: Style, base: EsPlan, control: dict[str, Any], make: MakePlan) -> list[dict[str, Any]]:
    """Return the effect of a control on plan values: one table, or three for a colour; none if passes change.

    A table holds the positions `at`. For each number that changes, `set` holds its index in `values`, its
    value at each position, and whether to use the nearest position instead of interpolation.

    Args:
        base: the plan of the style itself.
        control: the control, as described by `panel`.
        make: makes a plan of the same size.
    """

    @cache
    def values_at(value: object) -> list[float] | None:
        try:
            plan = make(set_values(style, {control["path"]: value}))
        except VidstyleError:
            return None
        return plan.values if plan.key == base.key else None

    if control["kind"] == "color":
        codes = bytes.fromhex(control["value"][1:])
        return _complete([_of_primary(codes, part, base, values_at) for part in range(3)])
    return _complete([_of_control(control, base, values_at)])


def _complete(tables: list[dict[str, Any] | None]) -> list[dict[str, Any]]:
    found = [table for table in tables if table is not None]
    return found if len(found) == len(tables) else []


def _of_primary(codes: bytes, part: int, base: EsPlan, values_at: ValuesAt) -> dict[str, Any] | None:
    """Return the table of one primary of a colour, on which all numbers depend linearly."""
    far = 254 if codes[part] < 128 else 1
    found = values_at("#" + bytes([*codes[:part], far, *codes[part + 1 :]]).hex())
    return None if found is None else _make_table([codes[part], far], [base.values, found], base)


def _of_control(control: dict[str, Any], base: EsPlan, values_at: ValuesAt) -> dict[str, Any] | None:
    if control["kind"] != "slider":
        return _of_positions(_options(control), control["value"], base, values_at)
    low, high, now = control["low"], control["high"], control["value"]
    if now in (low, high):
        now = (low + high) // 2 if control["whole"] else (low + high) / 2
    at = [low, now, high]
    found = _probe([number for number in at if number != control["value"]], values_at)
    found[control["value"]] = base.values
    if all(number in found for number in at) and _is_linear(at, [found[number] for number in at]):
        return _make_table([low, high], [found[low], found[high]], base)
    whole = round if control["whole"] else float
    evenly = {whole(float(number)) for number in np.linspace(low, high, SLIDER_POSITIONS)}
    return _of_positions(sorted(evenly | {control["value"]}), control["value"], base, values_at)


def _options(control: dict[str, Any]) -> list[Any]:
    return [False, True] if control["kind"] == "switch" else control["options"]


def _of_positions(
    values: Sequence[Any], now: object, base: EsPlan, values_at: ValuesAt
) -> dict[str, Any] | None:
    """Return the table of the values around the current one that leave the passes unchanged."""
    place = values.index(now)
    sides = (values[:place][::-1], values[place + 1 :])
    below, above = (_probe(side, values_at) for side in sides)
    found = dict([*list(below.items())[::-1], (now, base.values), *above.items()])
    if len(found) == 1:
        return None
    at = (
        list(found)
        if isinstance(now, int | float) and not isinstance(now, bool)
        else map(values.index, found)
    )
    return _make_table(list(at), list(found.values()), base)


def _probe(values: Sequence[Any], values_at: ValuesAt) -> dict[Any, list[float]]:
    """Return the plan values for these values, up to the first that changes the passes."""
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


def _make_table(at: Sequence[float], found: Sequence[Any], base: EsPlan) -> dict[str, Any]:
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


def _integers(base: EsPlan) -> Iterator[int]:
    """Yield the indices of integers in `values`."""
    index = len(base.data["pages"]) - 1
    for each in base.data["passes"]:
        for _, kind, count in each["uniforms"]:
            length = COMPONENT_COUNTS[kind] * max(count, 1)
            yield from range(index, index + length) if kind in INTEGER_TYPES else ()
            index += length


def tables_fit(tables: list[dict[str, Any]], control: dict[str, Any], plan: dict[str, Any]) -> bool:
    """Whether the tables of one plan fit a similar plan.

    They fit if they match its values at the current value of the control, and change no pass size, whose
    limits depend on the size of the picture.
    """
    value = control["value"]
    if control["kind"] == "color":
        positions: list[Any] = list(bytes.fromhex(value[1:]))
    else:
        positions = [value] if control["kind"] == "slider" else [_options(control).index(value)]
    return all(
        change["index"] >= len(plan["pages"]) - 1
        and np.isclose(
            _interpolate(table["at"], change["numbers"], position), plan["values"][change["index"]]
        )
        for table, position in zip(tables, positions[: len(tables)], strict=True)
        for change in table["set"]
    )


def _interpolate(at: list[float], numbers: list[float], position: float) -> float:
    order = np.argsort(at)
    return float(np.interp(position, np.array(at)[order], np.array(numbers)[order]))


def is_alike(plan: dict[str, Any], base: dict[str, Any]) -> bool:
    """Whether two plans differ only in values and texture contents."""
    passes = [re.sub(r"'texture': '\w+'", "", repr(each["passes"])) for each in (plan, base)]
    keys = ("pages", "images", "measures", "shaders")
    return passes[0] == passes[1] and all(plan[key] == base[key] for key in keys)
