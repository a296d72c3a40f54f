"""Page layout: the panels' rectangles that minimize a stated cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.comic.layout.cost import LayoutWeights, panel_costs, perturbed_weights, wanted_areas
from vidstyle.comic.layout.crop import crop
from vidstyle.comic.layout.grid import grid_places
from vidstyle.comic.layout.inset import GROWTH, inset_place
from vidstyle.comic.layout.pagination import Pagination, Row
from vidstyle.comic.layout.paper import SLANTED, LayoutKind, Paper
from vidstyle.comic.layout.slant import Leans, between_leans, slanted
from vidstyle.comic.layout.slicing import Grid, Placement, rows
from vidstyle.comic.layout.strip import lay_out_strip
from vidstyle.comic.lettering.bubble import Bubble
from vidstyle.comic.moment import Box, Moment, Rectangle
from vidstyle.errors import UsageError

PANELS_PER_PAGE = 6.5
"""Best number of panels on a page."""
GOOD = 0.22
GOOD_AT_ALL = 0.8
"""Maximum cost of a seed's layout above that of the best one: per panel, and relative."""

_ATTEMPTS = 8
_TRIED = 2**32
"""Seed of the layouts that are tried for seed 0, which no user gives."""
_EVEN_LIGHT = 0.05
"""Deviation of the light of moments below which any page is balanced."""
_UNITS = 12
"""Grid units across a page: few, so that gutters of two rows either meet or are well apart."""
_COLUMNS = 4
"""Maximum number of columns in a row of a portrait page."""


@dataclass(frozen=True)
class Panel:
    """A panel on its page.

    Attributes:
        moment: index of the moment that it shows.
        page: index of the page.
        rectangle: including the border.
        picture: place of its picture: in the rectangle, within the border and below bands of text.
        crop: the window of the moment's picture that it shows, in pixels, with the aspect of `picture`.
        bubbles: its text, in reading order.
        leans: see `slant`; `rectangle` and `picture` are bounding boxes then.
        insets: the panels over it, which stand in front of its picture.
    """

    moment: int
    page: int
    rectangle: Rectangle
    picture: Rectangle
    crop: Box
    bubbles: tuple[Bubble, ...] = ()
    leans: Leans = (0, 0)
    insets: tuple[Rectangle, ...] = ()


