"""Options of readers and writers, and the description of the video that a reader delivers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from vidstyle.core.picture import Encoding
from vidstyle.errors import UsageError
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.hdr_metadata import HdrMetadata
from vidstyle.media.read.open import MAX_PIXELS

RAW_FORMAT = "rawvideo"
"""FFmpeg's name for raw video: frames one after another, without a header."""

PIPE_FORMATS = {"y4m": "yuv4mpegpipe", "raw": RAW_FORMAT, "mkv": "matroska", "ts": "mpegts"}
"""Short names of formats, in addition to FFmpeg's names."""


def check_rotation(degrees: int | None) -> None:
    """Raise UsageError unless a rotation is a multiple of 90 degrees, or None."""
    if degrees is not None and degrees % 90:
        raise UsageError("--rotate", f"{degrees} is not a quarter turn", "give 90, 180 or 270")


@dataclass(frozen=True)
class RawVideo:
    """The size and format of raw video, which has no header.

    Attributes:
        size: width and height; None: unknown.
        pix_fmt: FFmpeg's name of the pixel format.
    """

    size: tuple[int, int] | None = None
    pix_fmt: str = "yuv420p"

    def demuxer(self, format: str | None, rate: Fraction) -> tuple[str | None, dict[str, str]]:
        """Return FFmpeg's name of an input's format, and the options for its demuxer.

        Args:
            format: the user's name; None: detected from the content, or raw video if there is a size.
            rate: frames per second of raw video.

        Raises:
            UsageError: raw video without a size.
        """
        name = PIPE_FORMATS.get(format, format) if format else RAW_FORMAT if self.size else None
        if name != RAW_FORMAT:
            return name, {}
        if self.size is None:
            raise UsageError("raw video", "has no header with its size", "add --input-size, such as 1280x720")
        return RAW_FORMAT, {
            "video_size": "{}x{}".format(*self.size),
            "pixel_format": self.pix_fmt,
            "framerate": str(rate),
        }


HdrHandling = Literal["map", "keep"]
AlphaHandling = Literal["keep", "style"]
MAX_FRAME_RATE = 1000
"""Maximum frame rate that can be requested."""


@dataclass(frozen=True)
class ReadOptions:
    """How to read a source.

    Attributes:
        start, end: range to read, in seconds of the source; `start` becomes time zero.
        size: width and height to deliver; one may be -1 to keep the aspect ratio, or -2 to make it even, too.
        fps: convert to this constant frame rate by selecting the nearest frame.
        rate: frame rate of sources that have none: picture sequences and raw video; None: 25.
        hwaccel: the device type to decode on, such as "cuda".
        rotate: degrees clockwise, instead of the rotation in the metadata.
        allow_url: whether the source may be a URL.
        format: the source's format if it cannot be detected: "raw", "y4m", or FFmpeg's name.
        raw: size and pixel format of raw video; with a size, a source without a `format` is raw.
        max_pixels: larger pictures are rejected.
        hdr: "map" HDR to SDR tones, or "keep" PQ and HLG.
        matte: RGB 0..1 of the colour to put behind transparent pictures; None keeps their alpha.
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
    hdr: HdrHandling = "map"
    matte: tuple[float, float, float] | None = None

    def check(self) -> None:
        """Raise UsageError if an option is invalid for every source."""
        if self.start is not None and self.start < 0:
            raise UsageError("--start", f"{float(self.start):g} s is negative")
        if self.end is not None and self.end <= (self.start or 0):
            raise UsageError("--end", f"{float(self.end):g} s is not after the start")
        check_rotation(self.rotate)
        if self.fps is not None and not 0 < self.fps <= MAX_FRAME_RATE:
            raise UsageError("--fps", f"{float(self.fps):g} is outside 0 to {MAX_FRAME_RATE}")


@dataclass(frozen=True)
class WriteOptions:
    """How to write.

    Attributes:
        codec: FFmpeg's name of a video encoder or codec; None: the default of the container.
        crf: the quality, on the encoder's own scale; lower is better.
        preset: the encoder's speed preset.
        pix_fmt: the pixel format; None: one that plays everywhere.
        audio: "copy" (transcoded only where the container requires it), "none", or an encoder's name.
        new_sound: whether audio is pushed as samples, as by live sources.
        overwrite: whether the output may exist.
        format: the file format if the name has no extension: "y4m", "nut", "raw", "mkv", or FFmpeg's name.
        alpha: "keep" the alpha channel, or "style" its edges as well.
        optional: names of the fields above that apply only if the encoder has such a setting.
    """

    codec: str | None = None
    crf: float | None = None
    preset: str | None = None
    pix_fmt: str | None = None
    audio: str = "copy"
    alpha: AlphaHandling = "keep"
    overwrite: bool = False
    format: str | None = None
    new_sound: bool = False
    optional: frozenset[str] = frozenset()


@dataclass(frozen=True)
class VideoInfo:
    """The pictures that a reader delivers.

    Attributes:
        width, height: upright, as delivered.
        encoding: of the first picture.
        color_tags: tags for an encoder; all are specified.
        time_base: of the frames' timestamps.
        rate: frames per second, if known.
        sample_aspect: sample aspect ratio (width / height); None: square pixels or unknown.
        duration: seconds according to the headers, an estimate.
        frames: number of frames according to the headers, an estimate.
        alpha: whether the pictures have an alpha channel.
        is_rgb: whether they are RGB rather than luma and chroma.
        still: whether the source is a single picture.
        hdr: static metadata of HDR pictures.
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
    hdr: HdrMetadata = HdrMetadata()
