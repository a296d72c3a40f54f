"""Sample many cases: pairwise covering arrays, and random choices that change daily."""

from __future__ import annotations

import functools
import inspect
import os
import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest

DAY = int(os.environ["VIDSTYLE_TEST_SEED"])
"""Random seed of the run, by default the date."""


def of_the_day(cases: Sequence[Any], count: int) -> list[Any]:
    """Mark all but `count` cases for `parametrize` as thorough; the random choice changes daily."""
    drawn = set(np.random.default_rng(DAY).choice(len(cases), count, replace=False).tolist())
    marks = [() if number in drawn else pytest.mark.thorough for number in range(len(cases))]
    return [pytest.param(case, marks=mark) for case, mark in zip(cases, marks, strict=True)]


def in_one_test(names: str, cases: Iterable[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Parametrize like `pytest.mark.parametrize`, but in a single test that reports all failing cases.

    Use it for many cases that are faster than the overhead of a test. Cases share the fixtures of the test.
    """
    parameters, known = [name.strip() for name in names.split(",")], list(cases)

    def declare(test: Callable[..., None]) -> Callable[..., None]:
        signature = inspect.signature(test)

        @functools.wraps(test)
        def run(**fixtures: Any) -> None:
            failures = []
            for case in known:
                values = dict(zip(parameters, case if len(parameters) > 1 else (case,), strict=True))
                try:
                    test(**fixtures, **values)
                except (Exception, pytest.fail.Exception) as failure:
                    failure.add_note(f"with {values}")
                    failures.append(failure)
            if failures:
                raise BaseExceptionGroup(f"{len(failures)} of {len(known)} cases", failures)

        left = [each for name, each in signature.parameters.items() if name not in parameters]
        run.__signature__ = signature.replace(parameters=left)  # type: ignore[attr-defined]
        return run

    return declare


def drawn(options: Sequence[Any], case: str) -> Any:
    """Return a random option for a case, different each day."""
    return random.Random(f"{DAY} {case}").choice(options)


def covering_rows(factors: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Return the rows of a pairwise covering array, built greedily and deterministically.

    The first row has the first value of each factor: put defaults first.
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
    """Return the pairs of values in a row, in the order of names; a single value is paired with itself."""
    taken = [(name, row[name]) for name in names if name in row]
    return set(combinations(taken, 2)) or {(taken[0], taken[0])} if taken else set()
