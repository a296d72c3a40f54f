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

PIPE_FORMATS = {"y4m": "yuv4mpegpipe", "raw": RAW, "mkv": "matroska", "ts": "mpegts"}
"""Short names of formats, besides FFmpeg's own."""


@dataclass(frozen=True)
class RawVideo:
    """The size and format of raw video, which its content does not tell.

    Attributes:
        size: width and height; None: not given.
        pix_fmt: FFmpeg's name of the pixel format.
    """

    size: tuple[int, int] | None = None
    pix_fmt: str = "yuv420p"

    def demuxer(self, format: str | None, rate: Fraction) -> tuple[str | None, dict[str, str]]:
        """FFmpeg's name of an input's format, and the options of its demuxer.

        Args:
            format: as the user names it; None: what its content says, or raw video where there is a size.
            rate: frames per second of raw video.

        Raises:
            UsageError: raw video without a size.
        """
        name = PIPE_FORMATS.get(format, format) if format else RAW if self.size else None
        if name != RAW:
            return name, {}
        if self.size is None:
            raise UsageError("raw video", "does not say its size", "add --input-size, such as 1280x720")
        return RAW, {
            "video_size": "{}x{}".format(*self.size),
            "pixel_format": self.pix_fmt,
            "framerate": str(rate),
        }


MAX_RATE = 1000
"""Maximum frame rate that can be requested."""


@dataclass(frozen=True)
class ReadOptions:
    """How to read a source.

    Attributes:
        start, end: seconds of the source between which to read; `start` becomes time zero.
        size: width and height to deliver; one of them may be -1 to keep the shape, or -2 to be even too.
        fps: convert to a constant frame rate, by the nearest frame.
        rate: frame rate of sources without one: picture sequences and raw video; None: 25.
        hwaccel: the kind of device to decode on, such as "cuda".
        rotate: degrees clockwise, instead of the rotation in the metadata.
        allow_url: whether the source may be a URL.
        format: name of the source's format where its content does not tell: "raw", "y4m", or FFmpeg's name.
        raw: size and pixel format of raw video; with a size, a source without a `format` is raw.
        max_pixels: larger pictures are rejected.
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
        """Raise UsageError if an option is invalid for every source."""
        if self.start is not None and self.start < 0:
            raise UsageError("--start", f"{float(self.start):g} s lies before the film")
        if self.end is not None and self.end <= (self.start or 0):
            raise UsageError("--end", f"{float(self.end):g} s is not after the start")
        if self.rotate is not None and self.rotate % 90:
            raise UsageError("--rotate", f"{self.rotate} is not a quarter turn", "give 90, 180 or 270")
        if self.fps is not None and not 0 < self.fps <= MAX_RATE:
            raise UsageError("--fps", f"{float(self.fps):g} is outside 0 to {MAX_RATE}")


@dataclass(frozen=True)
class WriteOptions:
    """How to write.

    Attributes:
        codec: FFmpeg's name of a video encoder or codec, or None for the default of the container.
        crf: the quality, on the encoder's own scale; lower is better.
        preset: the encoder's speed preset.
        pix_fmt: the pixel format, or None for one that plays everywhere.
        audio: "copy" (transcoded only where the container requires it), "none", or an encoder's name.
        new_sound: whether audio is pushed as samples, as by live sources.
        overwrite: whether the output may exist.
        format: the kind of file if its name does not say: "y4m", "nut", "raw", "mkv", or FFmpeg's name.
        habitual: names of those above that hold only where an encoder has such a setting.
    """

    codec: str | None = None
    crf: float | None = None
    preset: str | None = None
    pix_fmt: str | None = None
    audio: str = "copy"
    overwrite: bool = False
    format: str | None = None
    new_sound: bool = False
    habitual: frozenset[str] = frozenset()


@dataclass(frozen=True)
class VideoInfo:
    """The pictures that a reader delivers.

    Attributes:
        width, height: upright, as delivered.
        encoding: of the first picture.
        color_tags: tags for an encoder; none is unspecified.
        time_base: of the frames' timestamps.
        rate: frames per second, if known.
        sample_aspect: sample aspect ratio (width / height); None: square or unknown.
        duration: seconds according to the headers, an estimate.
        frames: number of frames according to the headers, an estimate.
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
