"""Rectangles and points in pictures and on pages."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar, cast

Length = TypeVar("Length", bound=float)


class Box(NamedTuple, Generic[Length]):
    """A rectangle in pixels of the upright picture or of a page; `right` and `bottom` are exclusive.

    >>> Box(0, 0, 4, 2).union(Box(3, 1, 5, 5))
    Box(left=0, top=0, right=5, bottom=5)
    """

    left: Length
    top: Length
    right: Length
    bottom: Length

    @property
    def width(self) -> Length:
        """The width, at least 0."""
        return cast(Length, max(0, self.right - self.left))

    @property
    def height(self) -> Length:
        """The height, at least 0."""
        return cast(Length, max(0, self.bottom - self.top))

    @property
    def area(self) -> float:
        return self.width * self.height

    @property
    def aspect(self) -> float:
        """Width divided by height."""
        return self.width / self.height

    @property
    def center(self) -> tuple[float, float]:
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2

    def union(self, other: Box) -> Box:
        """Return the smallest box that contains both."""
        return Box(*map(min, self[:2], other[:2]), *map(max, self[2:], other[2:]))

    def intersection(self, other: Box) -> Box:
        """Return the common part; its area is 0 if the boxes do not overlap."""
        left, top = map(max, self[:2], other[:2])
        right, bottom = map(min, self[2:], other[2:])
        return Box(left, top, max(left, right), max(top, bottom))

    def contains(self, other: Box) -> bool:
        """Whether this box contains the other.

        >>> Box(0, 0, 4, 2).contains(Box(1, 0, 4, 2)), Box(0, 0, 4, 2).contains(Box(1, 0, 5, 2))
        (True, False)
        """
        return self.union(other) == self

    def scaled(self, factor: float) -> Box:
        """Return the same box for a picture that is scaled by `factor`."""
        return Box(*(side * factor for side in self))

    def moved(self, right: float, down: float) -> Box:
        """Return the box moved by `right` and `down` pixels."""
        return Box(self.left + right, self.top + down, self.right + right, self.bottom + down)

    def padded(self, aside: float, above: float, below: float) -> Box:
        """Return the box enlarged by `aside` pixels on both sides, `above` at the top and `below` below."""
        return Box(self.left - aside, self.top - above, self.right + aside, self.bottom + below)

    def mirrored(self, axis: float) -> Box:
        """Return the box mirrored left to right in a picture of width `axis`."""
        return Box(axis - self.right, self.top, axis - self.left, self.bottom)


Rectangle = Box[int]
"""An area of a page, in whole pixels."""

Point = tuple[float, float]
"""Horizontal and vertical position in pixels."""
