"""The pages with the lowest cost of all rows, splits and page breaks, and their variations by seed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.cost import panel_costs, wanted_areas
from vidstyle.comic.layout.pagination import Pagination, Row
from vidstyle.comic.layout.paper import MM_PER_INCH, Paper
from vidstyle.comic.layout.slicing import Grid, Placement, list_rows
from vidstyle.comic.layout.stack_gutters import widen_stack_gutters
from vidstyle.comic.layout.weights import LayoutWeights, perturb_weights
from vidstyle.regions.boxes import Rectangle

BEST_PANELS_PER_PAGE = 6.5
"""Number of panels per page that the default number of pages aims at."""
_GRID_COLUMN_UNITS = 12
"""Grid units across a page: few, so that gutters of two rows either meet or are well apart."""
_MAX_PORTRAIT_COLUMNS = 4
"""Maximum number of columns in a row of a portrait page."""
_MIN_PRINTED_FACE_MM = 15.0
"""Height of a face on paper below which styles lose its features: 90 lines at 150 dots per inch."""

# Variations by seed.
MAX_EXTRA_COST_PER_PANEL, MAX_EXTRA_COST = 0.3, 1.2
"""Maximum cost of a seed's layout above the best one's: the sum of a part per panel and a constant."""
_MAX_SEED_ATTEMPTS = 8
"""Maximum number of perturbations tried for a seed."""
_BALANCE_SEED = 2**32
"""Seed of the layouts that are tried for better balance; no user gives it."""
_MIN_LIGHT_DEVIATION = 0.05
"""Standard deviation of the light of key frames below which any page is balanced."""


def default_pages(panels: int) -> int:
    """Return the default number of pages for a number of panels.

    >>> [default_pages(panels) for panels in (1, 9, 10, 40)]
    [1, 1, 2, 6]
    """
    fewer = max(1, math.floor(panels / BEST_PANELS_PER_PAGE))
    return min(fewer, fewer + 1, key=lambda pages: abs(math.log(panels / pages / BEST_PANELS_PER_PAGE)))


@dataclass(frozen=True)
class _Pages:
    """Rows and panels of all pages, and their cost without a seed's perturbation."""

    rows: list[Row]
    places: list[Placement]
    cost: float

    @property
    def shape(self) -> list[tuple[object, ...]]:
        """Which panels form each row, and the tree of its splits without their positions."""
        return [(row.page, row.first_panel, row.tree) for row in self.rows]


def place_pages(
    key_frames: Sequence[KeyFrame], paper: Paper, pages: int, seed: int, area_scales: Sequence[float]
) -> tuple[list[tuple[int, Rectangle]], float]:
    """Return page and rectangle of each panel, and the cost of the layout without perturbation.

    Some perturbations are tried for better balanced pages. A seed perturbs the weights several times; its
    layout is the first good one whose rows differ from the rows of the best layout, or else a good one with
    different panels.
    """
    sheet = _Sheet(key_frames, paper, pages, area_scales)
    is_even = float(np.std([key_frame.light for key_frame in key_frames])) < _MIN_LIGHT_DEVIATION
    attempts = range(1, 1 if is_even else 4)
    others = (perturb_weights(_BALANCE_SEED, number, len(key_frames), sheet.trees) for number in attempts)
    first = [sheet.pages(weights) for weights in (LayoutWeights(), *others)]
    best = chosen = min(first, key=lambda pages: pages.cost)
    for attempt in range(_MAX_SEED_ATTEMPTS if seed else 0):
        tried = sheet.pages(perturb_weights(seed, attempt, len(key_frames), sheet.trees))
        good = tried.cost <= best.cost + MAX_EXTRA_COST + MAX_EXTRA_COST_PER_PANEL * len(key_frames)
        if good and (tried.shape != best.shape or chosen is best and tried.places != best.places):
            chosen = tried
        if chosen.shape != best.shape:
            break
    placed = [(place.page, sheet.grid.rectangle(place)) for place in chosen.places]
    return widen_stack_gutters(placed, paper), chosen.cost


class _Sheet:
    """Finds the best pages for given weights, and their cost by the unperturbed weights."""

    def __init__(
        self, key_frames: Sequence[KeyFrame], paper: Paper, pages: int, area_scales: Sequence[float]
    ) -> None:
        self.grid, self._columns = _page_grid(paper)
        self.trees = [tree for count in range(1, self._columns + 1) for tree in list_rows(count)]
        self._key_frames, self._pages, self._area_scales = key_frames, pages, np.asarray(area_scales)
        self._face_px = _MIN_PRINTED_FACE_MM * paper.dpi / MM_PER_INCH
        self._formula = self._pagination(LayoutWeights())

    def _pagination(self, weights: LayoutWeights) -> Pagination:
        key_frames, grid = self._key_frames, self.grid
        weights = replace(weights, face_px=self._face_px)
        most = min(len(key_frames), 2 * math.ceil(len(key_frames) / self._pages))
        areas = wanted_areas(key_frames, grid.area.width * grid.area.height, self._pages, weights)
        panels = panel_costs(key_frames, areas * self._area_scales, grid.widths(), grid.heights(), weights)
        return Pagination(panels, grid, weights, _break_costs(key_frames, weights), most, self._columns)

    def pages(self, weights: LayoutWeights) -> _Pages:
        """Return the best pages for these weights."""
        pagination = self._pagination(weights) if weights.perturbation else self._formula
        found = pagination.pages(self._pages)
        places = [place for row in found for place in pagination.places(row)]
        cost = self._formula.cost(found, places) + self._imbalance(places)
        return _Pages(found, places, cost)

    def _imbalance(self, places: Sequence[Placement]) -> float:
        """Return the cost of pages whose dark panels are on one side."""
        cost = 0.0
        for page in range(self._pages):
            panels = [
                (self._key_frames[each.panel], self.grid.rectangle(each))
                for each in places
                if each.page == page
            ]
            area = self.grid.area
            ink = np.array([(1 - key_frame.light) * place.area for key_frame, place in panels])
            aside = np.array([np.subtract(place.center, area.center) for _, place in panels])
            aside = aside / (area.width, area.height)
            cost += LayoutWeights.balance * float(np.hypot(*(ink @ aside))) / max(float(ink.sum()), 1e-6)
        return cost


def _break_costs(key_frames: Sequence[KeyFrame], weights: LayoutWeights) -> list[float]:
    """Return the cost of a page break before each key frame: less between scenes."""
    pairs = zip(key_frames, key_frames[1:], strict=False)
    return [0.0, *(weights.scene * (before.scene == after.scene) for before, after in pairs), 0.0]


def _page_grid(paper: Paper) -> tuple[Grid, int]:
    """Return the grid of a page, and the maximum number of columns in a row: a wide page has more."""
    wide = paper.width / paper.height
    columns = min(8, max(_MAX_PORTRAIT_COLUMNS, math.ceil(1.2 * wide) + 1))
    units = _GRID_COLUMN_UNITS if columns == _MAX_PORTRAIT_COLUMNS else 4 * columns
    high = min(48, max(20, round(2 * _GRID_COLUMN_UNITS / wide)))
    return Grid(paper.inside, units, high, paper.gutter, paper.row_gutter), columns
