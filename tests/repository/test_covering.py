"""Covering arrays: any two values of two parameters occur together in some row."""

from __future__ import annotations

from itertools import combinations, product

import pytest
from covering import covering_rows


@pytest.mark.parametrize("sizes", [(2, 2), (2, 3, 4), (2,) * 9, (5, 5, 5), (12, 3, 3, 3), (1, 4, 1), (3, 1)])
def test_every_two_values_meet(sizes: tuple[int, ...]) -> None:
    factors = {f"factor {number}": list(range(size)) for number, size in enumerate(sizes)}
    rows = covering_rows(factors)
    for one, other in combinations(factors, 2):
        assert {(row[one], row[other]) for row in rows} == set(product(factors[one], factors[other]))
    assert len(rows) <= 3 * max(one * other for one, other in combinations(sizes, 2))
    assert set(rows[0].values()) == {0}


def test_one_parameter_takes_every_value() -> None:
    assert covering_rows({"only": "abc"}) == [{"only": letter} for letter in "abc"]
    assert covering_rows({}) == [{}]
