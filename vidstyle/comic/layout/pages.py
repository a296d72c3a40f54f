"""Layout of panels on pages of a given size, and its variation by a seed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.comic.layout.cost import LayoutWeights, panel_costs, perturbed_weights, wanted_areas
from vidstyle.comic.layout.pagination import Pagination, Row
from vidstyle.comic.layout.paper import Paper, Rectangle
from vidstyle.comic.layout.slicing import Grid, Placement, rows
from vidstyle.comic.moment import Moment

GOOD = 0.22
GOOD_AT_ALL = 0.8
"""So much more, for each panel and for all, may the layout of a seed cost than the best one."""

_ATTEMPTS = 8
_UNITS = 12
"""Across a page: gutters of two rows either meet or are well apart."""
_COLUMNS = 4
"""In a row of an upright page."""


@dataclass(frozen=True)
class _Pages:
    """Rows and panels of all pages, and what they cost by the formula, without what a seed adds."""

    rows: list[Row]
    places: list[Placement]
    cost: float

    @property
    def shape(self) -> list[tuple[object, ...]]:
        """Which panels make a row, and how it is cut, but not where."""
        return [(row.page, row.moment, row.tree) for row in self.rows]


def lay_out_pages(
    moments: Sequence[Moment], paper: Paper, pages: int, seed: int, growth: Sequence[float]
) -> tuple[list[tuple[int, Rectangle]], float]:
    """Page and rectangle of each panel, and the cost of it all by the formula.

    A seed has a few tastes; its layout is the first that is good and has other rows than the best layout, or
    is at least another one.
    """
    sheet = _Sheet(moments, paper, pages, growth)
    best = chosen = sheet.pages(LayoutWeights())
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

    def __init__(self, moments: Sequence[Moment], paper: Paper, pages: int, growth: Sequence[float]) -> None:
        self.grid, self._columns = _grid(paper)
        self.trees = [tree for count in range(1, self._columns + 1) for tree in rows(count)]
        self._moments, self._pages, self._growth = moments, pages, np.asarray(growth)
        self._formula = self._pagination(LayoutWeights())

    def _pagination(self, weights: LayoutWeights) -> Pagination:
        moments, grid = self._moments, self.grid
        most = min(len(moments), 2 * math.ceil(len(moments) / self._pages))
        areas = wanted_areas(moments, grid.area.width * grid.area.height, self._pages, weights) * self._growth
        panels = panel_costs(moments, areas, grid.widths(), grid.heights(), weights)
        return Pagination(panels, grid, weights, _break_costs(moments, weights), most, self._columns)

    def pages(self, weights: LayoutWeights) -> _Pages:
        """The best pages by these weights."""
        pagination = self._pagination(weights) if weights.perturbation else self._formula
        found = pagination.pages(self._pages)
        places = [place for row in found for place in pagination.places(row)]
        return _Pages(found, places, self._formula.cost(found, places))


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
