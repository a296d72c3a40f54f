"""Variants of a style: named sets of values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vidstyle.errors import StyleError, suggest
from vidstyle.style.model import Style, table_from_style
from vidstyle.style.paths import find_value
from vidstyle.style.values import MAX_MISTAKES, read_values, to_text

MAX_VARIANTS = 32
VARIANT_PATTERN = "[a-z0-9-]{1,40}"
"""Regular expression for the names of variants."""


def read_variants(style: Style, given: object, mistakes: list[str]) -> dict[str, dict[str, Any]]:
    """Return the variants in a style file, each value checked separately; invalid ones are skipped.

    Args:
        style: the style that they change.
        given: the content of the file under `variants`.
        mistakes: a line is appended for each mistake.
    """
    if not isinstance(given, Mapping):
        mistakes.append(f"variants: {to_text(given)} is not a table; write [variants.NAME] above each")
        return {}
    if len(given) > MAX_VARIANTS:
        mistakes.append(f"variants: a style has at most {MAX_VARIANTS} variants")
        return {}
    table = table_from_style(style)
    return {
        name: _read_variant(table, f"variants.{name}: ", values, mistakes)
        for name, values in given.items()
        if _is_valid_name(name, mistakes)
    }


def table_of_variant(style: Style, variant: str) -> dict[str, Any]:
    """Return the table of the style with the values of one of its variants, without its variants.

    Raises:
        StyleError: it has no such variant.
    """
    if variant not in style.variants:
        name = f"{style.name}:{variant}"
        reason = f"there is no variant '{name}'; {suggest(variant, style.variants)}"
        raise StyleError(name, [reason])
    table = table_from_style(replace(style, variants={}))
    for path, value in style.variants[variant].items():
        find_value(table, path).set(value)
    return table | {"name": f"{style.name}:{variant}"}


def _is_valid_name(name: str, mistakes: list[str]) -> bool:
    if re.fullmatch(VARIANT_PATTERN, name):
        return True
    right = re.sub("[^a-z0-9]+", "-", name.lower()).strip("-")[:40]
    hint = f"; did you mean {right!r}?" if right else ""
    mistakes.append(f"variants: {to_text(name)} is not a name of 1 to 40 of a-z, 0-9 and -{hint}")
    return False


def _read_variant(table: dict[str, Any], where: str, given: object, mistakes: list[str]) -> dict[str, Any]:
    if not isinstance(given, Mapping):
        mistakes.append(f"{where}{to_text(given)} is not a table of values")
        return {}
    values: dict[str, Any] = {}
    for path, value in given.items():
        if len(mistakes) > MAX_MISTAKES:  # a suggestion takes milliseconds
            break
        if isinstance(value, Mapping):
            mistakes.append(
                f'{where}{to_text(path)} is a table; write "{_nested_path(path, value)}" in quotes'
            )
            continue
        try:
            parameter = find_value(table, path).parameter
        except ValueError as error:
            mistakes.append(f"{where}{error}")
        else:
            values |= read_values({path: parameter}, given, where, mistakes)
    return values


def _nested_path(path: str, value: object) -> str:
    """Return the path that was written without quotes, which TOML reads as nested tables."""
    while isinstance(value, Mapping) and value and len(path) < 60:
        key, value = next(iter(value.items()))
        path += f".{key}"
    return path[:60]
