"""Few cases for many: covering arrays, in which any two values meet, and draws that change by the day."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest

DAY = int(os.environ["VIDSTYLE_TEST_SEED"])
"""The seed of the day, by which a run draws its share of many cases."""


def of_the_day(cases: Sequence[Any], count: int) -> list[Any]:
    """Cases for `parametrize`: as many as said, others each day; thorough runs take those that are left."""
    drawn = set(np.random.default_rng(DAY).choice(len(cases), count, replace=False).tolist())
    marks = [() if number in drawn else pytest.mark.thorough for number in range(len(cases))]
    return [pytest.param(case, marks=mark) for case, mark in zip(cases, marks, strict=True)]


def covering_rows(factors: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """The rows of a pairwise covering array, built greedily; the same ones at every call.

    The first row takes the first value of every factor: put defaults first.
    """
    names = list(factors)
    missing = {
        pair
        for one, other in combinations(names, 2)
        for pair in product(_values(factors, one), _values(factors, other))
    } or {((name, number),) * 2 for name in names for number in range(1, len(factors[name]))}
    rows = [dict.fromkeys(names, 0)]
    missing -= _pairs(rows[0], names)
    while missing:
        row = dict(min(missing))
        for name in names:
            if name not in row:
                gains = [
                    len(missing & _pairs(row | {each: at}, names)) for each, at in _values(factors, name)
                ]
                row[name] = gains.index(max(gains))
        rows.append(row)
        missing -= _pairs(row, names)
    return [{name: factors[name][row[name]] for name in names} for row in rows]


def _values(factors: Mapping[str, Sequence[Any]], name: str) -> list[tuple[str, int]]:
    return [(name, number) for number in range(len(factors[name]))]


def _pairs(row: Mapping[str, int], names: Iterable[str]) -> set[tuple[tuple[str, int], tuple[str, int]]]:
    """The pairs of values in a row, in the order of the names; of one value alone, it with itself."""
    taken = [(name, row[name]) for name in names if name in row]
    return set(combinations(taken, 2)) or {(taken[0], taken[0])} if taken else set()
