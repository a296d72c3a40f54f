"""Checks the content of a style file against the declarations of the blocks, and makes a Style of it.

Styles come from untrusted sources: every value is checked here before it is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from vidstyle.errors import StyleError
from vidstyle.style.model import FIELDS, LAYERS, Style
from vidstyle.style.steps import StepReader
from vidstyle.style.values import MAX_MISTAKES, read_values, suggest, to_text
from vidstyle.style.variants import read_variants, table_of_variant

FORMAT = 1
TEXTS = {"name": 100, "note": 1000}
"""The fields that hold text, and the maximum number of characters of each."""


def style_from_table(
    table: Mapping[str, object], subject: object, name: str = "", folder: Path | None = None
) -> Style:
    """The style in the table of a style file.

    Args:
        table: the content of the file.
        subject: names the style in errors.
        name: its name if the table has none.
        folder: the folder to which its paths are relative; None allows no paths.

    Raises:
        StyleError: names all mistakes.
    """
    mistakes: list[str] = []
    if _is_known_format(table, mistakes):
        style = _read_style(table, name, folder, mistakes)
        # The paths of variants are only meaningful in valid steps.
        if "variants" in table and not mistakes:
            style = _read_variants(style, table["variants"], mistakes)
    if mistakes:
        rest = len(mistakes) - MAX_MISTAKES
        mistakes[MAX_MISTAKES:] = [f"and {rest} more mistakes"] if rest > 0 else []
        raise StyleError(subject, mistakes)
    return style


def _is_known_format(table: Mapping[str, object], mistakes: list[str]) -> bool:
    version = table.get("format")
    if version is None:
        mistakes.append(f"format is missing; a style file says format = {FORMAT}")
        return True
    if isinstance(version, int) and not isinstance(version, bool) and version == FORMAT:
        return True
    mistakes.append(f"format {to_text(version)} is unknown; this vidstyle reads format {FORMAT}")
    return False


def _read_style(table: Mapping[str, object], name: str, folder: Path | None, mistakes: list[str]) -> Style:
    known = ("format", *TEXTS, *FIELDS, *LAYERS, "variants")
    for key in table:
        if key not in known:
            mistakes.append(f"{to_text(key)} is not a field of a style; {suggest(str(key), known)}")
    texts: dict[str, Any] = {"name": name}
    texts |= {key: _read_text(key, table[key], mistakes) for key in TEXTS if key in table}
    fields = _read_fields(table, mistakes)
    reader = StepReader(folder, mistakes)
    layers: dict[str, Any] = {layer: reader.read_layer(layer, table.get(layer, [])) for layer in LAYERS}
    return Style(folder=folder, **texts, **fields, **layers)


def _read_variants(style: Style, given: object, mistakes: list[str]) -> Style:
    """The style with its variants, each of which must be a valid style."""
    style = replace(style, variants=read_variants(style, given, mistakes))
    for variant in style.variants:
        found: list[str] = []
        _read_style(table_of_variant(style, variant), style.name, style.folder, found)
        mistakes += [f"variants.{variant}: {mistake}" for mistake in found]
    return style


def _read_text(key: str, value: object, mistakes: list[str]) -> str:
    """The text on one line, without control characters."""
    text = " ".join(value.split()) if isinstance(value, str) else "\n"
    if len(text) > TEXTS[key] or not text.isprintable():
        mistakes.append(f"{key}: {to_text(value)} is not a text of at most {TEXTS[key]} characters")
    return text


def _read_fields(table: Mapping[str, object], mistakes: list[str]) -> dict[str, Any]:
    given = {key: parameter for key, parameter in FIELDS.items() if key in table}
    return read_values(given, table, "", mistakes)
