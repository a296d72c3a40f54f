"""Single values of a style file: checking them, showing them in errors, hinting at what was meant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from vidstyle.block import Parameter

MAX_TEXT = 200
MAX_MISTAKES = 50
"""How many are named."""
MAX_NAMES = 40
"""In a list for people."""
MAX_WHOLE = 2**53


def read_values(
    parameters: Mapping[str, Parameter], table: Mapping[str, object], where: str, mistakes: list[str]
) -> dict[str, Any]:
    """The table's values for the parameters, all of which it holds; those with mistakes are left out."""
    values = {}
    for name, parameter in parameters.items():
        try:
            values[name] = _read_value(parameter, table[name])
        except ValueError as error:
            mistakes.append(f"{where}{name}: {error}")
    return values


def _read_value(parameter: Parameter, value: object) -> Any:
    right = parameter.control.range_text
    if not isinstance(value, str | int | float):
        raise ValueError(f"{shown(value)} is not a text, a number or a truth value ({right})")
    if isinstance(value, str) and len(value) > MAX_TEXT:
        raise ValueError(f"{shown(value)} is too long ({right})")
    if isinstance(value, int) and abs(value) > MAX_WHOLE:
        raise ValueError(f"{shown(value)} is outside {right}")
    try:
        return parameter.check(value)
    except ValueError as error:
        raise ValueError(f"{error}" if right in str(error) else f"{error} ({right})") from None


def asset_path(folder: Path | None, text: str) -> Path:
    """The file or folder that a path in a style means.

    Raises:
        ValueError: it is not there, or leads out of the style's folder, through a link included.
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


def nearest(word: str, names: Iterable[str]) -> str:
    """A hint at the right name: the one most like the word, or else all of them.

    >>> nearest("levls", ["levels", "smooth"])
    'did you mean levels?'
    >>> nearest("colour", ["levels", "smooth"])
    'there are levels, smooth'
    """
    names = list(names)
    like = get_close_matches(word.lower()[:MAX_TEXT], names, n=1)
    if like:
        return f"did you mean {like[0]}?"
    return f"there are {listed(names)}" if names else "there are none"


def listed(names: Sequence[str], between: str = ", ") -> str:
    """The names for people, as many as anybody reads.

    >>> listed(["a", "b"], " or ")
    'a or b'
    """
    rest = len(names) - MAX_NAMES
    return between.join(names[:MAX_NAMES]) + (f" and {rest} more" if rest > 0 else "")


def shown(value: object) -> str:
    """The value for people: short, whatever it is."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, int) and abs(value) > MAX_WHOLE:
        return "a huge number"
    text = repr(value) if isinstance(value, str | int | float) else str(value)
    return text if len(text) <= 60 else f"{text[:56]}...{text[-1]}"
