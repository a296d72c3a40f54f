"""Row and page breaks by dynamic programming, after Knuth and Plass (1981)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vidstyle.comic.layout.slicing import SINGLE_PANEL, Grid, Placement, Tables, Tree, list_rows
from vidstyle.comic.layout.weights import LayoutWeights

_HEIGHT_CLASS_COUNT = 10
"""Number of height classes of rows of one panel; the last class is half a page or more."""


@dataclass(frozen=True)
class Row:
    """A row of a page.

    Attributes:
        first_panel: index of its first panel.
        tree: its panels.
        split: end of its first column, in units; 0 for a single column.
        high: height in units.
        page, row: its page, and its top in units.
    """

    first_panel: int
    tree: Tree
    split: int
    high: int
    page: int = 0
    row: int = 0


class Pagination:
    """The best rows and pages for panels of known costs.

    Pages are filled: the heights of a page's rows add up to its units. For each first panel of a page,
    each end, each height filled so far and each type of the last row, the lowest cost is computed from the
    costs with one row less; then the best page breaks from the costs of all possible pages.

    Args:
        panels: the cost of each panel by its size, see `cost.panel_costs`.
        grid: of a page.
        weights: of the cost.
        break_costs: the cost of a page break before each panel, and after the last.
        most: maximum number of panels on a page.
        columns: maximum number of columns in a row.
    """

    def __init__(
        self,
        panels: np.ndarray,
        grid: Grid,
        weights: LayoutWeights,
        break_costs: list[float],
        most: int,
        columns: int,
    ) -> None:
        self.grid, self.tables = grid, Tables(panels)
        self._count, self._most, self._units, self._high = len(panels), most, grid.columns, grid.rows
        self._weights, self._break_costs = weights, break_costs
        self._row_types = RowTypes(columns, grid.columns, grid.rows)
        self._after = self._row_types.costs(weights)
        counts = range(1, min(columns, len(panels)) + 1)
        self._rows = {count: self._best_rows(count) for count in counts}
        self._filled = self._fill()

    def _best_rows(self, count: int) -> np.ndarray:
        """Return the lowest cost of a row of `count` panels: first panel x type x units high."""
        starts = self._count - count + 1
        best = np.full((starts, len(self._after), self._high + 1), np.inf)
        for tree in list_rows(count):
            price = self._weights.template(tree, starts)
            if count > 1:
                first = self._row_types.of(tree.columns, 1, 0)
                row_types = best[:, first : first + self._units - 1]
                np.minimum(row_types, self.tables.by_split(tree) + price[:, None, None], out=row_types)
                continue
            for high in range(1, self._high + 1):
                row_type = self._row_types.of(1, 0, high)
                best[:, row_type, high] = self.tables.of(SINGLE_PANEL)[:, -1, high] + price
        return best

    def _fill(self) -> list[np.ndarray]:
        """Return the lowest costs of incomplete pages for each number of preceding panels.

        Each array is panels on the page x units filled x type of the last row.
        """
        sizes = (self._most + 1, self._high + 1, len(self._after))
        filled = [np.full(sizes, np.inf) for _ in range(self._count + 1)]
        for first_panel in range(self._count):
            # A page contains at most the panels before this one.
            page_counts = min(first_panel, self._most) + 1
            entry = self._entry(filled[first_panel][:page_counts])
            for count, best in self._rows.items():
                if first_panel + count > self._count or count > self._most:
                    continue
                row_types = self._row_types.of_rows(count)
                reached = filled[first_panel + count][count : count + page_counts, :, row_types]
                usual = entry[: len(reached), :, row_types]
                for high in range(1, self._high + 1):
                    cost = usual[:, : self._high + 1 - high] + best[first_panel, row_types, high]
                    np.minimum(reached[:, high:], cost, out=reached[:, high:])
        return filled

    def _entry(self, filled: np.ndarray) -> np.ndarray:
        """Return the lowest cost before a row of each type: panels on the page x units filled x type."""
        by_type = np.ascontiguousarray(filled.reshape(-1, len(self._after)).T)
        least = [(by_type + after[:, np.newaxis]).min(axis=0) for after in self._after.T]
        entry = np.stack(least, axis=1).reshape(filled.shape)
        entry[0, 0] = 0.0
        return entry

    def pages(self, count: int) -> list[Row]:
        """Return the rows of the best `count` pages."""
        breaks = self._breaks(count)
        pages = enumerate(pairwise(breaks))
        return [row for page, (start, end) in pages for row in self._rows_of(page, start, end)]

    def _breaks(self, count: int) -> list[int]:
        """Return the first panel of each page, and the number of panels."""
        best = np.full((count + 1, self._count + 1), np.inf)
        begun = np.zeros((count + 1, self._count + 1), int)
        best[0, 0] = 0.0
        for page in range(1, count + 1):
            for end in range(page, self._count + 1):
                starts = np.arange(max(0, end - self._most), end)
                cost = best[page - 1, starts] + self._filled[end][end - starts, self._high].min(axis=1)
                begun[page, end] = starts[cost.argmin()]
                best[page, end] = cost.min() + self._break_costs[end]
        breaks = [self._count]
        for page in range(count, 0, -1):
            breaks.append(int(begun[page, breaks[-1]]))
        return breaks[::-1]

    def _rows_of(self, page: int, start: int, end: int) -> list[Row]:
        """Return the rows of a page, traced back from its end."""
        found, high = [], self._high
        row_type = int(self._filled[end][end - start, high].argmin())
        while end > start:
            row, row_type = self._last_row(page, start, end, high, row_type)
            found.append(row)
            end, high = row.first_panel, row.row
        return found[::-1]

    def _last_row(self, page: int, start: int, end: int, high: int, row_type: int) -> tuple[Row, int]:
        """Return the row of a type that ends at a panel and a height, and the type of the row before it."""
        choices = []
        for count, best in self._rows.items():
            first_panel = end - count
            if first_panel < start:
                continue
            before = self._filled[first_panel][first_panel - start, :high] + self._after[:, row_type]
            entry = before.min(axis=1)
            if first_panel == start:
                entry[0] = 0.0
            cost = entry + best[first_panel, row_type, high:0:-1]
            top = int(cost.argmin())
            choices.append((float(cost[top]), count, top, int(before[top].argmin())))
        _, count, top, last = min(choices)
        first_panel = end - count
        tree, split = self._tree(first_panel, count, row_type, high - top)
        return Row(first_panel, tree, split, high - top, page, top), last

    def _tree(self, first_panel: int, count: int, row_type: int, high: int) -> tuple[Tree, int]:
        """Return the best tree of a row of a type, and its split."""
        columns, split = self._row_types.split_of(row_type)
        if columns == 1:
            return SINGLE_PANEL, 0
        trees = [tree for tree in list_rows(count) if tree.columns == columns]
        costs = [
            self.tables.by_split(tree)[first_panel, split - 1, high]
            + self._weights.template(tree, first_panel + 1)[-1]
            for tree in trees
        ]
        return trees[int(np.argmin(costs))], split

    def places(self, row: Row) -> Iterator[Placement]:
        """Yield the placements of a row's panels."""
        whole = Placement(row.first_panel, row.page, 0, row.row, self._units, row.high)
        return self.tables.places(row.tree, whole, row.split or None)

    def cost(self, found: list[Row], places: list[Placement]) -> float:
        """Return the cost of pages by these weights."""
        panels = self.tables.of(SINGLE_PANEL)
        cost = sum(float(panels[place.panel, place.wide, place.high]) for place in places)
        cost += sum(float(self._weights.template(row.tree, row.first_panel + 1)[-1]) for row in found)
        row_types = [self._row_types.of(row.tree.columns, row.split, row.high) for row in found]
        for row, other, row_type, next_type in zip(found, found[1:], row_types, row_types[1:], strict=False):
            turned = other.page > row.page
            cost += (
                self._break_costs[other.first_panel] if turned else float(self._after[row_type, next_type])
            )
        return cost


