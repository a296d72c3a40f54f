"""Positions of eyes, nose and mouth in faces."""

from __future__ import annotations

from typing import NamedTuple

from vidstyle.regions.boxes import Box, Point


class Landmarks(NamedTuple):
    """Positions in a face, relative to its box: 0 at the left and the top, 1 at the right and the bottom.

    Left and right are as seen in the picture.
    """

    left_eye: Point
    right_eye: Point
    nose: Point
    mouth_left: Point
    mouth_right: Point

    @classmethod
    def of(cls, points: list[Point], face: Box) -> Landmarks:
        """Return five positions in pixels of the picture as landmarks of a face."""
        wide, high = max(face.width, 1e-6), max(face.height, 1e-6)
        return cls(*(((across - face.left) / wide, (down - face.top) / high) for across, down in points))

    def inside(self, face: Box) -> Landmarks:
        """Return the positions in pixels, for a face with this box."""
        return Landmarks(
            *((face.left + across * face.width, face.top + down * face.height) for across, down in self)
        )

    def mouth(self, face: Box) -> Point:
        """Return the middle of the mouth in pixels, for a face with this box."""
        (left, high), (right, low) = self.inside(face)[3:]
        return (left + right) / 2, (high + low) / 2


USUAL_LANDMARKS = Landmarks((0.3, 0.4), (0.7, 0.4), (0.5, 0.58), (0.33, 0.75), (0.67, 0.75))
"""Where they usually are, for models that do not find them."""

MarkedFaces = dict[Box[float], Landmarks]
"""Faces with their landmarks."""
