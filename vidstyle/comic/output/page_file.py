"""An editable comic: a TOML file with all pages, which can be saved with a comic and used instead of a film.

It contains every decision: frames by their times, the part of each that is shown, rectangles on the page,
and words with their line breaks. A comic is reproduced byte for byte, except for the values that are changed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.paper import MAX_PAGE_PIXELS
from vidstyle.comic.lettering.bubble import Bubble, BubbleKind, TextBlock, bubble_size
from vidstyle.comic.lettering.fonts import Letters, find_comic_font
from vidstyle.comic.output.page_table import MAX_SIDE_PX, PageTable
from vidstyle.comic.output.panel_renderer import PagePlan
from vidstyle.comic.output.sheet import Label
from vidstyle.core.file_checks import parse_toml, read_toml_text
from vidstyle.errors import InputError
from vidstyle.regions.boxes import Box, Rectangle

FORMAT_VERSION = 1
_MAX_FILE_BYTES, _MAX_PANELS, _MAX_SHEET_PIXELS = 1 << 20, 300, 1 << 28
"""Limits of a file, of its panels and of its pages."""
_MAX_TOTAL_PIXELS = 1 << 29
"""Maximum number of pixels of all pages together: 61 pages of A4 at 300 dots per inch."""
_MAX_COVERAGE_RATIO = 2
"""Maximum area of the pictures of a page, or of its words, relative to the page: few overlap."""
_MAX_TEXT_COUNT = 4000
"""Maximum number of balloons, captions and labels in all."""
_COMIC_FONT, _BUILT_IN_FONT = "comic", "built-in"
"""Names of fonts that are not files."""


def page_file(
    plan: PagePlan,
    source: str,
    target: Path,
    title: str,
    styles: Sequence[str],
    rotate: int | None = None,
) -> str:
    """Return the file of a comic.

    Args:
        plan: the comic.
        source: film or folder.
        target: where the file will be written; the path of the source is relative to it.
        title: of the comic.
        styles: names or paths.
        rotate: degrees clockwise; None: as stored in the source.
    """
    return "\n".join(_lines(plan, _relative(source, target), title, styles, rotate)) + "\n"


def _relative(source: str, target: Path) -> str:
    try:
        return Path(os.path.relpath(source, target.parent)).as_posix()
    except ValueError:  # another drive
        return os.path.abspath(source)


def _lines(
    plan: PagePlan, source: str, title: str, styles: Sequence[str], rotate: int | None
) -> Iterator[str]:
    letters = plan.letters
    font = str(letters.path) if letters.path else _BUILT_IN_FONT
    yield "# A comic of vidstyle: `vidstyle comic THIS-FILE OUTPUT` draws it. Change a time, a word, a place."
    yield "# Places are left, top, right, bottom in pixels of the page; window: the part of the frame shown."
    yield from _entries(
        format=FORMAT_VERSION, source=source, title=title, styles=list(styles), dpi=float(plan.dpi)
    )
    yield from () if rotate is None else _entries(rotate=rotate)
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
    window = panel.crop.moved(0, key_frame.trimmed)
    yield from ("", "[[page.panel]]", *_entries(time=key_frame.time, window=list(window)))
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
        rotate: degrees clockwise; None: as stored in the source.
    """

    source: str
    title: str
    styles: tuple[str, ...]
    rotate: int | None
    _data: PageTable

    def plan(self, film: Film) -> PagePlan:
        """Return the comic.

        Raises:
            InputError: a value is missing or impossible, or the film has no such time.
        """
        data = self._data
        letters, dpi = _letters(data), data.number("dpi", 10, 2400)
        if (reading := data.value("reading", str)) not in ("ltr", "rtl"):
            raise data.error("reading", "is neither ltr nor rtl")
        pages = data.tables("page")
        sheets = [Rectangle(0, 0, *each.whole("size", 2, 64, MAX_SIDE_PX)) for each in pages]
        _check_counts(data, pages, sheets)
        tables = [(number, each) for number, page in enumerate(pages) for each in page.tables("panel")]
        panels = [
            _read_panel(each, number, page, letters, sheets[page])
            for number, (page, each) in enumerate(tables)
        ]
        labels = [
            [_read_label(each, letters, sheet) for each in page.tables("label")]
            for page, sheet in zip(pages, sheets, strict=True)
        ]
        for number, page in enumerate(pages):
            shown = [panel for panel in panels if panel.page == number]
            _check_coverage(page, sheets[number], shown, labels[number], letters)
        key_frames = [_read_key_frame(each, film) for _, each in tables]
        layout = PageLayout(tuple(panels), tuple((each.right, each.bottom) for each in sheets), 0.0)
        return PagePlan(key_frames, layout, labels, letters, dpi, reading == "rtl")


def read_page_file(path: Path) -> PageFile:
    """Read the file of a comic.

    Raises:
        InputError: it cannot be read, or is not a page file.
    """
    try:
        data = PageTable(parse_toml(read_toml_text(path, _MAX_FILE_BYTES)), path)
    except ValueError as error:
        raise InputError(path, str(error)) from None
    if data.value("format", int) != FORMAT_VERSION:
        raise data.error("format", "is an unknown version", f"the known version is {FORMAT_VERSION}")
    source = str(path.parent / data.text("source"))
    styles = data.value("styles", list)
    if not 1 <= len(styles) <= _MAX_PANELS or not all(isinstance(each, str) for each in styles):
        raise data.error("styles", f"is not a list of 1 to {_MAX_PANELS} names")
    rotate = data.whole("rotate", 1, 0, 270)[0] if data.has("rotate") else None
    if rotate is not None and rotate % 90:
        raise data.error("rotate", "is not a quarter turn", "give 0, 90, 180 or 270")
    return PageFile(source, data.text("title"), tuple(styles), rotate, data)


