"""Rational numbers of FFmpeg, for which PyAV has its own type since version 19."""

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
    """Convert the number to a Python fraction.

    >>> to_fraction(Fraction(24000, 1001)), to_fraction(0)
    (Fraction(24000, 1001), Fraction(0, 1))
    """
    return Fraction(number.numerator, number.denominator)
