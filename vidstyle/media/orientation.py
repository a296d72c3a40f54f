"""Orientation: quarter turns and flips of pictures, planes and chroma siting alike."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace

import av
import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import log

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
    def from_matrix(cls, matrix: Sequence[int]) -> Orientation:
        """From a display matrix: nine integers, with (a, b, c, d) the linear part (display.h).

        Column x and row y are displayed at a x + c y across and b x + d y down. Angles are rounded to
        quarter turns.
        """
        a, b, _, c, d = matrix[:5]
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
    """The quarter turn that the metadata of a frame declares.

    Its side data would also tell flips, but PyAV 17 to 19 frees the names of ICC profiles twice once
    `side_data` has been read, which ends the process.
    """
    return Orientation.from_rotation(round(-frame.rotation / 90) * 90)


MATRIX_OFFSET = 40
"""Where the display matrix is behind the name of a "tkhd" box, version 0 (ISO/IEC 14496-12, 8.3.2)."""


def orientation_of_stream(stream: av.video.stream.VideoStream) -> Orientation | None:
    """The orientation that the container declares for a stream; None: it declares none, or it is unknown.

    PyAV does not show it, but FFmpeg copies it to the header of an MP4 file with the same stream.
    """
    for muxer in ("mp4", "mov"):
        header = io.BytesIO()
        try:
            options = {"movflags": "empty_moov"}
            with av.open(header, "w", muxer, container_options=options) as container:
                container.add_stream_from_template(stream, opaque=True)
                container.start_encoding()
        except (av.FFmpegError, ValueError) as error:
            log.debug("the orientation of %s in %s is unknown: %s", stream, muxer, error)
            continue
        _, _, box = header.getvalue().partition(b"tkhd")
        orientation = Orientation.from_matrix(struct.unpack_from(">9i", box, MATRIX_OFFSET))
        return None if orientation.is_upright else orientation
    return None
