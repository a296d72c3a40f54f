"""Exact numbers of FFmpeg, for which PyAV has a type of its own from version 19 on."""

from __future__ import annotations

from fractions import Fraction
from typing import Protocol


class Rational(Protocol):
    """A fraction or an integer of any type."""

    @property
    def numerator(self) -> int: ...

    @property
    def denominator(self) -> int: ...


def to_fraction(number: Rational) -> Fraction:
    """Return the number as a fraction of Python.

    >>> to_fraction(Fraction(24000, 1001)), to_fraction(0)
    (Fraction(24000, 1001), Fraction(0, 1))
    """
    return Fraction(number.numerator, number.denominator)
