"""Single values of a style file: checks, and their text in messages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vidstyle.block import Parameter

MAX_TEXT = 200
"""The longest text of a value, in characters."""
MAX_MISTAKES = 50
"""The most mistakes that one message names."""
MAX_INTEGER = 2**53
"""The largest integer; floats hold all integers up to it."""


def read_values(
    parameters: Mapping[str, Parameter], table: Mapping[str, object], where: str, mistakes: list[str]
) -> dict[str, Any]:
    """Return the values of those parameters that the table holds; invalid ones are left out."""
    values = {}
    for name in [name for name in parameters if name in table]:
        try:
            values[name] = _read_value(parameters[name], table[name])
        except ValueError as error:
            mistakes.append(f"{where}{name}: {error}")
    return values


def _read_value(parameter: Parameter, value: object) -> Any:
    right = parameter.control.range_text
    if not isinstance(value, str | int | float):
        raise ValueError(f"{to_text(value)} is not a text, a number or a truth value ({right})")
    if isinstance(value, str) and len(value) > MAX_TEXT:
        raise ValueError(f"{to_text(value)} is too long ({right})")
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        raise ValueError(f"{to_text(value)} is outside {right}")
    try:
        return parameter.check(value)
    except ValueError as error:
        raise ValueError(f"{error}" if right in str(error) else f"{error} ({right})") from None


def asset_path(folder: Path | None, text: str) -> Path:
    """Return the file or folder that a path in a style names.

    Raises:
        ValueError: it does not exist, or leads out of the style's folder, also through a link.
    """
    if folder is None:
        raise ValueError(f"{text!r} cannot be found: this style has no folder")
    try:
        path = (folder / text).resolve()
        inside = path.is_relative_to(folder.resolve())
        exists = path.is_file() or path.is_dir()
    except (OSError, RuntimeError):
        inside = exists = False
    if not exists:
        raise ValueError(f"{text!r} is not in the style's folder {folder}")
    if not inside:
        raise ValueError(f"{text!r} leads out of the style's folder {folder}")
    return path


def to_text(value: object) -> str:
    """Return any value as a short text for messages."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        return "a huge number"
    text = repr(value) if isinstance(value, str | int | float) else str(value)
    return text if len(text) <= 60 else f"{text[:56]}...{text[-1]}"
