"""Pagination is optimal: compared with exhaustive search."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
import pytest

from vidstyle.comic.layout.pagination import Pagination, RowTypes
from vidstyle.comic.layout.slicing import MAX_STACKED_PANELS, SINGLE_PANEL, Grid, Placement, Tree, list_rows
from vidstyle.comic.layout.weights import LayoutWeights
from vidstyle.regions.boxes import Rectangle

GRID_COLUMNS, GRID_ROWS, MAX_COLUMNS = 4, 5, 4

Sizes = tuple[tuple[int, int], ...]


def all_cuts(tree: Tree, wide: int, high: int) -> Iterator[Sizes]:
    """Yield the sizes of a tree's panels, for all ways to cut it."""
    if tree.first is None or tree.rest is None:
        yield ((wide, high),)
        return
    for cut in range(1, wide if tree.side_by_side else high):
        first = (cut, high) if tree.side_by_side else (wide, cut)
        rest = (wide - cut, high) if tree.side_by_side else (wide, high - cut)
        for one, other in product(all_cuts(tree.first, *first), all_cuts(tree.rest, *rest)):
            yield one + other


def all_rows(count: int) -> Iterator[tuple[Tree, int, int, Sizes]]:
    """Yield tree, first cut, height and sizes of all rows of `count` panels."""
    for tree in list_rows(count):
        for high in range(1, GRID_ROWS + 1):
            for sizes in all_cuts(tree, GRID_COLUMNS, high):
                yield tree, sizes[0][0] if tree.columns > 1 else 0, high, sizes


def least_of_all(panels: np.ndarray, weights: LayoutWeights, break_costs: list[float], pages: int) -> float:
    """Return the lowest cost, by exhaustive search."""
    row_types = RowTypes(MAX_COLUMNS, GRID_COLUMNS, GRID_ROWS)
    after = row_types.costs(weights)
    every = {count: list(all_rows(count)) for count in range(1, len(panels) + 1)}

    def least(start: int, page: int, filled: int, last: int | None) -> float:
        if start == len(panels):
            return 0.0 if (page, filled) == (pages - 1, GRID_ROWS) else np.inf
        turned = np.inf
        if filled == GRID_ROWS and page < pages - 1:
            turned = break_costs[start] + least(start, page + 1, 0, None)
        costs = [turned]
        for count in range(1, len(panels) - start + 1):
            for tree, cut, high, sizes in every[count]:
                if filled + high <= GRID_ROWS:
                    row_type = row_types.of(tree.columns, cut, high)
                    cost = sum(panels[start + n, w, h] for n, (w, h) in enumerate(sizes))
                    cost += float(weights.template(tree, start + 1)[-1])
                    cost += 0.0 if last is None else float(after[last, row_type])
                    costs.append(cost + least(start + count, page, filled + high, row_type))
        return float(min(costs))

    return least(0, 0, 0, None)


def test_rows_of_a_count_have_the_types_that_their_panels_allow() -> None:
    row_types = RowTypes(MAX_COLUMNS, GRID_COLUMNS, GRID_ROWS)
    for count in range(1, MAX_COLUMNS + 2):
        several = product(range(2, min(count, MAX_COLUMNS) + 1), range(1, GRID_COLUMNS))
        found = {row_types.of(columns, split, 0) for columns, split in several}
        found = found or {row_types.of(1, 0, high) for high in range(1, GRID_ROWS + 1)}
        assert found <= set(range(len(row_types))[row_types.of_rows(count)])


