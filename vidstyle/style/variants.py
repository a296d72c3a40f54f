"""Variants of a style: names for a few values set on it, as `--set` sets them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vidstyle.errors import StyleError
from vidstyle.style.model import Style, table_from_style
from vidstyle.style.paths import find_place
from vidstyle.style.values import MAX_MISTAKES, nearest, read_values, shown

MAX_VARIANTS = 32
VARIANT_PATTERN = "[a-z0-9-]{1,40}"
"""What a variant may be called."""


def read_variants(style: Style, given: object, mistakes: list[str]) -> dict[str, dict[str, Any]]:
    """The variants that a style file gives, each value checked by itself; those with mistakes are left out.

    Args:
        style: the style that they change.
        given: what the file holds under `variants`.
        mistakes: gets one line for each mistake.
    """
    if not isinstance(given, Mapping):
        mistakes.append(f"variants: {shown(given)} is not a table; write [variants.NAME] above each")
        return {}
    if len(given) > MAX_VARIANTS:
        mistakes.append(f"variants: a style has at most {MAX_VARIANTS} variants")
        return {}
    table = table_from_style(style)
    return {
        name: _read_variant(table, f"variants.{name}: ", values, mistakes)
        for name, values in given.items()
        if _may_be_called(name, mistakes)
    }


def varied_table(style: Style, variant: str) -> dict[str, Any]:
    """The table of the style with the values of one of its variants set, and without variants.

    Raises:
        StyleError: it has no such variant.
    """
    if variant not in style.variants:
        hint = nearest(variant, style.variants)
        raise StyleError(f"{style.name}:{variant}", [f"{style.name} has no variant {shown(variant)}; {hint}"])
    table = table_from_style(replace(style, variants={}))
    for path, value in style.variants[variant].items():
        place = find_place(table, path)
        place.table[place.parameter.name] = value
    return table | {"name": f"{style.name}:{variant}"}


def _may_be_called(name: str, mistakes: list[str]) -> bool:
    if re.fullmatch(VARIANT_PATTERN, name):
        return True
    right = re.sub("[^a-z0-9]+", "-", name.lower()).strip("-")[:40]
    hint = f"; did you mean {right}?" if right else ""
    mistakes.append(f"variants: {shown(name)} is not a name of 1 to 40 of a-z, 0-9 and -{hint}")
    return False


def _read_variant(table: dict[str, Any], where: str, given: object, mistakes: list[str]) -> dict[str, Any]:
    if not isinstance(given, Mapping):
        mistakes.append(f"{where}{shown(given)} is not a table of values")
        return {}
    values: dict[str, Any] = {}
    for path, value in given.items():
        if len(mistakes) > MAX_MISTAKES:  # a hint takes milliseconds: no thousands of them
            break
        if isinstance(value, Mapping):
            mistakes.append(f'{where}{shown(path)} is a table; write "{_nested_path(path, value)}" in quotes')
            continue
        try:
            parameter = find_place(table, path).parameter
        except ValueError as error:
            mistakes.append(f"{where}{error}")
        else:
            values |= read_values({path: parameter}, given, where, mistakes)
    return values


def _nested_path(path: str, value: object) -> str:
    """What was meant by a path without quotes, which TOML takes for tables in tables."""
    while isinstance(value, Mapping) and value and len(path) < 60:
        key, value = next(iter(value.items()))
        path += f".{key}"
    return path[:60]
