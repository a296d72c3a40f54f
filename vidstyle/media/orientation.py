"""Orientation: quarter turns and flips of pictures, planes and chroma siting alike."""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace

import av
import numpy as np
from av.sidedata.sidedata import Type as SideDataType

from vidstyle.core.picture import Encoding, Picture
from vidstyle.media.frame import side_data_of

EXIF_ORIENTATIONS = "000 010 011 001 100 110 111 101".split()
"""Whether the EXIF orientations 1 to 8 transpose, mirror in x and mirror in y."""


@dataclass(frozen=True)
class Orientation:
    """The transform from stored to upright rows and columns: first transposed, then mirrored.

    Attributes:
        transpose: whether rows become columns.
        mirror_x, mirror_y: whether it is then mirrored horizontally, vertically.
    """

    transpose: bool = False
    mirror_x: bool = False
    mirror_y: bool = False

    @classmethod
    def from_exif(cls, number: int) -> Orientation:
        """From the EXIF orientation, 1 to 8.

        >>> Orientation.from_exif(6) == Orientation.from_rotation(90)
        True
        """
        return cls(*(bit == "1" for bit in EXIF_ORIENTATIONS[number - 1]))

    @property
    def is_upright(self) -> bool:
        """Whether it is the identity."""
        return not (self.transpose or self.mirror_x or self.mirror_y)

    @classmethod
    def from_rotation(cls, degrees: int) -> Orientation:
        """A turn clockwise by a multiple of 90 degrees.

        Raises:
            ValueError: another angle.

        >>> Orientation.from_rotation(90)
        Orientation(transpose=True, mirror_x=True, mirror_y=False)
        """
        if degrees % 90:
            raise ValueError(f"pictures are turned by multiples of 90 degrees, not by {degrees}")
        return cls.from_exif((1, 6, 3, 8)[degrees // 90 % 4])

    @classmethod
    def from_matrix(cls, matrix: bytes) -> Orientation:
        """From a display matrix: nine native 32-bit integers, with (a, b, c, d) the linear part (display.h).

        Column x and row y are displayed at a x + c y across and b x + d y down. Angles are rounded to
        quarter turns.
        """
        a, b, _, c, d = struct.unpack("=9i", matrix[:36])[:5]
        if abs(a) + abs(d) >= abs(b) + abs(c):
            return cls(False, a < 0, d < 0)
        return cls(True, c < 0, b < 0)

    def size(self, width: int, height: int) -> tuple[int, int]:
        """Width and height after the transform."""
        return (height, width) if self.transpose else (width, height)

    def apply(self, picture: Picture) -> Picture:
        """The upright picture; its planes are copies unless it is the identity."""
        if self.is_upright:
            return picture
        return picture.map_planes(lambda plane, _: self.plane(plane), self.encoding(picture))

    def plane(self, plane: np.ndarray) -> np.ndarray:
        """One plane upright, H x W or H x W x 3."""
        import cv2

        if self.transpose:
            plane = cv2.transpose(plane)
        if self.mirror_x or self.mirror_y:
            plane = cv2.flip(plane, -1 if self.mirror_x and self.mirror_y else 1 if self.mirror_x else 0)
        return plane

    def encoding(self, picture: Picture) -> Encoding:
        """What the upright planes mean: chroma step and siting turn with them."""
        encoding = picture.encoding
        (across, down), (x, y) = encoding.step, encoding.siting
        height, width = picture.shape
        if self.transpose:
            across, down, x, y, height, width = down, across, y, x, width, height
        if picture.chroma is not None:
            x = _mirrored(x, across, width) if self.mirror_x else x
            y = _mirrored(y, down, height) if self.mirror_y else y
        return replace(encoding, step=(across, down), siting=(x, y))


def _mirrored(first: float, step: int, pixels: int) -> float:
    """Position of the first chroma sample after mirroring, in pixels."""
    samples = -(-pixels // step)
    return pixels - 1 - first - (samples - 1) * step


def orientation_of(frame: av.VideoFrame) -> Orientation:
    """The orientation that the metadata of a frame declares."""
    matrix = side_data_of(frame, SideDataType.DISPLAYMATRIX)
    if matrix:
        return Orientation.from_matrix(matrix)
    return Orientation.from_rotation(round(-frame.rotation / 90) * 90)
