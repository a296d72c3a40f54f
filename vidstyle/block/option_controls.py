"""Controls with few values: words, switches and colours."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from vidstyle.block.color_names import COLOR_NAMES
from vidstyle.block.controls import OptionControl
from vidstyle.errors import suggest


@dataclass(frozen=True)
class Choice(OptionControl):
    """One of several words."""

    options: tuple[str, ...]
    help: str
    explore: tuple[str, ...] = ()

    def check(self, value: object, is_integer: bool) -> str:
        if value not in self.options:
            raise ValueError(f"{value!r} is not one of {self.range_text}")
        return str(value)

    @property
    def range_text(self) -> str:
        return ", ".join(self.options)

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"enum": list(self.options)}

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        return {"kind": "choice", "options": list(self.options)}


@dataclass(frozen=True)
class Switch(OptionControl):
    """On or off."""

    help: str
    explore: tuple[bool, ...] = ()
    takes_text = False
    range_text = "true or false"

    def check(self, value: object, is_integer: bool) -> bool:
        if not isinstance(value, bool):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"type": "boolean"}

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        return {"kind": "switch"}

    def text(self, value: Any) -> str:
        return str(value).lower()


@dataclass(frozen=True)
class Color(OptionControl):
    """A colour: "#rrggbb", "#rgb" or a CSS name; the block gets three floats 0..1."""

    help: str
    explore: tuple[str, ...] = ()
    changes_structure = False
    range_text = "#rrggbb, #rgb or a CSS name"

    def check(self, value: object, is_integer: bool) -> str:
        """Return the colour as "#rrggbb"."""
        text = value.strip().lower() if isinstance(value, str) else ""
        code = COLOR_NAMES.get(text, text)
        if re.fullmatch("#[0-9a-f]{3}", code):
            code = "#" + "".join(2 * digit for digit in code[1:])
        if not re.fullmatch("#[0-9a-f]{6}", code):
            hint = suggest(text, COLOR_NAMES) if text.isalpha() else ""
            near = f"; {hint}" if hint.startswith("did") else ""
            raise ValueError(f"{value!r} is not a colour{near} ({self.range_text})")
        return code

    def schema(self, is_integer: bool) -> dict[str, Any]:
        pattern = "^#([0-9a-fA-F]{3}){1,2}$"
        return {"type": "string", "anyOf": [{"pattern": pattern}, {"enum": list(COLOR_NAMES)}]}

    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        return {"kind": "color"}

    def argument(self, value: Any) -> Any:
        return rgb_from_text(value) if isinstance(value, str) else value

    def between(self, one: Any, other: Any, share: float, is_integer: bool) -> Any:
        codes = zip(bytes.fromhex(one[1:]), bytes.fromhex(other[1:]), strict=True)
        return "#" + bytes(round(low + (high - low) * share) for low, high in codes).hex()


def rgb_from_text(text: str) -> tuple[float, float, float]:
    """Convert the colour "#rrggbb" to red, green and blue, 0..1.

    >>> rgb_from_text("#ff8000")
    (1.0, 0.5019607843137255, 0.0)
    """
    red, green, blue = bytes.fromhex(text[1:])
    return red / 255, green / 255, blue / 255
