"""Controls that name saved pictures and files."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from vidstyle.block.controls import OptionControl

NAME_PATTERN = "[A-Za-z_][A-Za-z0-9_-]{0,63}"
"""Regular expression for the names of saved pictures."""


@dataclass(frozen=True)
class SavedRef(OptionControl):
    """The name of a picture that an earlier step saved, or "source"; the block gets the picture's array.

    Attributes:
        on: what the block gets: "luma" an H x W array, "same" the same channels as its input; with "chroma"
            the renderer combines the result with that picture's chroma and the block gets None.
        optional: whether the name may be empty; the block then gets None.
        none: what pages show for an empty name.
    """

    help: str
    on: Literal["luma", "same", "chroma"] = "same"
    optional: bool = False
    none: str = "none"
    picks = "picture"
    range_text = "the name of a saved picture, or source"

    def check(self, value: object, is_integer: bool) -> str:
        """Return the value if it is a valid name. The check of the style verifies that a step saves it."""
        if value == "" and self.optional:
            return ""
        if not (isinstance(value, str) and re.fullmatch(NAME_PATTERN, value)):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"type": "string", "pattern": f"^({NAME_PATTERN})?$" if self.optional else f"^{NAME_PATTERN}$"}

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        described = {"kind": "choice", "options": saved}
        return described | {"options": ["", *saved], "none": self.none} if self.optional else described

    def argument(self, value: Any) -> Any:
        return None if isinstance(value, str) and not value else value


@dataclass(frozen=True)
class Asset(OptionControl):
    """A file or folder in the style's folder; the block gets its content.

    Attributes:
        read: reads the content from the checked path, once per style; raises ValueError with the reason if
            the content is invalid.
        shipped: the files shipped with vidstyle, by the name that styles use for them.
        optional: whether the path may be empty; the block then gets None.
    """

    help: str
    read: Callable[[Path], object]
    shipped: Callable[[], dict[str, Path]] = dict
    optional: bool = False
    picks = "file"

    @property
    def range_text(self) -> str:
        """The shipped names, and the other allowed values."""
        return ", ".join([*sorted(self.shipped()), "a path inside the style's folder"])

    def check(self, value: object, is_integer: bool) -> str:
        """Return the value if it is a plain relative path. The check of the style verifies that it exists."""
        text = value if isinstance(value, str) and (value or self.optional) else "/"
        path = Path(text)
        if path.is_absolute() or ".." in path.parts or not {"\\", ":", "\0"}.isdisjoint(text):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return text

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"type": "string"} if self.optional else {"type": "string", "minLength": 1}

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        return {"kind": "choice", "options": [""] * self.optional + sorted(self.shipped())}

    def argument(self, value: Any) -> Any:
        return None if isinstance(value, str) and not value else value

    def own_file(self, value: Any) -> str:
        return value if value and value not in self.shipped() else ""
