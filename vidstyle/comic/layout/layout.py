"""Page layout: the rectangles of the panels that minimize a cost function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import crop
from vidstyle.comic.layout.grid import place_grid
from vidstyle.comic.layout.inset import INSET_PANEL_AREA_FACTOR, place_inset
from vidstyle.comic.layout.pages import default_pages, place_pages
from vidstyle.comic.layout.paper import SLANTED_LAYOUTS, LayoutKind, Paper
from vidstyle.comic.layout.slant import Leans, slant_gutters, upright_area
from vidstyle.comic.layout.strip import lay_out_strip
from vidstyle.comic.lettering.bubble import Bubble
from vidstyle.errors import UsageError
from vidstyle.regions.boxes import Box, Rectangle


@dataclass(frozen=True)
class Panel:
    """A panel on its page.

    Attributes:
        key_frame: index of the key frame that it shows.
        page: index of the page.
        rectangle: including the border.
        picture: rectangle of its picture: within the border and below bands of text.
        crop: the window of the key frame's picture that it shows, in pixels, with the aspect of `picture`.
        bubbles: its text, in reading order.
        leans: see `slant`; `rectangle` and `picture` are bounding boxes if it is slanted.
        insets: the panels in front of its picture.
    """

    key_frame: int
    page: int
    rectangle: Rectangle
    picture: Rectangle
    crop: Box
    bubbles: tuple[Bubble, ...] = ()
    leans: Leans = (0, 0)
    insets: tuple[Rectangle, ...] = ()


@dataclass(frozen=True)
class PageLayout:
    """The layout of all pages.

    Attributes:
        panels: in reading order, which is chronological.
        sizes: width and height of each page in pixels.
        cost: see `LayoutWeights`; seed 0 has the lowest.
    """

    panels: tuple[Panel, ...]
    sizes: tuple[tuple[int, int], ...]
    cost: float


def lay_out(
    key_frames: Sequence[KeyFrame],
    paper: Paper,
    *,
    pages: int | None = None,
    seed: int = 0,
    right_to_left: bool = False,
    bleeding: bool = False,
    kind: LayoutKind = "classic",
    area_scales: Sequence[float] | None = None,
    insets: Sequence[int] = (),
) -> PageLayout:
    """Lay out key frames as comic pages, or as one strip.

    Rows fill the width and pages the height. The layout has the lowest cost (see `LayoutWeights`) of all
    combinations of rows that `slicing.list_rows` allows, splits on the page's grid, and row and page breaks.

    Args:
        key_frames: in the order of time.
        paper: of each page.
        pages: number of pages; None: depends on the number of key frames. A strip has one.
        seed: random seed: 0 gives the best layout, other seeds give different good ones.
        right_to_left: right-to-left reading order.
        bleeding: whether full-width panels extend to the page edge.
        kind: "grid" is a regular grid without variations; all except it and "classic" have slanted gutters.
        area_scales: factor on the area of each panel, for its text.
        insets: indices of key frames to be shown over a calm corner of the panel before, if there is one.
            A strip and a grid have no insets.

    Raises:
        UsageError: there are no key frames, or fewer than pages.
    """
    if not key_frames:
        raise UsageError("comic", "has no key frame to show", "give a film with at least one picture")
    if pages is not None and not 1 <= pages <= len(key_frames):
        reason = f"{pages} are too many for {len(key_frames)} panels"
        raise UsageError("--pages", reason, "each page needs at least one")
    area_scales = [1.0] * len(key_frames) if area_scales is None else area_scales
    if insets and not paper.is_strip and kind != "grid":
        usual = [number for number in range(len(key_frames)) if number not in insets]
        below = [
            area_scales[each] * (INSET_PANEL_AREA_FACTOR if each + 1 in insets else 1.0) for each in usual
        ]
        layout = lay_out(
            [key_frames[each] for each in usual],
            paper,
            pages=min(pages, len(usual)) if pages else pages,
            seed=seed,
            right_to_left=right_to_left,
            bleeding=bleeding,
            kind=kind,
            area_scales=below,
        )
        numbered = [replace(each, key_frame=usual[each.key_frame]) for each in layout.panels]
        if found := _add_insets(numbered, key_frames, paper, insets, right_to_left):
            return replace(layout, panels=tuple(found))
    sizes, placed, cost = _place(key_frames, paper, pages, seed, kind, area_scales)
    if bleeding:
        placed = [(page, _extend_to_edges(rectangle, paper, sizes[page][1])) for page, rectangle in placed]
    if right_to_left:
        placed = [(page, rectangle.mirrored(paper.width)) for page, rectangle in placed]
    if kind in SLANTED_LAYOUTS:
        leaning = slant_gutters(placed, paper, seed)
    else:
        leaning = [(page, rectangle, (0, 0)) for page, rectangle in placed]
    panels = tuple(
        Panel(number, page, rectangle, rectangle, crop(key_frames[number], rectangle.aspect), leans=leans)
        for number, (page, rectangle, leans) in enumerate(leaning)
    )
    return PageLayout(panels, tuple(sizes), cost)


def _place(
    key_frames: Sequence[KeyFrame],
    paper: Paper,
    pages: int | None,
    seed: int,
    kind: LayoutKind,
    area_scales: Sequence[float],
) -> tuple[list[tuple[int, int]], list[tuple[int, Rectangle]], float]:
    """Return the sizes of the pages, page and rectangle of each panel, and the cost."""
    if paper.is_strip:
        height, places, cost = lay_out_strip(key_frames, paper, seed, area_scales)
        return [(paper.width, height)], [(0, rectangle) for rectangle in places], cost
    number = pages or default_pages(len(key_frames))
    sizes = [(paper.width, paper.height)] * number
    if kind == "grid":
        return sizes, place_grid(len(key_frames), number, paper), 0.0
    return sizes, *place_pages(key_frames, paper, number, seed, area_scales)


def _add_insets(
    panels: Sequence[Panel],
    key_frames: Sequence[KeyFrame],
    paper: Paper,
    insets: Sequence[int],
    right_to_left: bool,
) -> list[Panel] | None:
    """Return the panels, each followed by its inset; None if an inset has no calm corner."""
    found = list[Panel]()
    for each in panels:
        number = each.key_frame + 1
        if number not in insets:
            found.append(each)
            continue
        clear = upright_area(each.rectangle, each.leans)
        shown = key_frames[number], key_frames[each.key_frame]
        place = place_inset(*shown, each.crop, each.rectangle, clear, paper.width, right_to_left)
        if place is None:
            return None
        found.append(replace(each, insets=(place,)))
        found.append(Panel(number, each.page, place, place, crop(key_frames[number], place.aspect)))
    return found


def _extend_to_edges(rectangle: Rectangle, paper: Paper, height: int) -> Rectangle:
    """Extend a full-width panel to the page edges; return any other panel unchanged."""
    inside = paper.inside
    if (rectangle.left, rectangle.right) != (inside.left, inside.right):
        return rectangle
    top = 0 if rectangle.top == inside.top else rectangle.top
    bottom = height if rectangle.bottom == height - paper.margin else rectangle.bottom
    return Rectangle(0, top, paper.width, bottom)
