"""Captured frames as pictures of one size and encoding, and restyled pictures as frames."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.live.capture import Capture
from vidstyle.media.capture.input import Captured
from vidstyle.media.color_tags import HD_LINES, usual_tags
from vidstyle.media.frame import frame_from_picture
from vidstyle.media.read.convert import PictureMaker
from vidstyle.media.resize import letterboxed, resized, wanted_size

if TYPE_CHECKING:
    import av


class Pictures:
    """What the first frame decides for a session, whatever the source may become later.

    Attributes:
        size: width and height of the pictures; 0 before the first.
        encoding: of what goes out.
    """

    def __init__(self, size: tuple[int, int] | None) -> None:
        """`size`: wanted, one side perhaps -1 or -2; None: that of the first frame, with square pixels."""
        self._wanted = size
        self._square = (0, 0)
        self._maker: PictureMaker | None = None
        self.size = (0, 0)
        self.encoding = Encoding()

    def picture(self, captured: Captured, capture: Capture, name: str) -> Picture:
        """The frame upright, at the session's size, without alpha; `name` is that of the source."""
        if self._maker is None:
            self._begin(captured, capture, name)
        assert self._maker is not None
        picture = replace(self._maker.make(captured.native)[0], alpha=None)
        return self._fitted(picture)

    def frame(self, picture: Picture) -> av.VideoFrame:
        """A picture in `encoding` as a frame that is tagged so."""
        return frame_from_picture(with_chroma(picture), tags=usual_tags(self.encoding, picture.shape[0]))

    def _begin(self, first: Captured, capture: Capture, name: str) -> None:
        aspect = capture.sample_aspect
        maker = PictureMaker(first.native, capture.codec, name, sample_aspect=aspect)
        # Neither a camera nor a page can say that its pixels are not square.
        self._square = max(1, round(maker.width * (maker.sample_aspect or 1))), maker.height
        self.size = wanted_size(self._wanted, *self._square) if self._wanted else self._square
        self.encoding = outgoing(maker.make(first.native)[0])
        self._maker = maker

    def _fitted(self, picture: Picture) -> Picture:
        """The whole picture at the session's size, with bars where that has another shape."""
        square = resized(picture, *self._square)
        return square if self.size == self._square else letterboxed(square, *self.size)


def outgoing(picture: Picture) -> Encoding:
    """What pictures like this one go out in: 8 bit, 4:2:0, limited range, which every reader understands."""
    matrix = picture.encoding.matrix if picture.color is None else ""
    if matrix not in ("bt601", "bt709"):
        matrix = "bt709" if picture.shape[0] >= HD_LINES else "bt601"
    return Encoding(matrix, full_range=False, depth=8, step=(2, 2), siting=SITINGS["left"])


def with_chroma(picture: Picture) -> Picture:
    """The picture with neutral chroma where a style has left none."""
    if picture.chroma is not None or picture.color is not None:
        return picture
    neutral = np.full(picture.encoding.chroma_shape(*picture.shape), 128, np.uint8)
    return replace(picture, chroma=(neutral, neutral))
