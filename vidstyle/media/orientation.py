"""Orientation: quarter turns and flips of pictures, including their planes and chroma siting."""

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
"""Flags of the EXIF orientations 1 to 8: transpose, mirror in x, mirror in y."""


@dataclass(frozen=True)
class Orientation:
    """The transform from stored to upright rows and columns: transpose, then mirror.

    Attributes:
        transpose: whether rows become columns.
        mirror_x, mirror_y: whether to mirror horizontally, vertically.
    """

    transpose: bool = False
    mirror_x: bool = False
    mirror_y: bool = False

    @classmethod
    def from_exif(cls, number: int) -> Orientation:
        """Return the transform of the EXIF orientation, 1 to 8.

        >>> Orientation.from_exif(6) == Orientation.from_rotation(90)
        True
        """
        return cls(*(bit == "1" for bit in EXIF_ORIENTATIONS[number - 1]))

    @property
    def is_upright(self) -> bool:
        """Whether it is the identity."""
        return not (self.transpose or self.mirror_x or self.mirror_y)

    @property
    def rotation(self) -> int | None:
        """The clockwise rotation in degrees; None if it mirrors.

        >>> Orientation.from_rotation(270).rotation, Orientation(mirror_x=True).rotation
        (270, None)
        """
        turns = (0, 90, 180, 270)
        return next((each for each in turns if self == Orientation.from_rotation(each)), None)

    @classmethod
    def from_rotation(cls, degrees: int) -> Orientation:
        """Return a clockwise rotation by a multiple of 90 degrees.

        Raises:
            ValueError: another angle.

        >>> Orientation.from_rotation(90)
        Orientation(transpose=True, mirror_x=True, mirror_y=False)
        """
        if degrees % 90:
            raise ValueError(f"the rotation must be a multiple of 90 degrees, not {degrees}")
        return cls.from_exif((1, 6, 3, 8)[degrees // 90 % 4])

    @classmethod
    def from_matrix(cls, matrix: Sequence[int]) -> Orientation:
        """Return the transform of a display matrix: nine integers, (a, b, c, d) the linear part (display.h).

        Column x and row y are displayed at column a x + c y and row b x + d y. Angles are rounded to quarter
        turns.
        """
        a, b, _, c, d = matrix[:5]
        if abs(a) + abs(d) >= abs(b) + abs(c):
            return cls(False, a < 0, d < 0)
        return cls(True, c < 0, b < 0)

    def size(self, width: int, height: int) -> tuple[int, int]:
        """Return width and height after the transform."""
        return (height, width) if self.transpose else (width, height)

    def apply(self, picture: Picture) -> Picture:
        """Return the upright picture; its planes are copies unless the transform is the identity."""
        if self.is_upright:
            return picture
        return picture.map_planes(lambda plane, _: self.plane(plane), self.encoding(picture))

    def plane(self, plane: np.ndarray) -> np.ndarray:
        """Return one upright plane, H x W or H x W x 3."""
        import cv2

        if self.transpose:
            plane = cv2.transpose(plane)
        if self.mirror_x or self.mirror_y:
            plane = cv2.flip(plane, -1 if self.mirror_x and self.mirror_y else 1 if self.mirror_x else 0)
        return plane

    def encoding(self, picture: Picture) -> Encoding:
        """Return the encoding of the upright planes: subsampling and siting are transformed, too."""
        encoding = picture.encoding
        (across, down), (x, y) = encoding.subsampling, encoding.siting
        height, width = picture.shape
        if self.transpose:
            across, down, x, y, height, width = down, across, y, x, width, height
        if picture.chroma is not None:
            x = _mirror_siting(x, across, width) if self.mirror_x else x
            y = _mirror_siting(y, down, height) if self.mirror_y else y
        return replace(encoding, subsampling=(across, down), siting=(x, y))


def _mirror_siting(first: float, step: int, pixels: int) -> float:
    """Return the position of the first chroma sample after mirroring, in pixels."""
    samples = -(-pixels // step)
    return pixels - 1 - first - (samples - 1) * step


def orientation_of(frame: av.VideoFrame) -> Orientation:
    """Return the quarter turn in the metadata of a frame.

    Its side data would also contain flips, but PyAV 17 to 19 free the names of ICC profiles twice after
    `side_data` was read, which ends the process.
    """
    return Orientation.from_rotation(round(-frame.rotation / 90) * 90)


MATRIX_OFFSET_BYTES = 40
"""Offset of the display matrix after the name of a "tkhd" box, version 0 (ISO/IEC 14496-12, 8.3.2)."""


def orientation_of_stream(stream: av.video.stream.VideoStream) -> Orientation | None:
    """Return the orientation that the container declares for a stream; None: none, or unknown.

    PyAV does not expose it, but FFmpeg copies it to the header of an MP4 file with the same stream.
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
        orientation = Orientation.from_matrix(struct.unpack_from(">9i", box, MATRIX_OFFSET_BYTES))
        return None if orientation.is_upright else orientation
    return None
