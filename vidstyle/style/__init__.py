"""Styles: small readable files that say which blocks run, in which order, with which values."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from vidstyle.assets import asset_folder, configuration_folder
from vidstyle.errors import StyleError, log, suggest
from vidstyle.style.change import apply_variant, expand, override, set_values
from vidstyle.style.check import style_from_table
from vidstyle.style.files import read_style_file, save_style, style_text
from vidstyle.style.model import LAYERS, SOURCE, Step, Style, table_from_style
from vidstyle.style.schema import describe, style_schema

__all__ = [
    "LAYERS",
    "FIRST_STYLES",
    "PLAIN",
    "SOURCE",
    "Step",
    "Style",
    "describe",
    "expand",
    "load_style",
    "override",
    "popular_first",
    "save_style",
    "set_values",
    "style_from_table",
    "style_file",
    "style_names",
    "style_schema",
    "style_text",
    "table_from_style",
    "user_styles",
]

PLAIN = "plain"
"""The name of the empty style."""

FIRST_STYLES = (
    "ink", "poster", "comic", "cartoon", "watercolor",
    "sketch", "oil", "impressionist", "neon", "crayon",
)  # fmt: skip
"""The styles that pages list and render first, in rows: those that most people look for, and in each row
first those that need the least compiling at a first start."""


def load_style(style: str | Path | Mapping[str, object] | Style) -> Style:
    """Load a style by its name, shipped or the user's, from a file, or from a table like a file's.

    A text that ends in .toml or has a folder in it is a path, as is one that names no style but a file.
    "ink:dark-blue" and "mine.toml:dark-blue" are variants of the styles before the colon. A table may hold
    no paths, having no folder. The name of a retired style loads the style that replaces it, with a notice.

    Raises:
        StyleError: there is no such style or variant, or it has mistakes: all of them are named.

    >>> load_style("plain").is_plain
    True
    >>> load_style({"format": 1, "background": [{"block": "posterize", "levels": 99}]})
    Traceback (most recent call last):
    vidstyle.errors.StyleError: style: background step 1 (posterize): levels: 99 is outside 2 to 32
    """
    if isinstance(style, Style):
        return style
    if isinstance(style, Mapping):
        return style_from_table(style, "style")
    base, variant = (style, None) if isinstance(style, Path) else _split(style)
    found = read_style_file(base) if isinstance(base, Path) else _load_named(base)
    return found if variant is None else apply_variant(found, variant)


def style_names() -> list[str]:
    """Return the names of all styles: `plain`, the shipped ones, and those in the user's folder."""
    return sorted({PLAIN, *_files()})


def popular_first() -> list[str]:
    """Return the names of all styles, `FIRST_STYLES` before the others."""
    return list(dict.fromkeys((*FIRST_STYLES, *style_names())))


def style_file(style: str) -> Path | None:
    """Return the file that `load_style` reads for a text; None if it reads none."""
    base = _split(style)[0]
    return base if isinstance(base, Path) else _files().get(base) or _replacements().get(base)


def user_styles() -> Path:
    """Return the folder of the user's own styles, which need not exist."""
    return configuration_folder() / "styles"


def _files() -> dict[str, Path]:
    """Return the file of each name. A shipped style keeps its name."""
    folders = user_styles(), asset_folder("styles")
    return {path.stem: path for folder in folders for path in folder.glob("*.toml")}


@cache
def _replacements() -> dict[str, Path]:
    """Return the file of the shipped style that replaces each retired one."""
    shipped = asset_folder("styles").glob("*.toml")
    return {name: path for path in shipped for name in read_style_file(path).replaces.split()}


def _load_named(name: str) -> Style:
    if name == PLAIN:
        return Style(name=PLAIN, note="The unchanged source.")
    if path := _files().get(name):
        return read_style_file(path)
    if os.path.isfile(name):
        return read_style_file(Path(name))
    if path := _replacements().get(name):
        log.warning("the style %s is retired; %s replaces it", name, path.stem, extra={"once": True})
        return read_style_file(path)
    raise StyleError(name, [f"there is no style '{name}'; {suggest(name, style_names())}"])


def _split(text: str) -> tuple[str | Path, str | None]:
    """Return the name or path of a style, and the variant behind the last colon, if there is one.

    The colon of a drive, as in "C:mine.toml", has a path behind it, and a file whose own name has
    a colon is that file.

    >>> _split("ink:dark-blue"), _split("C:mine.toml")[1], _split("C:mine.toml:blue")[1]
    (('ink', 'dark-blue'), None, 'blue')
    """
    base, colon, variant = text.rpartition(":")
    if not colon or _is_path(variant) or (_is_path(base) and os.path.isfile(text)):
        return (Path(text) if _is_path(text) or colon else text), None
    return (Path(base) if _is_path(base) else base), variant


def _is_path(text: str) -> bool:
    separators = os.sep + (os.altsep or "")
    return text.lower().endswith(".toml") or any(separator in text for separator in separators)
