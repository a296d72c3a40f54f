"""A key frame and its boxes: plain data that selection hands to layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, Literal, NamedTuple, TypeVar, cast

if TYPE_CHECKING:
    import numpy as np

Length = TypeVar("Length", bound=float)


class Box(NamedTuple, Generic[Length]):
    """A rectangle in pixels of the upright picture or of a page; right and bottom lie outside.

    >>> Box(0, 0, 4, 2).union(Box(3, 1, 5, 5))
    Box(left=0, top=0, right=5, bottom=5)
    """

    left: Length
    top: Length
    right: Length
    bottom: Length

    @property
    def width(self) -> Length:
        """Never below 0."""
        return cast(Length, max(0, self.right - self.left))

    @property
    def height(self) -> Length:
        """Never below 0."""
        return cast(Length, max(0, self.bottom - self.top))

    @property
    def area(self) -> float:
        return self.width * self.height

    @property
    def aspect(self) -> float:
        """Width by height."""
        return self.width / self.height

    @property
    def center(self) -> tuple[float, float]:
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2

    def union(self, other: Box) -> Box:
        """The smallest box that holds both."""
        return Box(*map(min, self[:2], other[:2]), *map(max, self[2:], other[2:]))

    def intersection(self, other: Box) -> Box:
        """The common part, of area 0 if there is none."""
        left, top = map(max, self[:2], other[:2])
        right, bottom = map(min, self[2:], other[2:])
        return Box(left, top, max(left, right), max(top, bottom))

    def contains(self, other: Box) -> bool:
        """Whether the other box lies inside.

        >>> Box(0, 0, 4, 2).contains(Box(1, 0, 4, 2)), Box(0, 0, 4, 2).contains(Box(1, 0, 5, 2))
        (True, False)
        """
        return self.union(other) == self

    def scaled(self, factor: float) -> Box:
        """The box in a picture scaled by a factor."""
        return Box(*(side * factor for side in self))

    def moved(self, right: float, down: float) -> Box:
        """The box moved by so many pixels."""
        return Box(self.left + right, self.top + down, self.right + right, self.bottom + down)

    def padded(self, aside: float, above: float, below: float) -> Box:
        """The box enlarged by so many pixels on both sides, above and below."""
        return Box(self.left - aside, self.top - above, self.right + aside, self.bottom + below)

    def mirrored(self, axis: float) -> Box:
        """The box mirrored left to right in a picture of width `axis`."""
        return Box(axis - self.right, self.top, axis - self.left, self.bottom)


Rectangle = Box[int]
"""A part of a page, in whole pixels."""


Point = tuple[float, float]
"""Across and down, in pixels."""

_MOUTH = 0.75
"""How far down a face its mouth is."""


def usual_mouth(face: Box) -> Point:
    """Where a face usually has its mouth."""
    return face.center[0], face.top + _MOUTH * face.height


Framing = Literal["usual", "wide", "near"]
"""How much of its picture a panel shows: what suits it, as much as it can, or a part that counts most."""


@dataclass(frozen=True)
class Moment:
    """A key frame of the film, to be shown by a panel.

    Attributes:
        time: presentation time of the frame in seconds.
        shape: height and width of the picture, upright, with square pixels and without letterbox bars.
        importance: 0..1, relative to the most important moment; 0 before moments are chosen.
        saliency: box around the salient area, in pixels of that picture.
        faces: boxes of the faces, the largest first.
        scene: number of its scene, from 0.
        blobs: boxes of small objects that stand out, which no panel edge should cut.
        offset: left and top of the picture in its frame, above 0 where there are letterbox bars.
        framing: whether the panel shows it from afar or from near, where moments look alike.
        mouths: where the mouths of faces are, as far as that is known.
        light: how light the picture is on average, 0..1.
    """

    time: float
    shape: tuple[int, int]
    importance: float
    saliency: Box
    faces: tuple[Box, ...]
    scene: int
    blobs: tuple[Box, ...] = ()
    offset: tuple[int, int] = (0, 0)
    framing: Framing = "usual"
    mouths: Mapping[Box, Point] = field(default_factory=dict)
    light: float = 0.5

    def mouth(self, face: Box) -> Point:
        """Where the mouth of a face is, or usually is."""
        return self.mouths.get(face) or usual_mouth(face)

    def picture(self, frame: np.ndarray) -> np.ndarray:
        """The picture in its frame, H x W x 3."""
        left, top = self.offset
        return frame[top : top + self.shape[0], left : left + self.shape[1]]
