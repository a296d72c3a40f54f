"""Kinds of rows, as far as a row looks like the one before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vidstyle.comic.layout.cost import LayoutWeights

_HEIGHTS = 10
"""Rows of one panel are told apart by so many heights, the last of which is half the page and more."""


@dataclass(frozen=True)
class RowTypes:
    """The kinds of rows on a grid: rows of one panel by height, others by their columns and their first cut.

    Attributes:
        columns: the most that a row has.
        wide, high: units of the grid.
    """

    columns: int
    wide: int
    high: int

    def __len__(self) -> int:
        return self.of(self.columns, self.wide - 1, 0) + 1

    def of(self, columns: int, cut: int, high: int) -> int:
        """The number of the kind of a row.

        Args:
            columns: how many it has.
            cut: where the first one ends; whatever if it is the only one.
            high: units; whatever if there are more columns.
        """
        if columns == 1:
            return min(_HEIGHTS - 1, high * 2 * _HEIGHTS // (self.high + 1))
        return _HEIGHTS + (columns - 2) * (self.wide - 1) + cut - 1

    def cut_of(self, kind: int) -> tuple[int, int]:
        """The columns and the first cut of a kind; 1 and 0 for a row of one panel."""
        if kind < _HEIGHTS:
            return 1, 0
        columns, cut = divmod(kind - _HEIGHTS, self.wide - 1)
        return columns + 2, cut + 1

    def costs(self, taste: LayoutWeights) -> np.ndarray:
        """What a row costs because of the one before it: kind of that x its own kind."""
        kinds = np.arange(len(self))
        columns, cut = np.array([self.cut_of(kind) for kind in range(len(self))]).T
        full, several = (columns[:, None] == 1) & (columns == 1), (columns[:, None] > 1) & (columns > 1)
        apart = np.abs(cut[:, None] - cut)
        near = 1 - np.minimum(1, apart * 3 / self.wide)
        alike = (1 + near) / 2 * (columns[:, None] == columns) * several
        heights = 1 - np.minimum(1, np.abs(kinds[:, None] - kinds) * 4 / _HEIGHTS)
        cost = taste.monotony * alike + taste.full * full * (1 + heights) / 2
        return cost + several * (taste.cross * (apart == 0) + taste.ragged * (apart == 1))