def _check_counts(data: PageTable, pages: Sequence[PageTable], sheets: Sequence[Rectangle]) -> None:
    """Raise InputError if there are too many pages, panels, words or pixels."""
    panels = [panel for page in pages for panel in page.tables("panel")]
    words = [each for panel in panels for each in panel.tables("words")]
    labels = [each for page in pages for each in page.tables("label")]
    if not 1 <= len(panels) <= _MAX_PANELS:
        raise data.error("panel", f"has {len(panels)} entries", f"give 1 to {_MAX_PANELS}")
    if len(pages) > _MAX_PANELS:
        raise data.error("page", f"has {len(pages)} entries", f"give 1 to {_MAX_PANELS}")
    if len(words) + len(labels) > _MAX_TEXT_COUNT:
        raise data.error("words", f"and label have more than {_MAX_TEXT_COUNT} entries", "remove some")
    if wide := [page for page, sheet in zip(pages, sheets, strict=True) if sheet.area > _MAX_SHEET_PIXELS]:
        raise wide[0].error("size", f"is more than {_MAX_SHEET_PIXELS} pixels", "give a smaller page")
    if sum(sheet.area for sheet in sheets) > _MAX_TOTAL_PIXELS:
        raise data.error(
            "page", f"has sizes of more than {_MAX_TOTAL_PIXELS} pixels in all", "make two comics"
        )


def _check_coverage(
    page: PageTable, sheet: Rectangle, panels: Sequence[Panel], labels: Sequence[Label], letters: Letters
) -> None:
    """Raise InputError if pictures or words cover their page several times."""
    bubbles = [bubble for panel in panels for bubble in panel.bubbles]
    words = sum(_extent(each).intersection(sheet).area for each in bubbles)
    words += sum(letters.width(each.text, each.size) * each.size for each in labels)
    for name, area in ("panel", sum(panel.picture.area for panel in panels)), ("words", words):
        if area > _MAX_COVERAGE_RATIO * sheet.area:
            reason = f"entries cover their page more than {_MAX_COVERAGE_RATIO} times"
            raise page.error(name, reason, "give smaller places")


def _extent(bubble: Bubble) -> Box:
    """The box around a bubble and its tail."""
    tip = bubble.tip or bubble.box.center
    return bubble.box.union(Box(*tip, *tip))


def _read_key_frame(table: PageTable, film: Film) -> KeyFrame:
    key_frame = replace(film.at(table.number("time", 0)), small=None)
    height, width = key_frame.shape
    if Box(0, 0, width, height).intersection(table.box("window")).area <= 0:
        raise table.error("window", f"lies outside its frame of {width}x{height} pixels")
    return key_frame


def _letters(data: PageTable) -> Letters:
    font = data.text("font")
    if font == _COMIC_FONT:
        path = find_comic_font()
        if path is None:
            raise data.error("font", "is not installed", "pip install 'vidstyle[comic]'")
        return Letters(path, capitals=True)
    return Letters() if font == _BUILT_IN_FONT else Letters(Path(font))


def _read_panel(table: PageTable, key_frame: int, page: int, letters: Letters, sheet: Rectangle) -> Panel:
    place, picture = (table.rectangle(name) for name in ("place", "picture"))
    if not (sheet.contains(place) and place.contains(picture)):
        raise table.error("place", "is not on its page, or does not contain its picture")
    if picture.area > MAX_PAGE_PIXELS:
        raise table.error("picture", f"is more than {MAX_PAGE_PIXELS} pixels", "give a smaller one")
    left, right = table.whole("leans", 2, -MAX_SIDE_PX, MAX_SIDE_PX)
    if 2 * (abs(left) + abs(right)) >= picture.width:
        raise table.error("leans", "are wider than the panel")
    words = tuple(_read_words(each, letters, sheet) for each in table.tables("words"))
    return Panel(key_frame, page, place, picture, table.box("window"), words, (left, right))


def _read_words(table: PageTable, letters: Letters, sheet: Rectangle) -> Bubble:
    kind, (size,) = table.value("kind", str), table.whole("size", 1, 1, 1000)
    if kind not in get_args(BubbleKind):
        raise table.error("kind", f"is not one of {', '.join(get_args(BubbleKind))}")
    lines = tuple(letters.make_writable(line) for line in table.text("text", has_lines=True).split("\n"))
    block = TextBlock(lines, tuple(letters.width(line, size) for line in lines), size)
    box, wanted = table.box("place"), bubble_size(kind, block)
    if max(box.width, wanted[0]) > sheet.width or max(box.height, wanted[1]) > sheet.height:
        raise table.error("text", "is larger than its page", "give fewer words or a smaller size")
    if kind != "band" and (box.width, box.height) != wanted:
        # The words have changed, so the shape grows or shrinks around its centre.
        across, down = (wanted[0] - box.width) / 2, (wanted[1] - box.height) / 2
        box = box.padded(across, down, down)
    tip = table.point("tip", sheet) if table.has("tip") else None
    return Bubble(kind, box, block, tip)


def _read_label(table: PageTable, letters: Letters, sheet: Rectangle) -> Label:
    text, (middle, foot), (size,) = (
        table.text("text"),
        table.point("at", sheet),
        table.whole("size", 1, 1, 1000),
    )
    if letters.width(text, size) > sheet.width or size > sheet.height:
        raise table.error("text", "is larger than its page", "give fewer words or a smaller size")
    return Label(text, middle, foot, size, table.value("bold", bool))
