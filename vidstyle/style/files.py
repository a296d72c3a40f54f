"""Reads style files from untrusted sources, and writes them preserving their comments."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import tomlkit

from vidstyle.errors import OutputError, StyleError
from vidstyle.style.check import style_from_table
from vidstyle.style.edit import edited_text
from vidstyle.style.model import Style, table_from_style

MAX_FILE = 64 * 1024
"""The largest style file, in bytes."""

MAX_DOTS = 1000
"""The most dots in a line: tomllib takes quadratic time for dotted keys."""


def read_style_file(path: Path) -> Style:
    """The style in a file.

    Raises:
        StyleError: the file cannot be read, or the style in it has mistakes.
    """
    table = _parse(path, _read_text(path))
    return style_from_table(table, path, path.stem, path.absolute().parent)


def save_style(style: Style, path: str | Path) -> None:
    """Write a style to a file. An existing style file is edited: its comments and order are preserved.

    Raises:
        StyleError: the style has mistakes, or the existing file is not a style.
        OutputError: the file cannot be written.
    """
    path = Path(path)
    table = table_from_style(style)
    style_from_table(table, style.name, folder=path.absolute().parent)
    text = _edit_file(path, table) if path.exists() else tomlkit.dumps(table)
    partial = path.resolve().with_name(f"{path.name}.partial")
    try:
        partial.write_text(text, encoding="utf-8", newline="")
        os.replace(partial, path.resolve())
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(path, f"cannot be written: {error.strerror}") from None


def _edit_file(path: Path, table: dict[str, Any]) -> str:
    text = _read_text(path)
    if repr(_parse(path, text).get("format")) != repr(table["format"]):
        raise StyleError(path, ["is there, and is not a style; choose another name"])
    return edited_text(text, table, path)


def _read_text(path: Path) -> str:
    content = _read_bytes(path)
    if len(content) > MAX_FILE:
        raise StyleError(path, [f"is larger than {MAX_FILE // 1024} KiB, so it is no style"])
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise StyleError(path, [f"line {line} is not UTF-8 text"]) from None


def _read_bytes(path: Path) -> bytes:
    """The file's content, at most one byte more than allowed; pipes and devices are rejected."""
    try:
        if path.is_file():
            with path.open("rb") as file:
                return file.read(MAX_FILE + 1)
        path.stat()
    except OSError as error:
        raise StyleError(path, [f"cannot be read: {error.strerror}"]) from None
    except ValueError:
        raise StyleError(path, ["cannot be read: no file has such a name"]) from None
    raise StyleError(path, ["is not a file"])


def _parse(path: Path, text: str) -> dict[str, Any]:
    for number, line in enumerate(text.split("\n"), 1):
        if line.count(".") > MAX_DOTS:
            raise StyleError(path, [f"line {number} is nested too deeply for a style"])
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise StyleError(path, ["is nested too deeply for a style"]) from None
    except ValueError as error:
        raise StyleError(path, [f"is not TOML: {error}"]) from None
