"""An editable comic: a TOML file with all pages, which can be saved with a comic and used instead of a film.

It contains every decision: frames by their times, the part of each that is shown, rectangles on the page,
and words with their line breaks. A comic is reproduced byte for byte, except for the values that are changed.
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any, get_args

from vidstyle.comic.analyze.film import Film
from vidstyle.comic.key_frame import Box, KeyFrame, Rectangle
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.lettering.bubble import Bubble, BubbleKind, TextBlock, bubble_size
from vidstyle.comic.lettering.fonts import Letters, find_comic_font
from vidstyle.comic.output.panel_renderer import PagePlan
from vidstyle.comic.output.sheet import Label
from vidstyle.errors import InputError

FORMAT_VERSION = 1
_MAX_FILE_BYTES, _MAX_PANELS, _MAX_SIDE_PX, _MAX_PAGE_PIXELS = 1 << 20, 300, 200_000, 1 << 28
"""Limits of a page file, of its panels and of its pages."""
_COMIC_FONT, _BUILT_IN_FONT = "comic", "built-in"
"""Names of fonts that are not files."""


def page_file(plan: PagePlan, source: str, target: Path, title: str, styles: Sequence[str]) -> str:
    """Return the file of a comic.

    Args:
        plan: the comic.
        source: film or folder.
        target: where the file will be written; the path of the source is relative to it.
        title: of the comic.
        styles: names or paths.
    """
    return "\n".join(_lines(plan, _relative(source, target), title, styles)) + "\n"


def _relative(source: str, target: Path) -> str:
    try:
        return Path(os.path.relpath(source, target.parent)).as_posix()
    except ValueError:  # another drive
        return os.path.abspath(source)


def _lines(plan: PagePlan, source: str, title: str, styles: Sequence[str]) -> Iterator[str]:
    letters = plan.letters
    font = str(letters.path) if letters.path else _BUILT_IN_FONT
    yield "# A comic of vidstyle: `vidstyle comic THIS-FILE OUTPUT` draws it. Change a time, a word, a place."
    yield "# Places are left, top, right, bottom in pixels of the page; window: the part of the frame shown."
    yield from _entries(
        format=FORMAT_VERSION, source=source, title=title, styles=list(styles), dpi=float(plan.dpi)
    )
    yield from _entries(reading="rtl" if plan.right_to_left else "ltr")
    yield from _entries(font=_COMIC_FONT if letters.path and letters.path == find_comic_font() else font)
    for page, size in enumerate(plan.layout.sizes):
        yield from ("", "[[page]]", *_entries(size=list(size)))
        for panel in plan.layout.panels:
            if panel.page == page:
                yield from _panel(panel, plan.key_frames[panel.key_frame])
        for label in plan.labels[page]:
            yield from ("", "[[page.label]]", *_entries(text=label.text, at=[label.middle, label.foot]))
            yield from _entries(size=label.size, bold=label.is_bold)


def _panel(panel: Panel, key_frame: KeyFrame) -> Iterator[str]:
    yield from ("", "[[page.panel]]", *_entries(time=key_frame.time, window=list(panel.crop)))
    yield from _entries(place=list(panel.rectangle), picture=list(panel.picture), leans=list(panel.leans))
    for bubble in panel.bubbles:
        yield from ("", "[[page.panel.words]]", *_entries(text="\n".join(bubble.block.lines)))
        yield from _entries(kind=bubble.kind, size=bubble.block.size, place=list(bubble.box))
        yield from _entries(tip=list(bubble.tip)) if bubble.tip else ()


def _entries(**values: Any) -> Iterator[str]:
    # Strings, numbers, arrays and booleans of JSON are valid TOML, except for one control character.
    for name, value in values.items():
        text = json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
        yield f"{name} = {text}"


@dataclass(frozen=True)
class PageFile:
    """A comic read from its file, before its film is opened.

    Attributes:
        source: film or folder.
        title: of the comic.
        styles: names or paths.
    """

    source: str
    title: str
    styles: tuple[str, ...]
    _data: _Table

    def plan(self, film: Film) -> PagePlan:
        """Return the comic.

        Raises:
            InputError: a value is missing or impossible, or the film has no such time.
        """
        data = self._data
        letters, dpi = _letters(data), data.number("dpi", 10, 2400)
        key_frames, panels, sizes, labels = list[KeyFrame](), list[Panel](), list[tuple[int, int]](), []
        for page in data.tables("page"):
            width, height = page.whole("size", 2, 64, _MAX_SIDE_PX)
            if width * height > _MAX_PAGE_PIXELS:
                raise page.error("size", f"is more than {_MAX_PAGE_PIXELS} pixels")
            sheet = Rectangle(0, 0, width, height)
            for each in page.tables("panel"):
                panels.append(_read_panel(each, len(key_frames), len(sizes), letters, sheet))
                key_frames.append(replace(film.at(each.number("time", 0)), small=None))
            sizes.append((width, height))
            labels.append([_read_label(each, letters) for each in page.tables("label")])
        if not 1 <= len(panels) <= _MAX_PANELS:
            raise data.error("panel", f"has {len(panels)} entries", f"give 1 to {_MAX_PANELS}")
        layout = PageLayout(tuple(panels), tuple(sizes), 0.0)
        return PagePlan(key_frames, layout, labels, letters, dpi, data.value("reading", str) == "rtl")


def read_page_file(path: Path) -> PageFile:
    """Read the file of a comic.

    Raises:
        InputError: it cannot be read, or is not a page file.
    """
    try:
        content = path.read_bytes()
        if len(content) > _MAX_FILE_BYTES:
            raise InputError(path, f"is larger than {_MAX_FILE_BYTES >> 20} MiB", "give the file of a comic")
        data = _Table(tomllib.loads(content.decode()), path, "")
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(path, f"is not TOML: {error}", "fix it, or write it again with --save") from None
    if data.value("format", int) != FORMAT_VERSION:
        raise data.error("format", "is an unknown version", f"the known version is {FORMAT_VERSION}")
    source = str(path.parent / data.value("source", str))
    styles = data.value("styles", list)
    if not styles or not all(isinstance(each, str) for each in styles):
        raise data.error("styles", "is not a list of names")
    return PageFile(source, data.value("title", str), tuple(styles), data)


def _letters(data: _Table) -> Letters:
    font = data.value("font", str)
    if font == _COMIC_FONT:
        path = find_comic_font()
        if path is None:
            raise data.error("font", "is not installed", "pip install 'vidstyle[comic]'")
        return Letters(path, capitals=True)
    return Letters() if font == _BUILT_IN_FONT else Letters(Path(font))


def _read_panel(table: _Table, key_frame: int, page: int, letters: Letters, sheet: Rectangle) -> Panel:
    place, picture = (table.rectangle(name) for name in ("place", "picture"))
    if not (sheet.contains(place) and place.contains(picture)):
        raise table.error("place", "is not on its page, or does not contain its picture")
    left, right = table.whole("leans", 2, -_MAX_SIDE_PX, _MAX_SIDE_PX)
    if 2 * (abs(left) + abs(right)) >= picture.width:
        raise table.error("leans", "are wider than the panel")
    words = tuple(_read_words(each, letters) for each in table.tables("words"))
    return Panel(key_frame, page, place, picture, table.box("window"), words, (left, right))


def _read_words(table: _Table, letters: Letters) -> Bubble:
    kind, (size,) = table.value("kind", str), table.whole("size", 1, 1, 1000)
    if kind not in get_args(BubbleKind):
        raise table.error("kind", f"is not one of {', '.join(get_args(BubbleKind))}")
    lines = tuple(letters.make_writable(line) for line in table.value("text", str).split("\n"))
    block = TextBlock(lines, tuple(letters.width(line, size) for line in lines), size)
    box, wanted = table.box("place"), bubble_size(kind, block)
    if kind != "band" and (box.width, box.height) != wanted:
        # The words have changed, so the shape grows or shrinks around its centre.
        across, down = (wanted[0] - box.width) / 2, (wanted[1] - box.height) / 2
        box = box.padded(across, down, down)
    tip = table.numbers("tip", 2) if table.has("tip") else None
    return Bubble(kind, box, block, (tip[0], tip[1]) if tip else None)


def _read_label(table: _Table, letters: Letters) -> Label:
    (middle, foot), (size,) = table.numbers("at", 2), table.whole("size", 1, 1, 1000)
    return Label(table.value("text", str), middle, foot, size, table.value("bold", bool))


@dataclass(frozen=True)
class _Table:
    """A table of the file, with its path, and its position in the file for messages."""

    content: dict[str, Any]
    path: Path
    place: str

    def error(self, name: str, reason: str, remedy: str = "") -> InputError:
        return InputError(self.path, f"{self.place}{name} {reason}", remedy)

    def has(self, name: str) -> bool:
        return name in self.content

    def value(self, name: str, kind: type) -> Any:
        if type(self.content.get(name)) is not kind:
            raise self.error(name, "is missing or has the wrong type")
        return self.content[name]

    def tables(self, name: str) -> list[_Table]:
        found = self.content.get(name, [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            raise self.error(name, "is not a list of tables")
        return [
            _Table(each, self.path, f"{self.place}{name} {number}: ") for number, each in enumerate(found, 1)
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
        return Rectangle(*self.whole(name, 4, 0, _MAX_SIDE_PX))