@pytest.mark.parametrize(
    ("count", "pages", "seed"),
    [(1, 1, 0), (2, 1, 1), (3, 1, 2), (3, 2, 3), (4, 2, 4), *((4, 1, seed) for seed in range(5, 15))],
)
def test_no_other_pages_cost_less(count: int, pages: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    panels = random.random((count, GRID_COLUMNS + 1, GRID_ROWS + 1)) * 3
    panels[:, 0], panels[:, :, 0] = np.inf, np.inf
    perturbation = {tree: random.random(count) for size in range(1, count + 1) for tree in list_rows(size)}
    weights, break_costs = (
        LayoutWeights(perturbation=perturbation, monotony=3.0, cross=2.0, ragged=2.0),
        [0.0, *random.random(count - 1), 0.0],
    )
    grid = Grid(Rectangle(0, 0, 400, 500), GRID_COLUMNS, GRID_ROWS, 10, 20)
    pagination = Pagination(panels, grid, weights, break_costs, count, MAX_COLUMNS)
    found = pagination.pages(pages)
    places = [place for row in found for place in pagination.places(row)]
    assert [place.panel for place in places] == list(range(count))
    assert pagination.cost(found, places) == pytest.approx(least_of_all(panels, weights, break_costs, pages))


def test_the_row_before_decides_a_split_against_the_costs_of_panels() -> None:
    panels = np.zeros((4, GRID_COLUMNS + 1, GRID_ROWS + 1))
    panels[:, [1, 3]] = 0.2
    panels[:, 0], panels[:, :, 0] = np.inf, np.inf
    pair = list_rows(2)[0]
    perturbation = {tree: np.full(4, 50.0) for size in (1, 3, 4) for tree in list_rows(size)}
    grid = Grid(Rectangle(0, 0, 400, 500), GRID_COLUMNS, GRID_ROWS, 10, 20)
    pagination = Pagination(
        panels, grid, LayoutWeights(perturbation=perturbation, monotony=3.0), [0.0] * 5, 4, MAX_COLUMNS
    )
    found = pagination.pages(1)
    assert [row.tree for row in found] == [pair, pair]
    first, second = (next(pagination.places(row)).wide for row in found)
    assert (first, second) == (found[0].split, found[1].split)
    assert first != second


def test_rows_cost_more_if_they_resemble_the_row_before() -> None:
    row_types = RowTypes(4, 12, 34)
    costs = row_types.costs(LayoutWeights())
    full, low = row_types.of(1, 0, 10), row_types.of(1, 0, 16)
    middle, next_to_it, apart = (row_types.of(2, cut, 0) for cut in (6, 7, 9))
    crossing, three = row_types.of(3, 6, 0), row_types.of(3, 4, 0)
    assert costs[middle, middle] > costs[middle, next_to_it] > costs[middle, apart] > costs[middle, three]
    assert costs[middle, row_types.of(2, 8, 0)] < costs[middle, next_to_it] - LayoutWeights().ragged / 2
    assert costs[middle, crossing] == LayoutWeights().cross
    assert costs[full, full] > costs[full, low] > costs[full, middle] == costs[middle, three] == 0


def test_each_kind_of_row_has_its_number() -> None:
    row_types = RowTypes(4, 12, 34)
    numbers = [row_types.of(columns, cut, 0) for columns in (2, 3, 4) for cut in range(1, 12)]
    assert sorted({row_types.of(1, 0, high) for high in range(1, 35)} | set(numbers)) == list(
        range(len(row_types))
    )
    assert [row_types.split_of(number) for number in numbers] == [
        (columns, cut) for columns in (2, 3, 4) for cut in range(1, 12)
    ]


def find_stacks(tree: Tree) -> list[bool]:
    """Return whether each column of a row is a stack."""
    if not tree.side_by_side or tree.first is None or tree.rest is None:
        return [tree.count > 1]
    return [tree.first.count > 1, *find_stacks(tree.rest)]


@pytest.mark.parametrize("count", range(1, 8))
def test_rows_are_all_different_and_no_two_stacks_are_neighbours(count: int) -> None:
    trees = list_rows(count)
    assert len(set(trees)) == len(trees)
    for tree in trees:
        assert tree.count == count
        stacks = find_stacks(tree)
        assert not any(one and other for one, other in zip(stacks, stacks[1:], strict=False))
        assert count <= MAX_STACKED_PANELS or not any(stacks)


def test_rows_of_up_to_four_panels() -> None:
    assert [len(list_rows(count)) for count in range(1, 6)] == [1, 1, 3, 10, 1]
    assert list_rows(1) == (SINGLE_PANEL,)


def test_the_places_of_a_grid_are_exact_and_end_at_its_edge() -> None:
    grid = Grid(Rectangle(7, 11, 510, 720), 12, 25, 9, 13)
    edges = [grid.rectangle(Placement(0, 0, column, 0, 1, 25)) for column in range(12)]
    assert edges[0].left == 7 and edges[-1].right == 510
    assert {other.left - one.right for one, other in zip(edges, edges[1:], strict=False)} == {9}
    assert {edge.bottom for edge in edges} == {720}
