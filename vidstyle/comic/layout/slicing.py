"""Rows of panels as slicing trees, and the best way to split each: on a grid, all splits are tried."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from vidstyle.regions.boxes import Rectangle


@dataclass(frozen=True)
class Tree:
    """A rectangle that is one panel, or is split in two: side by side, or one above the other.

    Attributes:
        count: number of panels, in reading order.
        first, rest: its parts; None for a panel.
        side_by_side: whether they are next to each other, not stacked.
    """

    count: int = 1
    first: Tree | None = None
    rest: Tree | None = None
    side_by_side: bool = False

    @property
    def columns(self) -> int:
        """The number of parts side by side over the whole height."""
        return 1 + self.rest.columns if self.rest and self.side_by_side else 1


SINGLE_PANEL = Tree()
MAX_STACKED_PANELS = 4
"""Maximum number of panels in a row that contains a stack."""


def join_beside(first: Tree, rest: Tree) -> Tree:
    """Join two trees side by side."""
    return Tree(first.count + rest.count, first, rest, True)


def join_over(first: Tree, rest: Tree) -> Tree:
    """Join two trees one above the other."""
    return Tree(first.count + rest.count, first, rest)


@lru_cache
def list_rows(count: int) -> tuple[Tree, ...]:
    """Return all rows of `count` panels: each column is a panel or a stack of panels.

    Stacks are not neighbours, as their reading order would be ambiguous; a stack may contain a pair side by
    side, and rows of more than `MAX_STACKED_PANELS` panels have no stacks.
    """
    if count == 1:
        return (SINGLE_PANEL,)
    return tuple(
        each for each in _columns(count, count if count > MAX_STACKED_PANELS else 0) if each.side_by_side
    )


def _columns(count: int, unstacked: int) -> Iterator[Tree]:
    """Yield columns side by side, each a panel or a stack; the first `unstacked` panels are in no stack."""
    if count == 1:
        yield SINGLE_PANEL
    else:
        yield from (join_beside(SINGLE_PANEL, rest) for rest in _columns(count - 1, max(0, unstacked - 1)))
    for high in range(2, count + 1) if not unstacked else ():
        for stack in _stacks(high):
            if high == count:
                yield stack
            else:
                yield from (join_beside(stack, rest) for rest in _columns(count - high, 1))


def _stacks(count: int) -> Iterator[Tree]:
    """Yield stacks of two or more layers, each a panel or a pair."""
    for top in (SINGLE_PANEL, join_beside(SINGLE_PANEL, SINGLE_PANEL)):
        left = count - top.count
        if left == 1:
            yield join_over(top, SINGLE_PANEL)
        elif left == 2:
            yield join_over(top, join_beside(SINGLE_PANEL, SINGLE_PANEL))
        if left >= 2:
            yield from (join_over(top, rest) for rest in _stacks(left))


@dataclass(frozen=True)
class Grid:
    """The grid of a page: splits are on evenly spaced lines, each with a gutter.

    Attributes:
        area: of all panels, in pixels.
        columns, rows: width and height in units.
        gutter, row_gutter: pixels.
    """

    area: Rectangle
    columns: int
    rows: int
    gutter: int
    row_gutter: int

    def widths(self) -> np.ndarray:
        """Return the widths in pixels of panels that are 0 to `columns` units wide; at least 1."""
        unit = (self.area.width + self.gutter) / self.columns
        return np.maximum(1.0, np.arange(self.columns + 1) * unit - self.gutter)

    def heights(self) -> np.ndarray:
        """Return the heights in pixels of panels that are 0 to `rows` units high; at least 1."""
        unit = (self.area.height + self.row_gutter) / self.rows
        return np.maximum(1.0, np.arange(self.rows + 1) * unit - self.row_gutter)

    def rectangle(self, place: Placement) -> Rectangle:
        """Return the rectangle of the panel at a place."""

        def x(unit: int) -> int:
            return self.area.left + round(unit * (self.area.width + self.gutter) / self.columns)

        def y(unit: int) -> int:
            return self.area.top + round(unit * (self.area.height + self.row_gutter) / self.rows)

        right, bottom = x(place.column + place.wide), y(place.row + place.high)
        return Rectangle(x(place.column), y(place.row), right - self.gutter, bottom - self.row_gutter)


@dataclass(frozen=True)
class Placement:
    """A panel on the grid of a page, in units; `panel` is its index."""

    panel: int
    page: int
    column: int
    row: int
    wide: int
    high: int


class Tables:
    """The lowest cost of each tree for each first panel and size, by dynamic programming.

    Args:
        panels: the cost of each panel in each size: panel x units wide x units high, starting at 0 units.
    """

    def __init__(self, panels: np.ndarray) -> None:
        self._tables = {SINGLE_PANEL: panels}

    def of(self, tree: Tree) -> np.ndarray:
        """Return the table of a tree: first panel x units wide x units high; infinite if too small."""
        if tree not in self._tables:
            assert tree.first and tree.rest
            first, rest = self.of(tree.first), self.of(tree.rest)[tree.first.count :]
            swap = (0, 1, 2) if tree.side_by_side else (0, 2, 1)
            joined = _join_costs(first.transpose(swap)[: len(rest)], rest.transpose(swap))
            self._tables[tree] = joined.transpose(swap)
        return self._tables[tree]

    def by_split(self, tree: Tree) -> np.ndarray:
        """Return the table of a full-width row for each place of its first split: 1 to its columns - 1.

        Returns:
            First panel x split x units high.
        """
        assert tree.first and tree.rest and tree.side_by_side
        rest = self.of(tree.rest)[tree.first.count :]
        return self.of(tree.first)[: len(rest), 1:-1] + rest[:, -2:0:-1]

    def places(self, tree: Tree, place: Placement, split: int | None = None) -> Iterator[Placement]:
        """Yield the placements of a tree's panels within a place; `split`: its first split, if known."""
        if tree.first is None or tree.rest is None:
            yield place
            return
        after, wide, high = place.panel + tree.first.count, place.wide, place.high
        first, rest = self.of(tree.first)[place.panel], self.of(tree.rest)[after]
        if tree.side_by_side:
            split = split or 1 + int((first[1:wide, high] + rest[wide - 1 : 0 : -1, high]).argmin())
            before = replace(place, wide=split)
            then = replace(place, panel=after, column=place.column + split, wide=wide - split)
        else:
            split = 1 + int((first[wide, 1:high] + rest[wide, high - 1 : 0 : -1]).argmin())
            before = replace(place, high=split)
            then = replace(place, panel=after, row=place.row + split, high=high - split)
        yield from self.places(tree.first, before)
        yield from self.places(tree.rest, then)


def _join_costs(first: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the lowest sum for each size along the middle axis, over all splits."""
    joined = np.full(first.shape, np.inf)
    sizes = first.shape[1]
    for size in range(1, sizes - 1):
        both = first[:, size : size + 1] + rest[:, 1 : sizes - size]
        np.minimum(joined[:, size + 1 :], both, out=joined[:, size + 1 :])
    return joined
