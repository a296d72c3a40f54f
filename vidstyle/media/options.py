"""What can be asked of the reader, and what it says about what it reads."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from vidstyle.core.picture import Encoding
from vidstyle.errors import UsageError
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.raw_video import RAW, RawVideo
from vidstyle.media.read.open import MAX_PIXELS

MAX_RATE = 1000
"""Frames a second that may be asked for."""


@dataclass(frozen=True)
class ReadOptions:
    """How to read a source.

    Attributes:
        start, end: seconds of the source between which to read; `start` becomes time zero.
        size: width and height to deliver; one of them may be -1 to keep the shape, or -2 to be even too.
        fps: deliver a constant rate, by the nearest frame.
        rate: the rate of sources that have none of their own, picture sequences and raw video; None: 25.
        hwaccel: the kind of device to decode on, such as "cuda".
        rotate: degrees clockwise to turn by, instead of what the source asks for.
        allow_url: whether the source may be a URL.
        format: of what comes on "-", where its content does not tell: "rawvideo".
        raw: what raw video is.
        max_pixels: larger pictures are refused.
    """

    start: Fraction | None = None
    end: Fraction | None = None
    size: tuple[int, int] | None = None
    fps: Fraction | None = None
    rate: Fraction | None = None
    hwaccel: str | None = None
    rotate: int | None = None
    allow_url: bool = False
    format: str | None = None
    raw: RawVideo = RawVideo()
    max_pixels: int = MAX_PIXELS

    def check(self) -> None:
        """Raise UsageError where the options make no sense, whatever the source."""
        if self.start is not None and self.start < 0:
            raise UsageError("start", f"{float(self.start):g} s lies before the film")
        if self.end is not None and self.end <= (self.start or 0):
            raise UsageError("end", f"{float(self.end):g} s is not after the start")
        if self.rotate is not None and self.rotate % 90:
            raise UsageError("rotate", f"{self.rotate} is not a quarter turn", "give 90, 180 or 270")
        if self.fps is not None and not 0 < self.fps <= MAX_RATE:
            raise UsageError("fps", f"{float(self.fps):g} is not a frame rate", f"give one up to {MAX_RATE}")
        if self.format == RAW:
            self.raw.check()


@dataclass(frozen=True)
class VideoInfo:
    """The pictures that a reader delivers.

    Attributes:
        width, height: upright, as delivered.
        encoding: of the first picture.
        color_tags: what an encoder is to be told; nothing in them is left unspecified.
        time_base: of the frames' stamps.
        rate: frames a second, if known.
        sample_aspect: width of a pixel for each unit of height; None: square or not said.
        duration: seconds, and
        frames: how many, as the headers have it: estimates.
        alpha: whether the pictures have an alpha channel.
        is_rgb: whether they are RGB rather than luma and chroma.
        still: whether the source is a single picture.
    """

    width: int
    height: int
    encoding: Encoding
    color_tags: ColorTags
    time_base: Fraction
    rate: Fraction | None = None
    sample_aspect: Fraction | None = None
    duration: Fraction | None = None
    frames: int | None = None
    alpha: bool = False
    is_rgb: bool = False
    still: bool = False
