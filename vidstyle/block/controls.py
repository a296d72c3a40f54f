"""Controls: what may be set on a parameter of a block, and how it is described."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast

from vidstyle.block.color_names import COLOR_NAMES
from vidstyle.errors import suggest

NAME_PATTERN = "[A-Za-z_][A-Za-z0-9_-]{0,63}"
"""Regular expression for the names of saved pictures."""


@dataclass(frozen=True)
class Slider:
    """A number in a range; an integer where the parameter is annotated `int`.

    Attributes:
        low, high: the range, both ends included.
        help: one line, without a full stop.
        unit: "px" for lengths that follow the picture's size, "s", "degrees", "levels of 255" and so on.
        explore: the range for random styles; None keeps the default.
        power: by which power of a picture's size the value grows, in styles that name a `height`: 1 for the
            slope of edges, and for lengths, which is what "px" means; -1 for the width of a ramp of tones.
        grows_if: the name of a switch of the block without which it does not grow.
    """

    low: float
    high: float
    help: str
    unit: str = ""
    explore: tuple[float, float] | None = None
    power: int = 0
    grows_if: str = ""

    def __post_init__(self) -> None:
        if self.unit == "px":
            object.__setattr__(self, "power", 1)

    def check(self, value: object, is_integer: bool) -> int | float:
        """The value as a number in range.

        Raises:
            ValueError: it is not one; the message names the range.
        """
        is_number = not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value)
        if not is_number or (is_integer and value != int(cast(float, value))):
            raise ValueError(f"{value!r} is not a {'whole ' if is_integer else ''}number")
        value = cast(float, value)
        if not self.low <= value <= self.high:
            raise ValueError(f"{value:g} is outside {self.range_text}")
        return int(value) if is_integer else float(value)

    @property
    def range_text(self) -> str:
        """The range and unit as text: "0.5 to 8 px"."""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()

    def schema(self, is_integer: bool) -> dict[str, Any]:
        kind = "integer" if is_integer else "number"
        return {"type": kind, "minimum": self.low, "maximum": self.high}


@dataclass(frozen=True)
class Choice:
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


@dataclass(frozen=True)
class Switch:
    """On or off."""

    help: str
    explore: tuple[bool, ...] = ()
    range_text = "true or false"

    def check(self, value: object, is_integer: bool) -> bool:
        if not isinstance(value, bool):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"type": "boolean"}


@dataclass(frozen=True)
class Color:
    """A colour written "#rrggbb", "#rgb" or as CSS names it; the block gets three floats 0..1."""

    help: str
    explore: tuple[str, ...] = ()
    range_text = "#rrggbb, #rgb or a CSS name"

    def check(self, value: object, is_integer: bool) -> str:
        """The colour as "#rrggbb"."""
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


@dataclass(frozen=True)
class SavedRef:
    """The name of a picture that an earlier step saved, or "source"; the block gets the picture's array.

    Attributes:
        on: what the block gets: "luma" an H x W array, "same" the channels of its own input; with "chroma"
            the renderer combines the result with that picture's chroma and the block gets None.
        optional: whether the name may be empty; the block then gets None.
    """

    help: str
    on: Literal["luma", "same", "chroma"] = "same"
    optional: bool = False
    range_text = "the name of a saved picture, or source"

    def check(self, value: object, is_integer: bool) -> str:
        """The value, if it is a valid name. Whether a step saves it is checked with the style."""
        if value == "" and self.optional:
            return ""
        if not (isinstance(value, str) and re.fullmatch(NAME_PATTERN, value)):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"type": "string", "pattern": f"^({NAME_PATTERN})?$" if self.optional else f"^{NAME_PATTERN}$"}


@dataclass(frozen=True)
class Asset:
    """A file or folder inside the style's own folder; the block gets its content.

    Attributes:
        read: reads the content from the checked path, once for each style; raises ValueError with the
            reason when the content is not valid.
        shipped: the files that come with vidstyle, by the name under which a style may use them.
        optional: whether the path may be empty; the block then gets None.
    """

    help: str
    read: Callable[[Path], object]
    shipped: Callable[[], dict[str, Path]] = dict
    optional: bool = False

    @property
    def range_text(self) -> str:
        """The shipped names, and what else it may be."""
        return ", ".join([*sorted(self.shipped()), "a path inside the style's folder"])

    def check(self, value: object, is_integer: bool) -> str:
        """The value, if it is a plain relative path. Whether it exists is checked with the style."""
        text = value if isinstance(value, str) and (value or self.optional) else "/"
        path = Path(text)
        if path.is_absolute() or ".." in path.parts or not {"\\", ":", "\0"}.isdisjoint(text):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return text

    def schema(self, is_integer: bool) -> dict[str, Any]:
        return {"type": "string"} if self.optional else {"type": "string", "minLength": 1}


Control = Slider | Choice | Switch | Color | SavedRef | Asset


@dataclass(frozen=True)
class Parameter:
    """A named value with its control and default."""

    name: str
    control: Control
    default: Any
    is_integer: bool = False

    def check(self, value: object) -> Any:
        """The value in its proper type.

        Raises:
            ValueError: it is not valid; the message says what would be.
        """
        return self.control.check(value, self.is_integer)

    def schema(self) -> dict[str, Any]:
        """Its JSON Schema, with help and default."""
        described = {"description": self.control.help, "default": self.default}
        return self.control.schema(self.is_integer) | described


def rgb_from_text(text: str) -> tuple[float, float, float]:
    """The colour "#rrggbb" as red, green and blue, 0..1.

    >>> rgb_from_text("#ff8000")
    (1.0, 0.5019607843137255, 0.0)
    """
    red, green, blue = bytes.fromhex(text[1:])
    return red / 255, green / 255, blue / 255
