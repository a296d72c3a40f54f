"""Page layout: the panels' rectangles that minimize a stated cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from vidstyle.comic.layout.crop import crop
from vidstyle.comic.layout.pages import lay_out_pages
from vidstyle.comic.layout.paper import Paper, Rectangle
from vidstyle.comic.layout.strip import lay_out_strip
from vidstyle.comic.moment import Box, Moment
from vidstyle.errors import UsageError

PANELS_PER_PAGE = 6.5
"""Panels that a page holds best."""


@dataclass(frozen=True)
class Panel:
    """A moment on its page.

    Attributes:
        moment: its number, from 0.
        page: from 0.
        rectangle: on the page, with the border; a bleeding one goes on beyond the page by `Paper.bleed`.
        crop: the part of the moment's picture that fills it, in pixels; of the rectangle's aspect.
    """

    moment: int
    page: int
    rectangle: Rectangle
    crop: Box


@dataclass(frozen=True)
class PageLayout:
    """All pages.

    Attributes:
        panels: in reading order, which is that of time.
        sizes: width and height of each page, in pixels.
        cost: what `LayoutWeights` says of it; that of seed 0 is the least there is.
    """

    panels: tuple[Panel, ...]
    sizes: tuple[tuple[int, int], ...]
    cost: float


def lay_out(
    moments: Sequence[Moment],
    paper: Paper,
    *,
    pages: int | None = None,
    seed: int = 0,
    right_to_left: bool = False,
    bleeding: bool = False,
    growth: Sequence[float] | None = None,
) -> PageLayout:
    """Lay out moments as comic pages, or as one strip.

    Rows fill the width and pages the height; of all rows that `slicing.rows` allows, all cuts on the page's
    grid and all breaks of rows and pages, those are taken that cost least, see `LayoutWeights`.

    Args:
        moments: in the order of time.
        pages: number of pages; None: depends on the number of moments. A strip has one.
        seed: 0 gives the best layout, other seeds give different good ones; the same seed the same.
        right_to_left: right-to-left reading order.
        bleeding: whether full-width panels extend to the page edge.
        growth: factor on the area of each panel, for its text.

    Raises:
        UsageError: there are no moments, or fewer than pages.
    """
    if not moments:
        raise UsageError("comic", "there is no moment to show", "give a film with at least one picture")
    if pages is not None and not 1 <= pages <= len(moments):
        raise UsageError("pages", f"{pages} for {len(moments)} panels", "each page holds at least one")
    growth = [1.0] * len(moments) if growth is None else growth
    if paper.is_strip:
        height, places, cost = lay_out_strip(moments, paper, seed, growth)
        sizes, placed = [(paper.width, height)], [(0, rectangle) for rectangle in places]
    else:
        number = pages or pages_for(len(moments))
        sizes = [(paper.width, paper.height)] * number
        placed, cost = lay_out_pages(moments, paper, number, seed, growth)
    if bleeding:
        placed = [(page, _bled(rectangle, paper, sizes[page][1])) for page, rectangle in placed]
    if right_to_left:
        placed = [(page, _mirrored(rectangle, paper.width)) for page, rectangle in placed]
    panels = tuple(
        Panel(number, page, rectangle, crop(moments[number], rectangle.aspect))
        for number, (page, rectangle) in enumerate(placed)
    )
    return PageLayout(panels, tuple(sizes), cost)


def pages_for(panels: int) -> int:
    """How many pages suit a number of panels.

    >>> [pages_for(panels) for panels in (1, 9, 10, 40)]
    [1, 1, 2, 6]
    """
    fewer = max(1, math.floor(panels / PANELS_PER_PAGE))
    return min(fewer, fewer + 1, key=lambda pages: abs(math.log(panels / pages / PANELS_PER_PAGE)))


def _bled(rectangle: Rectangle, paper: Paper, height: int) -> Rectangle:
    """A full-width panel extended beyond the page edges; any other as it is."""
    inside, beyond = paper.inside, paper.bleed
    if (rectangle.left, rectangle.right) != (inside.left, inside.right):
        return rectangle
    top, bottom = rectangle.top, rectangle.bottom
    return Rectangle(
        -beyond,
        -beyond if top == inside.top else top,
        paper.width + beyond,
        height + beyond if bottom == height - paper.margin else bottom,
    )


def _mirrored(rectangle: Rectangle, width: int) -> Rectangle:
    return rectangle._replace(left=width - rectangle.right, right=width - rectangle.left)
