"""A key frame and the boxes in it: plain data that selection passes to layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, Literal, NamedTuple, TypeVar, cast

if TYPE_CHECKING:
    import numpy as np

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

_MOUTH_HEIGHT_RATIO = 0.75
"""Vertical position of the mouth in a face, relative to the face's height."""


def usual_mouth(face: Box) -> Point:
    """Return the position where a face usually has its mouth."""
    return face.center[0], face.top + _MOUTH_HEIGHT_RATIO * face.height


Framing = Literal["usual", "wide", "near"]
"""How much of its picture a panel shows: a suitable part, as much as possible, or only the main part."""


@dataclass(frozen=True)
class KeyFrame:
    """A key frame of the film, shown by one panel.

    Attributes:
        time: presentation time of the frame in seconds.
        shape: height and width of the picture, upright, with square pixels and without letterbox bars.
        importance: 0..1, relative to the most important key frame; 0 before key frames are chosen.
        saliency: box around the salient area, in pixels of that picture.
        faces: boxes of the faces, the largest first.
        scene: index of its scene.
        blobs: boxes of small conspicuous objects that no panel edge should cut.
        offset: left and top of the picture in its frame, greater than 0 if the frame has letterbox bars.
        framing: whether the panel shows a wide view or a close-up, if key frames look alike.
        mouths: positions of the mouths of those faces for which they are known.
        light: mean luma of the picture, 0..1.
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
        """Return the mouth of a face: its detected position, or else its usual one."""
        return self.mouths.get(face) or usual_mouth(face)

    def picture(self, frame: np.ndarray) -> np.ndarray:
        """Return the picture without letterbox bars from its frame, H x W x 3."""
        left, top = self.offset
        return frame[top : top + self.shape[0], left : left + self.shape[1]]
