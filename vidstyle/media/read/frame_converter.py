"""Converts decoded frames to pictures for delivery: upright, one size, one format, SDR by default."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import av

from vidstyle.core.matte import over_color
from vidstyle.core.picture import Picture
from vidstyle.errors import log
from vidstyle.media.color_tags import BT2020_MATRIX_CODE, LIMITED_RANGE, ColorTags, default_tags
from vidstyle.media.frame import picture_from_frame, to_supported_format
from vidstyle.media.hdr import SDR_TAGS, ToneMap
from vidstyle.media.orientation import Orientation, orientation_of
from vidstyle.media.resize import letterbox_picture, output_size, resize_picture

PALETTE_CODECS = frozenset({"gif", "bmp"})
"""Codecs that always decode with an alpha channel, even if no pixel is transparent."""


class FrameConverter:
    """Converts all frames of a stream as its first frame requires.

    Attributes:
        width, height: size of the pictures.
        color_tags: colour tags of the pictures; all are specified.
        sample_aspect: sample aspect ratio of the pictures.

    Args:
        keep_hdr: whether HDR stays HDR; otherwise it is tone-mapped.
        matte: RGB 0..1 of the colour behind transparent pictures; None keeps their alpha.
    """

    def __init__(
        self,
        first: av.VideoFrame,
        codec: str,
        name: str,
        *,
        size: tuple[int, int] | None = None,
        orientation: Orientation | None = None,
        sample_aspect: Fraction | None = None,
        keep_hdr: bool = False,
        matte: tuple[float, float, float] | None = None,
    ) -> None:
        self._codec, self._name, self._matte = codec, name, matte
        self._orientation = orientation or orientation_of(first)
        self._stored = (first.width, first.height)
        self._upright = self._orientation.size(*self._stored)
        self.width, self.height = output_size(size, *self._upright) if size else self._upright
        self.sample_aspect = self._output_aspect(sample_aspect)
        tags = ColorTags.of(first)
        self._tone_map = ToneMap.of(first, tags) if tags.is_hdr and not keep_hdr else None
        self._warned: set[str] = set()
        self._format = self._choose_format(first)
        self._latest: tuple[av.VideoFrame, tuple[Picture, av.VideoFrame | None]] | None = None
        picture, _ = self.convert(first)
        if picture.color is not None and not picture.encoding.is_hdr:
            self.color_tags = default_tags(picture.encoding)
        elif picture.color is not None:
            self.color_tags = replace(tags, matrix=BT2020_MATRIX_CODE, range=LIMITED_RANGE)
        elif self._tone_map is not None:
            self.color_tags = SDR_TAGS
        else:
            self.color_tags = tags.completed(picture.encoding, first.height)

    def warn_if_hdr(self) -> bool:
        """Log a warning if the source is HDR, which is tone-mapped to SDR; return whether it is."""
        if self._tone_map is not None:
            log.warning(
                "the source is HDR (%s); it is tone-mapped to SDR, BT.709", self._tone_map.description
            )
        return self._tone_map is not None

    def convert(self, native: av.VideoFrame) -> tuple[Picture, av.VideoFrame | None]:
        """Return the picture, and the frame if the picture consists of its unchanged planes.

        The latest result is cached: the first frame and repeated frames are requested several times.
        """
        if self._latest is not None and self._latest[0] is native:
            return self._latest[1]
        frame = to_supported_format(native, self._name)
        if frame.format.name != self._format:
            frame = self._reformat(frame)
        decoded = picture = picture_from_frame(frame, self._codec, subject=self._name)
        if self._matte is not None:
            picture = over_color(picture, self._matte)
        if self._tone_map is not None:
            picture = self._tone_map.apply(picture)
        if not self._orientation.is_upright:
            picture = self._orientation.apply(picture)
        if (native.width, native.height) != self._stored:
            self._warn("the frame size changes; frames are fitted into the first size, with bars")
            picture = letterbox_picture(picture, *self._upright)
        if picture.shape != (self.height, self.width):
            picture = resize_picture(picture, self.width, self.height)
        self._latest = native, (picture, frame if picture is decoded else None)
        return self._latest[1]

    def _reformat(self, frame: av.VideoFrame) -> av.VideoFrame:
        if self._format != "rgb24":
            self._warn(f"the pixel format changes to {frame.format.name}; it is converted to {self._format}")
        tags = ColorTags.of(frame)
        frame = frame.reformat(format=self._format)
        tags.put_on(frame)
        return frame

    def _choose_format(self, first: av.VideoFrame) -> str:
        frame = to_supported_format(first, self._name)
        if frame.format.name == "rgba" and (self._codec in PALETTE_CODECS or first.format.name == "pal8"):
            alpha = picture_from_frame(frame).alpha
            if alpha is not None and alpha.min() == 255:
                return "rgb24"
        return str(frame.format.name)

    def _output_aspect(self, stored: Fraction | None) -> Fraction | None:
        """Return the aspect ratio after rotation, and after scaling to a size of another aspect ratio."""
        if stored is None or stored <= 0:
            stored = Fraction(1)
        upright = 1 / stored if self._orientation.transpose else stored
        across = Fraction(self._upright[0], self.width)
        down = Fraction(self._upright[1], self.height)
        # Rounding by one pixel is no reason for non-square pixels.
        stretch = across / down if abs(across / down - 1) > Fraction(1, min(self.width, self.height)) else 1
        return None if upright * stretch == 1 else upright * stretch

    def _warn(self, message: str) -> None:
        if message not in self._warned:
            self._warned.add(message)
            log.warning(message)
