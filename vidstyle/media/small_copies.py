"""Small copies of decoded frames, for those who look through a film."""

from __future__ import annotations

from fractions import Fraction

import av

from vidstyle.core.picture import Picture
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.orientation import orientation_of
from vidstyle.media.pictures import PictureMaker
from vidstyle.media.source import Source


class Sample:
    """A frame, of which small copies can be had until the next one is asked for.

    Attributes:
        time: when the frame is shown, in seconds.
        shape: height and width of the whole frame, upright and with square pixels.
    """

    def __init__(self, time: Fraction, native: av.VideoFrame, small: SmallCopies) -> None:
        self.time, self.shape = time, small.shape
        self._native, self._small = native, small

    def picture(self, side: int) -> Picture:
        """A copy with so many pixels on its longer side, or all there are: upright, square pixels, SDR."""
        return self._small.of(self._native, side)


class SmallCopies:
    """Copies of the frames of one size: reduced as they are stored, then brought upright and to SDR.

    Attributes:
        shape: height and width of the whole frames, upright and with square pixels.
    """

    def __init__(self, first: av.VideoFrame, source: Source) -> None:
        """For frames of the size of the first one."""
        self._source = source
        self._stored = (first.width, first.height)
        self._orientation = source.orientation or orientation_of(first)
        self._square = max(1, round(first.width * (source.sample_aspect or 1))), first.height
        width, height = self._orientation.size(*self._square)
        self.shape = height, width
        self._reformatter = av.video.reformatter.VideoReformatter()
        self._makers: dict[tuple[int, int], PictureMaker] = {}

    def fits(self, native: av.VideoFrame) -> bool:
        """Whether the frame is of that size."""
        return (native.width, native.height) == self._stored

    def of(self, native: av.VideoFrame, side: int) -> Picture:
        """A copy of the frame with so many pixels on its longer side, or all there are."""
        factor = min(Fraction(1), Fraction(side, max(self._square)))
        width, height = (max(1, round(length * factor)) for length in self._square)
        small = self._reduced(native, width, height)
        if (width, height) not in self._makers:
            self._makers[width, height] = PictureMaker(
                small, self._source.codec, self._source.name, orientation=self._orientation
            )
        return self._makers[width, height].make(small)[0]

    def _reduced(self, native: av.VideoFrame, width: int, height: int) -> av.VideoFrame:
        if (width, height) == self._stored:
            return native
        # One that is kept: each frame's own would set up its filters again.
        small = self._reformatter.reformat(native, width, height, interpolation="AREA")
        ColorTags.of(native).put_on(small)
        return small
