"""Checks what a style file holds against the declarations of the blocks, and makes a Style of it.

A style may come from a stranger: no value is trusted before it has been checked here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from vidstyle.block import Parameter
from vidstyle.errors import StyleError
from vidstyle.style.model import FIELDS, LAYERS, Style
from vidstyle.style.steps import StepReader
from vidstyle.style.values import MAX_MISTAKES, nearest, read_values, shown
from vidstyle.style.variants import read_variants, varied_table

FORMAT = 1
TEXTS = {"name": 100, "note": 1000}
"""The fields that are words for people, and how many characters each may have."""


def style_from_table(
    table: Mapping[str, object], thing: object, name: str = "", folder: Path | None = None
) -> Style:
    """The style that the table of a style file describes.

    Args:
        table: what the file holds.
        thing: what errors shall call it.
        name: its name if the table gives none.
        folder: where its paths start; None allows no paths.

    Raises:
        StyleError: with all the mistakes in it.
    """
    mistakes: list[str] = []
    if _format_is_known(table, mistakes):
        style = _read_style(table, name, folder, mistakes)
        # Their paths lead into steps, which must be right for that.
        if "variants" in table and not mistakes:
            style = _read_variants(style, table["variants"], mistakes)
    if mistakes:
        rest = len(mistakes) - MAX_MISTAKES
        mistakes[MAX_MISTAKES:] = [f"and {rest} more mistakes"] if rest > 0 else []
        raise StyleError(thing, mistakes)
    return style


def _format_is_known(table: Mapping[str, object], mistakes: list[str]) -> bool:
    version = table.get("format")
    if version is None:
        mistakes.append(f"format is missing; a style file says format = {FORMAT}")
        return True
    if isinstance(version, int) and not isinstance(version, bool) and version == FORMAT:
        return True
    mistakes.append(f"format {shown(version)} is unknown; this vidstyle reads format {FORMAT}")
    return False


def _read_style(table: Mapping[str, object], name: str, folder: Path | None, mistakes: list[str]) -> Style:
    known = ("format", *TEXTS, *FIELDS, *LAYERS, "variants")
    for key in table:
        if key not in known:
            mistakes.append(f"{shown(key)} is not a field of a style; {nearest(str(key), known)}")
    texts: dict[str, Any] = {"name": name}
    texts |= {key: _read_text(key, table[key], mistakes) for key in TEXTS if key in table}
    fields = _read_fields(table, mistakes)
    reader = StepReader(folder, mistakes)
    layers: dict[str, Any] = {layer: reader.read_layer(layer, table.get(layer, [])) for layer in LAYERS}
    return Style(folder=folder, **texts, **fields, **layers)


def _read_variants(style: Style, given: object, mistakes: list[str]) -> Style:
    """The style with its variants, each of which must be a style that is right."""
    style = replace(style, variants=read_variants(style, given, mistakes))
    for variant in style.variants:
        found: list[str] = []
        _read_style(varied_table(style, variant), style.name, style.folder, found)
        mistakes += [f"variants.{variant}: {mistake}" for mistake in found]
    return style


def _read_text(key: str, value: object, mistakes: list[str]) -> str:
    """The text on one line, so that nothing of it can play tricks on a terminal."""
    text = " ".join(value.split()) if isinstance(value, str) else "\n"
    if len(text) > TEXTS[key] or not text.isprintable():
        mistakes.append(f"{key}: {shown(value)} is not a text of at most {TEXTS[key]} characters")
    return text


def _read_fields(table: Mapping[str, object], mistakes: list[str]) -> dict[str, Any]:
    given = {
        key: Parameter(key, control, None, whole=False) for key, control in FIELDS.items() if key in table
    }
    return read_values(given, table, "", mistakes)
