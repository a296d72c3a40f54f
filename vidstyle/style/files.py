"""Reads style files from untrusted sources, and writes them preserving their comments."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vidstyle.core.file_checks import parse_toml, read_toml_text
from vidstyle.errors import StyleError, text_of_name
from vidstyle.style.check import style_from_table
from vidstyle.style.locate import correct_word, with_lines
from vidstyle.style.model import Style, table_from_style
from vidstyle.style.values import MAX_MISTAKES

MAX_FILE = 64 * 1024
"""The largest style file, in bytes."""


def read_style_file(path: Path) -> Style:
    """Return the style in a file.

    Raises:
        StyleError: the file cannot be read, or the style in it has mistakes.
    """
    return style_from_text(read_style_text(path), path, path.absolute().parent)


def style_from_text(text: str, path: Path, folder: Path | None) -> Style:
    """Return the style in the text of a file.

    Args:
        path: the file, whose name is the style's if it has none.
        folder: the folder to which its paths are relative; None allows no paths.

    Raises:
        StyleError: the style has mistakes.
    """
    table, words = _parse(path, text)
    try:
        style = style_from_table(table, path, text_of_name(path.stem), folder)
    except StyleError as error:
        raise StyleError(path, words + with_lines(error.mistakes, text)) from None
    if words:
        raise StyleError(path, words)
    return style


def style_text(style: Style, like: Path | None = None) -> str:
    """Return the style as a style file; with the comments and the order of another one, where that is given.

    Raises:
        StyleError: the other file cannot be read.
    """
    from vidstyle.style.edit import edit_text, new_text  # which a render needs not

    table = _written_shortly(table_from_style(style))
    return new_text(table) if like is None else edit_text(read_style_text(like), table, like)


def save_style(style: Style, path: str | Path, like: str | None = None) -> None:
    """Write a style to a file. An existing style file is edited: its comments and order are preserved.

    Args:
        like: the text of another style file, whose comments and order are taken instead.

    Raises:
        StyleError: the style has mistakes, or the existing file is not a style.
        OutputError: the file cannot be written.
    """
    from vidstyle.media.write.atomic import atomic_file
    from vidstyle.style.edit import edit_text, new_text

    path = Path(path)
    table = _written_shortly(table_from_style(style))
    style_from_table(table, style.name, folder=path.absolute().parent)
    if like is not None:
        text = edit_text(like, table, path)
    else:
        text = edit_text(_own_text(path, table), table, path) if path.exists() else new_text(table)
    with atomic_file(path, overwrite=True) as write:
        write(text.encode())


def _written_shortly(value: Any) -> Any:
    """Return the value, or table of values, with whole numbers as people write them: 55 for 55.0."""
    if isinstance(value, dict):
        return {key: _written_shortly(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_written_shortly(each) for each in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _own_text(path: Path, table: dict[str, Any]) -> str:
    """Return the text of a file that is to be edited to hold a table."""
    text = read_style_text(path)
    present, words = _parse(path, text)
    if words:
        raise StyleError(path, words)
    if repr(present.get("format")) != repr(table["format"]):
        raise StyleError(path, ["exists and is not a style; choose another name"])
    return text


def read_style_text(path: Path) -> str:
    """Return the text of a style file.

    Raises:
        StyleError: it cannot be read, is too large, or is no UTF-8.
    """
    try:
        return read_toml_text(path, MAX_FILE)
    except ValueError as error:
        raise StyleError(path, [str(error)]) from None


def _parse(path: Path, text: str) -> tuple[dict[str, Any], list[str]]:
    """Parse a style file; unquoted strings are accepted and reported."""
    if text.lstrip().startswith("{"):
        raise StyleError(path, ['is JSON; a style is TOML, such as block = "sobel" below [[lines]]'])
    words: list[str] = []
    while True:
        try:
            return parse_toml(text), words
        except ValueError as error:
            mended = correct_word(text, str(error)) if len(words) < MAX_MISTAKES else None
            if mended is None:
                raise StyleError(path, [*words, str(error)]) from None
            text = mended[0]
            words.append(mended[1])