@dataclass(frozen=True)
class PageLayout:
    """All pages.

    Attributes:
        panels: in reading order, which is chronological.
        sizes: width and height of each page in pixels.
        cost: see `LayoutWeights`; seed 0 has the lowest.
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
    kind: LayoutKind = "classic",
    area_scales: Sequence[float] | None = None,
    insets: Sequence[int] = (),
) -> PageLayout:
    """Lay out moments as comic pages, or as one strip.

    Rows fill the width and pages the height. The layout has the lowest cost (see `LayoutWeights`) of all
    combinations of rows that `slicing.rows` allows, splits on the page's grid, row breaks and page breaks.

    Args:
        moments: in the order of time.
        pages: number of pages; None: depends on the number of moments. A strip has one.
        seed: 0 gives the best layout, other seeds give different good ones; the same seed the same.
        right_to_left: right-to-left reading order.
        bleeding: whether full-width panels extend to the page edge.
        kind: "grid" is a regular grid, which no seed varies; all but it and "classic" have slanted gutters.
        area_scales: factor on the area of each panel, for its text.
        insets: numbers of moments to be shown over a corner of the panel before, where one is calm. A strip
            and a grid have none.

    Raises:
        UsageError: there are no moments, or fewer than pages.
    """
    if not moments:
        raise UsageError("comic", "there is no moment to show", "give a film with at least one picture")
    if pages is not None and not 1 <= pages <= len(moments):
        reason = f"{pages} are too many for {len(moments)} panels"
        raise UsageError("--pages", reason, "each page holds at least one")
    area_scales = [1.0] * len(moments) if area_scales is None else area_scales
    if insets and not paper.is_strip and kind != "grid":
        usual = [number for number in range(len(moments)) if number not in insets]
        below = [area_scales[each] * (GROWTH if each + 1 in insets else 1.0) for each in usual]
        most = min(pages, len(usual)) if pages else pages
        layout = lay_out(
            *([moments[each] for each in usual], paper),
            pages=most,
            seed=seed,
            right_to_left=right_to_left,
            bleeding=bleeding,
            kind=kind,
            area_scales=below,
        )
        numbered = [replace(each, moment=usual[each.moment]) for each in layout.panels]
        if found := _with_insets(numbered, moments, paper, insets, right_to_left):
            return replace(layout, panels=tuple(found))
    if paper.is_strip:
        height, places, cost = lay_out_strip(moments, paper, seed, area_scales)
        sizes, placed = [(paper.width, height)], [(0, rectangle) for rectangle in places]
    else:
        number = pages or pages_for(len(moments))
        sizes = [(paper.width, paper.height)] * number
        if kind == "grid":
            placed, cost = grid_places(len(moments), number, paper), 0.0
        else:
            placed, cost = _lay_out_pages(moments, paper, number, seed, area_scales)
    if bleeding:
        placed = [(page, _bled(rectangle, paper, sizes[page][1])) for page, rectangle in placed]
    if right_to_left:
        placed = [(page, rectangle.mirrored(paper.width)) for page, rectangle in placed]
    if kind in SLANTED:
        leaning = slanted(placed, paper, seed)
    else:
        leaning = [(page, rectangle, (0, 0)) for page, rectangle in placed]
    panels = tuple(
        Panel(number, page, rectangle, rectangle, crop(moments[number], rectangle.aspect), leans=leans)
        for number, (page, rectangle, leans) in enumerate(leaning)
    )
    return PageLayout(panels, tuple(sizes), cost)


def _with_insets(
    panels: Sequence[Panel],
    moments: Sequence[Moment],
    paper: Paper,
    insets: Sequence[int],
    right_to_left: bool,
) -> list[Panel] | None:
    """The panels, each followed by its inset; None if one has no calm corner."""
    found = list[Panel]()
    for each in panels:
        number = each.moment + 1
        if number not in insets:
            found.append(each)
            continue
        clear = between_leans(each.rectangle, each.leans)
        shown = moments[number], moments[each.moment]
        place = inset_place(*shown, each.crop, each.rectangle, clear, paper.width, right_to_left)
        if place is None:
            return None
        found.append(replace(each, insets=(place,)))
        found.append(Panel(number, each.page, place, place, crop(moments[number], place.aspect)))
    return found


def pages_for(panels: int) -> int:
    """How many pages suit a number of panels.

    >>> [pages_for(panels) for panels in (1, 9, 10, 40)]
    [1, 1, 2, 6]
    """
    fewer = max(1, math.floor(panels / PANELS_PER_PAGE))
    return min(fewer, fewer + 1, key=lambda pages: abs(math.log(panels / pages / PANELS_PER_PAGE)))


def _bled(rectangle: Rectangle, paper: Paper, height: int) -> Rectangle:
    """A full-width panel extended to the page edges; any other as it is."""
    inside = paper.inside
    if (rectangle.left, rectangle.right) != (inside.left, inside.right):
        return rectangle
    top = 0 if rectangle.top == inside.top else rectangle.top
    bottom = height if rectangle.bottom == height - paper.margin else rectangle.bottom
    return Rectangle(0, top, paper.width, bottom)


@dataclass(frozen=True)
class _Pages:
    """Rows and panels of all pages, and their cost without a seed's perturbation."""

    rows: list[Row]
    places: list[Placement]
    cost: float

    @property
    def shape(self) -> list[tuple[object, ...]]:
        """Which panels form each row, and the tree of its splits without their positions."""
        return [(row.page, row.moment, row.tree) for row in self.rows]


