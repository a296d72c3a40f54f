"""Options of readers and writers, and the description of the video that a reader delivers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from vidstyle.core.picture import Encoding
from vidstyle.errors import UsageError
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.read.open import MAX_PIXELS

RAW = "rawvideo"
"""FFmpeg's name for raw video: frames one after another, without a header."""


@dataclass(frozen=True)
class RawVideo:
    """The size and format of raw video, which its content does not tell.

    Attributes:
        size: width and height; None: it was not said.
        pix_fmt: FFmpeg's name of the pixel format.
    """

    size: tuple[int, int] | None = None
    pix_fmt: str = "yuv420p"

    def check(self) -> None:
        """Raise UsageError if it cannot be read so."""
        if self.size is None:
            raise UsageError("raw video", "its size is not known", "say it with --input-size")

    def demuxer_options(self, rate: Fraction) -> dict[str, str]:
        """What FFmpeg is told to read it at so many frames a second; raises UsageError as `check`."""
        self.check()
        assert self.size is not None
        return {
            "video_size": "{}x{}".format(*self.size),
            "pixel_format": self.pix_fmt,
            "framerate": str(rate),
        }


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
class WriteOptions:
    """How to write.

    Attributes:
        codec: a video encoder or codec by FFmpeg's name, or None for what fits the kind of file.
        crf: the quality, on the encoder's own scale; lower is better.
        preset: the encoder's speed preset.
        pix_fmt: the pixel format, or None for one that plays everywhere.
        audio: "copy" (transcoded only where the container requires it), "none", or an encoder's name.
        new_sound: whether audio is pushed as samples, as that of live sources.
        overwrite: whether the output may exist.
        format: the kind of file if its name does not say: "y4m", "nut", "raw", "mkv", or FFmpeg's name.
    """

    codec: str | None = None
    crf: float | None = None
    preset: str | None = None
    pix_fmt: str | None = None
    audio: str = "copy"
    overwrite: bool = False
    format: str | None = None
    new_sound: bool = False


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
