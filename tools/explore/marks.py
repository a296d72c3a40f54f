"""Marks of people: which random styles they kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

MIN_KEPT_SHARE = 0.5
"""Share of people from which a style counts as kept."""

Row = dict[str, Any]
"""A style of KEY.json, see `tools/explore/marking.py`."""


def kept_share(people: Sequence[Mapping[str, str]], number: str) -> float:
    """Return the share of people who kept a style, of those who marked it."""
    marks = [each[str(number)] for each in people if str(number) in each]
    return marks.count("keep") / len(marks)
