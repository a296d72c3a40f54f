"""Room for a title above the panels of the first page, and what is written beside panels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from vidstyle.comic.layout.crop import crop
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.paper import Paper, Rectangle
from vidstyle.comic.lettering.bubble import Bubble, size_of
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.lettering.subtitles import Line
from vidstyle.comic.lettering.wrap import TextBlock, shapes
from vidstyle.comic.moment import Box, Moment
from vidstyle.comic.output.sheet import Label

_TITLE = 2.6
"""Size of a title, in sizes of the letters."""
_AIR = 0.7
"""Below it, in sizes of its own."""
_NUMBER = 0.45
"""Size of a page's number, at most, in margins."""


def title_of(text: str, paper: Paper, size: int, letters: Letters) -> tuple[Label, int]:
    """A title in the middle of the page's head, and how much lower the panels are because of it.

    Args:
        size: that of the other letters, in pixels.
    """
    text, wanted = letters.writable(text), round(_TITLE * size)
    wide = letters.width(text, wanted)
    room = paper.width - 2 * paper.margin
    fitting = wanted if wide <= room else max(1, int(wanted * room / wide))
    foot = paper.margin + 0.8 * fitting
    return Label(text, paper.width / 2, foot, fitting, is_bold=True), round(fitting * (0.8 + _AIR))


def below_title(paper: Paper, by: int, pages: int) -> Paper:
    """What panels are to be laid out on: a single page without the title's part; of several, whole pages."""
    return replace(paper, height=paper.height - by) if pages == 1 and not paper.is_strip else paper


def lowered(layout: PageLayout, moments: Sequence[Moment], paper: Paper, by: int) -> PageLayout:
    """The layout with the panels of the first page in what is left below a title; gutters stay as wide."""
    if paper.is_strip or layout.sizes[0][1] < paper.height:
        panels = [replace(each, rectangle=_moved(each.rectangle, paper, by)) for each in layout.panels]
        sizes = [(paper.width, layout.sizes[0][1] + by)]
    else:
        panels = [_squeezed(each, moments, paper, by) if each.page == 0 else each for each in layout.panels]
        sizes = list(layout.sizes)
    return replace(layout, panels=tuple(panels), sizes=tuple(sizes))


def _moved(rectangle: Rectangle, paper: Paper, by: int) -> Rectangle:
    # A panel that bleeds does not do so under the title.
    return rectangle._replace(top=max(rectangle.top, paper.margin) + by, bottom=rectangle.bottom + by)


def _squeezed(panel: Panel, moments: Sequence[Moment], paper: Paper, by: int) -> Panel:
    inside, gutter = paper.inside, paper.row_gutter
    factor = (inside.height - by + gutter) / (inside.height + gutter)

    def line(y: int) -> int:
        return inside.top + by + round((y - inside.top) * factor)

    left, top, right, bottom = panel.rectangle
    # One that bleeds does so aside and below, but not under the title.
    low = bottom if bottom > inside.bottom else line(bottom + gutter) - gutter
    rectangle = Rectangle(left, line(max(top, inside.top)), right, low)
    return replace(panel, rectangle=rectangle, crop=crop(moments[panel.moment], rectangle.aspect))


def numbers(layout: PageLayout, paper: Paper, size: int) -> Iterator[list[Label]]:
    """The number below the panels of each page, where there are several and there is room."""
    for page, (width, height) in enumerate(layout.sizes):
        letters = min(size, round(_NUMBER * paper.margin))
        covered = any(each.page == page and each.rectangle.bottom >= height for each in layout.panels)
        if len(layout.sizes) == 1 or letters < 5 or covered:
            yield []
        else:
            foot = height - paper.margin / 2 + 0.35 * letters
            yield [Label(str(page + 1), width / 2, foot, letters)]


_APART = 0.3
"""How much nearer to one another bands are than they need be, in sizes of the letters."""


def bands(lines: Sequence[Line], inside: Rectangle, letters: Letters, size: int) -> list[Bubble] | None:
    """The lines one below the other at the top of a panel; None if a word is too wide for it.

    Args:
        size: of the letters, in pixels.
    """
    found, top = list[Bubble](), inside.top
    for line in lines:
        block = _flattest(letters, line.text, size, inside.width - round(1.2 * size))
        if block is None:
            return None
        _, height = size_of("band", block)
        found.append(Bubble("band", Box(inside.left, top, inside.right, top + height), block))
        top += round(height - _APART * size)
    return found


def below_bands(found: Sequence[Bubble], inside: Rectangle, border: int) -> Rectangle:
    """What they and a border leave of the panel."""
    return inside._replace(top=round(found[-1].box.bottom) + border)


def _flattest(letters: Letters, text: str, size: int, widest: int) -> TextBlock | None:
    tried = shapes(letters, letters.writable(text), size, widest) if widest > 0 else []
    return min(tried, key=lambda block: len(block.lines), default=None)
