"""Writes a style in the form that the name of a file asks for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vidstyle.errors import UsageError
from vidstyle.media.write.atomic import atomic_file
from vidstyle.style import Style, style_from_table, style_text, table_from_style


def export_style(style: Style, target: Path, like: Path | None = None, overwrite: bool = False) -> int:
    """Write a style to a file: a page (.html) or a style file (.toml).

    Args:
        like: the style's own file, whose comments a style file keeps.
        overwrite: whether the target may exist.

    Returns:
        Its size in bytes.

    Raises:
        UsageError: the target has another ending, exists, or is the style's own file.
        StyleError: the style cannot be used.
        OutputError: the target cannot be written.
    """
    ending = target.suffix.lower()
    if ending not in (".html", ".toml"):
        raise UsageError(target, "is no kind of export", "end its name in .html or .toml")
    with atomic_file(target, like, overwrite) as write:
        content = _text(style, target, like).encode("utf-8")
        write(content)
    return len(content)


def _text(style: Style, target: Path, like: Path | None) -> str:
    if target.suffix.lower() == ".toml":
        named = replace(style, name=target.stem)
        style_from_table(table_from_style(named), named.name, folder=target.absolute().parent)
        return style_text(named, like)
    from vidstyle.export.page import page_of

    return page_of(style)
