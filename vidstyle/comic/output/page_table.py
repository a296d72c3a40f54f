"""Tables of a page file: their keys, and values checked for their types and ranges."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from vidstyle.comic.lettering.characters import control_character
from vidstyle.errors import InputError, printable, suggest
from vidstyle.regions.boxes import Box, Point, Rectangle

MAX_LETTERS = 4000
"""Maximum number of characters in a text."""
MAX_SIDE_PX = 200_000
"""Maximum side of a page."""
FILE_KEYS = ("format", "source", "rotate", "title", "styles", "dpi", "reading", "font", "page")
TABLE_KEYS = {
    "page": ("size", "panel", "label"),
    "panel": ("time", "window", "place", "picture", "leans", "words"),
    "words": ("text", "kind", "size", "place", "tip"),
    "label": ("text", "at", "size", "bold"),
}
"""The keys of each table in the file; `FILE_KEYS` outside them."""


@dataclass(frozen=True)
class PageTable:
    """A table of the file.

    Attributes:
        content: its keys and values.
        path: the file.
        place: its position in the file, for messages.
        keys: the keys that it may have.

    Raises:
        InputError: it has another key.
    """

    content: dict[str, Any]
    path: Path
    place: str = ""
    keys: tuple[str, ...] = FILE_KEYS

    def __post_init__(self) -> None:
        unknown = [name for name in self.content if name not in self.keys]
        if unknown:
            raise self.error(printable(unknown[0]), "is an unknown key", suggest(unknown[0], self.keys))

    def error(self, name: str, reason: str, remedy: str = "") -> InputError:
        return InputError(self.path, f"{self.place}{name} {reason}", remedy)

    def has(self, name: str) -> bool:
        return name in self.content

    def value(self, name: str, kind: type) -> Any:
        if type(self.content.get(name)) is not kind:
            raise self.error(name, "is missing or has the wrong type")
        return self.content[name]

    def text(self, name: str, has_lines: bool = False) -> str:
        found = str(self.value(name, str))
        if len(found) > MAX_LETTERS:
            raise self.error(name, f"has more than {MAX_LETTERS} characters", "shorten it")
        if control := control_character(found.replace("\n", "") if has_lines else found):
            raise self.error(name, f"holds the control character {control}", "remove it")
        return found

    def tables(self, name: str) -> list[PageTable]:
        found = self.content.get(name, [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            raise self.error(name, "is not a list of tables")
        return [
            PageTable(each, self.path, f"{self.place}{name} {number}: ", TABLE_KEYS[name])
            for number, each in enumerate(found, 1)
        ]

    def number(self, name: str, least: float, most: float = 1e9) -> float:
        (number,) = self.numbers(name, 1)
        if not least <= number <= most:
            raise self.error(name, f"is outside {least:g} to {most:g}")
        return number

    def numbers(self, name: str, count: int) -> list[float]:
        found = self.content.get(name)
        found = found if isinstance(found, list) else [found]
        if len(found) != count or not all(type(each) in (int, float) and isfinite(each) for each in found):
            raise self.error(name, "is missing or not a number" if count == 1 else f"is not {count} numbers")
        return [float(each) for each in found]

    def point(self, name: str, sheet: Rectangle) -> Point:
        across, down = self.numbers(name, 2)
        if not (0 <= across <= sheet.width and 0 <= down <= sheet.height):
            raise self.error(name, "is not on its page")
        return across, down

    def whole(self, name: str, count: int, least: int, most: int) -> list[int]:
        found = self.numbers(name, count)
        if not all(each == int(each) and least <= each <= most for each in found):
            raise self.error(name, f"must contain whole numbers from {least} to {most}")
        return [int(each) for each in found]

    def box(self, name: str) -> Box:
        box = Box(*self.numbers(name, 4))
        if box.area <= 0 or max(map(abs, box)) > 1e6:
            raise self.error(name, "is not a rectangle: left, top, right, bottom")
        return box

    def rectangle(self, name: str) -> Rectangle:
        self.box(name)
        return Rectangle(*self.whole(name, 4, 0, MAX_SIDE_PX))