def _lay_out_pages(
    moments: Sequence[Moment], paper: Paper, pages: int, seed: int, area_scales: Sequence[float]
) -> tuple[list[tuple[int, Rectangle]], float]:
    """Page and rectangle of each panel, and the cost of the layout without perturbation.

    Some perturbations are tried for better balanced pages. A seed perturbs the weights a few times; its
    layout is the first good one whose rows differ from those of the best layout, or at least one with other
    panels.
    """
    sheet = _Sheet(moments, paper, pages, area_scales)
    is_even = float(np.std([moment.light for moment in moments])) < _EVEN_LIGHT
    attempts = range(1, 1 if is_even else 4)
    others = (perturbed_weights(_TRIED, number, len(moments), sheet.trees) for number in attempts)
    first = [sheet.pages(weights) for weights in (LayoutWeights(), *others)]
    best = chosen = min(first, key=lambda pages: pages.cost)
    for attempt in range(_ATTEMPTS if seed else 0):
        tried = sheet.pages(perturbed_weights(seed, attempt, len(moments), sheet.trees))
        good = tried.cost <= best.cost + GOOD_AT_ALL + GOOD * len(moments)
        if good and (tried.shape != best.shape or chosen is best and tried.places != best.places):
            chosen = tried
        if chosen.shape != best.shape:
            break
    return [(place.page, sheet.grid.rectangle(place)) for place in chosen.places], chosen.cost


class _Sheet:
    """Finds the best pages by given weights, and their cost by the unperturbed ones."""

    def __init__(
        self, moments: Sequence[Moment], paper: Paper, pages: int, area_scales: Sequence[float]
    ) -> None:
        self.grid, self._columns = _grid(paper)
        self.trees = [tree for count in range(1, self._columns + 1) for tree in rows(count)]
        self._moments, self._pages, self._area_scales = moments, pages, np.asarray(area_scales)
        self._formula = self._pagination(LayoutWeights())

    def _pagination(self, weights: LayoutWeights) -> Pagination:
        moments, grid = self._moments, self.grid
        most = min(len(moments), 2 * math.ceil(len(moments) / self._pages))
        areas = wanted_areas(moments, grid.area.width * grid.area.height, self._pages, weights)
        panels = panel_costs(moments, areas * self._area_scales, grid.widths(), grid.heights(), weights)
        return Pagination(panels, grid, weights, _break_costs(moments, weights), most, self._columns)

    def pages(self, weights: LayoutWeights) -> _Pages:
        """The best pages by these weights."""
        pagination = self._pagination(weights) if weights.perturbation else self._formula
        found = pagination.pages(self._pages)
        places = [place for row in found for place in pagination.places(row)]
        cost = self._formula.cost(found, places) + self._imbalance(places)
        return _Pages(found, places, cost)

    def _imbalance(self, places: Sequence[Placement]) -> float:
        """The cost of pages whose dark panels are on one side."""
        cost = 0.0
        for page in range(self._pages):
            panels = [
                (self._moments[each.moment], self.grid.rectangle(each))
                for each in places
                if each.page == page
            ]
            area = self.grid.area
            ink = np.array([(1 - moment.light) * place.area for moment, place in panels])
            aside = np.array([np.subtract(place.center, area.center) for _, place in panels])
            aside = aside / (area.width, area.height)
            cost += LayoutWeights.balance * float(np.hypot(*(ink @ aside))) / max(float(ink.sum()), 1e-6)
        return cost


def _break_costs(moments: Sequence[Moment], weights: LayoutWeights) -> list[float]:
    """The cost of a page break before each moment: less between scenes."""
    pairs = zip(moments, moments[1:], strict=False)
    return [0.0, *(weights.scene * (before.scene == after.scene) for before, after in pairs), 0.0]


def _grid(paper: Paper) -> tuple[Grid, int]:
    """The grid of a page, and the most columns of a row: a wide page has more."""
    wide = paper.width / paper.height
    columns = min(8, max(_COLUMNS, math.ceil(1.2 * wide) + 1))
    units = _UNITS if columns == _COLUMNS else 4 * columns
    high = min(48, max(20, round(2 * _UNITS / wide)))
    return Grid(paper.inside, units, high, paper.gutter, paper.row_gutter), columns