@dataclass(frozen=True)
class RowTypes:
    """Types of rows on a grid: rows of one panel by height, others by number of columns and first split.

    Attributes:
        columns: maximum number of columns in a row.
        wide, high: units of the grid.
    """

    columns: int
    wide: int
    high: int

    def __len__(self) -> int:
        return self.of(self.columns, self.wide - 1, 0) + 1

    def of(self, columns: int, split: int, high: int) -> int:
        """Return the number of the type of a row.

        Args:
            columns: number of columns.
            split: end of the first column; ignored for a single one.
            high: units; ignored for several columns.
        """
        if columns == 1:
            return min(_HEIGHT_CLASS_COUNT - 1, high * 2 * _HEIGHT_CLASS_COUNT // (self.high + 1))
        return _HEIGHT_CLASS_COUNT + (columns - 2) * (self.wide - 1) + split - 1

    def of_rows(self, count: int) -> slice:
        """Return all types that rows of `count` panels may have."""
        if count == 1:
            return slice(_HEIGHT_CLASS_COUNT)
        return slice(_HEIGHT_CLASS_COUNT, self.of(min(count, self.columns), self.wide - 1, 0) + 1)

    def split_of(self, row_type: int) -> tuple[int, int]:
        """Return the columns and the first split of a type; 1 and 0 for a row of one panel."""
        if row_type < _HEIGHT_CLASS_COUNT:
            return 1, 0
        columns, split = divmod(row_type - _HEIGHT_CLASS_COUNT, self.wide - 1)
        return columns + 2, split + 1

    def costs(self, weights: LayoutWeights) -> np.ndarray:
        """Return the cost of neighbouring rows: type of the row before x type of the row."""
        row_types = np.arange(len(self))
        columns, split = np.array([self.split_of(row_type) for row_type in range(len(self))]).T
        full, several = (columns[:, None] == 1) & (columns == 1), (columns[:, None] > 1) & (columns > 1)
        apart = np.abs(split[:, None] - split)
        near = 1 - np.minimum(1, apart * 3 / self.wide)
        alike = (1 + near) / 2 * (columns[:, None] == columns) * several
        heights = 1 - np.minimum(1, np.abs(row_types[:, None] - row_types) * 4 / _HEIGHT_CLASS_COUNT)
        cost = weights.monotony * alike + weights.full * full * (1 + heights) / 2
        return cost + several * (weights.cross * (apart == 0) + weights.ragged * (apart == 1))
