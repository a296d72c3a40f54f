"""The title above the panels of the first page, and page numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import crop
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.lettering.fonts import Letters
from vidstyle.comic.output.sheet import Label
from vidstyle.regions.boxes import Rectangle

_TITLE_FONT_RATIO = 2.6
"""Font size of a title, relative to the comic's."""
_TITLE_SPACE_RATIO = 0.7
"""Space below a title, in font sizes of the title."""
_MAX_NUMBER_FONT_RATIO = 0.45
"""Maximum font size of a page number, relative to the margin."""


def make_title(text: str, paper: Paper, size: int, letters: Letters) -> tuple[Label, int]:
    """Return a title centred at the top of the page, and the height in pixels that it takes from the panels.

    Args:
        text: reduced in size if it is wider than the panels.
        paper: of the page.
        size: font size of the comic in pixels.
        letters: its font.
    """
    text, wanted = letters.make_writable(text), round(_TITLE_FONT_RATIO * size)
    wide = letters.width(text, wanted)
    room = paper.width - 2 * paper.margin
    fitting = wanted if wide <= room else max(1, int(wanted * room / wide))
    foot = paper.margin + 0.8 * fitting
    return Label(text, paper.width / 2, foot, fitting, is_bold=True), round(
        fitting * (0.8 + _TITLE_SPACE_RATIO)
    )


def shrink_paper(paper: Paper, by: int, pages: int) -> Paper:
    """Return the paper for the layout: a single page loses the title's height, several are unchanged."""
    return replace(paper, height=paper.height - by) if pages == 1 and not paper.is_strip else paper


def move_below_title(layout: PageLayout, key_frames: Sequence[KeyFrame], paper: Paper, by: int) -> PageLayout:
    """Move or squeeze the panels of the first page below a title, with unchanged gutters."""
    if paper.is_strip or layout.sizes[0][1] < paper.height:
        panels = [_move(each, paper, by) for each in layout.panels]
        sizes = [(paper.width, layout.sizes[0][1] + by)]
    else:
        panels = [_squeeze(each, key_frames, paper, by) if each.page == 0 else each for each in layout.panels]
        sizes = list(layout.sizes)
    return replace(layout, panels=tuple(panels), sizes=tuple(sizes))


def _move(panel: Panel, paper: Paper, by: int) -> Panel:
    left, top, right, bottom = panel.rectangle
    # No bleed under the title.
    place = Rectangle(left, max(top, paper.margin) + by, right, bottom + by)
    return replace(panel, rectangle=place, picture=place)


def _squeeze(panel: Panel, key_frames: Sequence[KeyFrame], paper: Paper, by: int) -> Panel:
    inside, gutter = paper.inside, paper.row_gutter
    factor = (inside.height - by + gutter) / (inside.height + gutter)

    def line(y: int) -> int:
        return inside.top + by + round((y - inside.top) * factor)

    left, top, right, bottom = panel.rectangle
    # Bleed at the sides and at the bottom only, not under the title.
    low = bottom if bottom > inside.bottom else line(bottom + gutter) - gutter
    place = Rectangle(left, line(max(top, inside.top)), right, low)
    shown = crop(key_frames[panel.key_frame], place.aspect)
    return replace(panel, rectangle=place, picture=place, crop=shown)


def page_numbers(layout: PageLayout, paper: Paper, size: int) -> list[list[Label]]:
    """Return page numbers below the panels, if there are several pages and room in the margin."""
    letters = min(size, round(_MAX_NUMBER_FONT_RATIO * paper.margin))
    labels: list[list[Label]] = [[] for _ in layout.sizes]
    for page, (width, height) in enumerate(layout.sizes if len(layout.sizes) > 1 and letters >= 5 else ()):
        if all(each.page != page or each.rectangle.bottom < height for each in layout.panels):
            foot = height - paper.margin / 2 + 0.35 * letters
            labels[page].append(Label(str(page + 1), width / 2, foot, letters))
    return labels
