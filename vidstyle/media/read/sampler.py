"""Random access to the frames of an open film: small copies of many frames, single frames in full size."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import av
import numpy as np
from av.stream import Discard

from vidstyle.core.closing import Closing
from vidstyle.core.convert import to_rgb
from vidstyle.core.picture import Picture
from vidstyle.errors import InputError
from vidstyle.media.color_tags import ColorTags, matrix_from_tags
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.options import ReadOptions
from vidstyle.media.orientation import Orientation, orientation_of
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.deinterlace import Deinterlacer
from vidstyle.media.read.film_source import MAX_FAILURES, FilmSource
from vidstyle.media.read.frame_converter import FrameConverter
from vidstyle.media.read.parts import MultipartSource
from vidstyle.media.read.reader import NoFrameError, use_source
from vidstyle.media.read.source import VideoSource
from vidstyle.media.read.trim import Trimmer
from vidstyle.media.resize import stretch_to_square_pixels

_MAX_DAMAGE_SECONDS = 12
"""Time after which damage is no longer visible, even without a key frame: encoders refresh every block."""
_MAX_TICKS_PER_SECOND = 1_000_000
"""Maximum ticks per second of a time base."""


class FilmSampler(Closing):
    """Random access to the frames of an open film.

    Requesting another iterator invalidates the previous one.

    Attributes:
        seconds: duration by the headers, 0 if unknown.
        pixels: number of pixels in all frames together, by the headers; 0 if unknown.
        rate: frames per second, or None if unknown.
        count: number of frames by the headers; None if unknown.
    """

    def __init__(self, source: str | os.PathLike[str], rotate: int | None = None) -> None:
        """Open a film.

        Args:
            source: a source of `open_reader` other than "-".
            rotate: degrees clockwise, a multiple of 90, instead of the rotation in the metadata.

        Raises:
            InputError: the source cannot be read, or no frame of its video tracks can be decoded.
        """
        self._source = opened = use_source(source, ReadOptions(), _check_decodable)
        self._turned = None if rotate is None else Orientation.from_rotation(rotate)
        self.seconds, self.pixels = opened.duration or Fraction(0), 0
        self.rate, self.count = opened.rate, opened.frames
        if isinstance(opened, FilmSource | MultipartSource):
            self.pixels = (opened.frames or 0) * opened.stream.width * opened.stream.height
        for stream in self._source.copied_streams:
            stream.discard = Discard.all
        self._source.copied_streams = []
        self._deinterlacer = Deinterlacer(self._source.time_base)
        self._copies: SmallCopies | None = None
        self._is_fresh = not _has_other_videos(opened)

    def close(self) -> None:
        """Close the file."""
        self._source.close()

    def frames(self, start: Fraction = Fraction(0), end: Fraction | None = None) -> Iterator[SampledFrame]:
        """Yield all frames between two times in seconds, including the frame shown at the start."""
        if start == 0 and end is None:
            self._source.damage.clear()
        self._seek(start)
        return self._to_samples(_select_frames(self._decode_frames(), self._source.time_base, start, end))

    def key_frames(self, gap: Fraction) -> Iterator[SampledFrame]:
        """Yield the key frames, at least `gap` seconds apart.

        No other frame is decoded. Of an image sequence, one picture is read per gap.
        """
        if not isinstance(self._source, FilmSource | MultipartSource):
            yield from self._to_samples(self._decode_stepwise(gap))
            return
        self._source.damage.clear()
        self._seek(Fraction(0))
        self._source.decode_keys(gap)
        try:
            yield from self._to_samples(self._decode_frames())
        finally:
            self._source.decode_keys(None)

    def image_at(self, time: float) -> np.ndarray:
        """Return the frame at a time in seconds in full size: H x W x 3 uint8, deinterlaced, square pixels.

        Raises:
            InputError: there is no frame at this time.
        """
        source, start = self._source, exact_time(time) if time > 0 else None
        self._seek(start or Fraction(0))
        self._deinterlacer.reset()
        trim = Trimmer(source.time_base, start, None, ())
        for item in trim.apply(self._deinterlacer.apply(self._decode_frames())):
            assert isinstance(item, DecodedFrame)
            converter = FrameConverter(
                item.native,
                source.codec,
                source.name,
                orientation=self._turned or source.orientation,
                sample_aspect=source.sample_aspect,
            )
            return stretch_to_square_pixels(
                to_rgb(converter.convert(item.native)[0]), converter.sample_aspect
            )
        raise InputError(source.name, f"has no picture at {time:g} s")

    @property
    def damage(self) -> DecodeReport:
        """The damage found since all frames or key frames were requested; complete after the last one."""
        return replace(self._source.damage)

    def turn(self, degrees: int) -> int | None:
        """Rotate all frames clockwise by a multiple of 90 degrees, beyond the rotation in the metadata.

        At least one frame must have been read.

        Returns:
            The sum of this rotation and the one in the metadata, as in the constructor; None: the metadata
            mirror the film, which is not turned.
        """
        assert self._copies is not None, "no frame has been read"
        before = self._copies.orientation.rotation
        if before is None:
            return None
        rotate = (before + degrees) % 360
        self._turned, self._copies = Orientation.from_rotation(rotate), None
        return rotate

    def deinterlace_all(self) -> None:
        """Deinterlace all frames of `image_at`, also those without the flag."""
        self._deinterlacer = Deinterlacer(self._source.time_base, every_frame=True)

    def warn_if_hdr(self) -> bool:
        """Log a warning if the last sampled frames are HDR, which become SDR; return whether they are."""
        return self._copies is not None and self._copies.warn_if_hdr()

    def _seek(self, time: Fraction) -> None:
        if time or not self._is_fresh:
            self._source.seek(time)
        self._is_fresh = False

    def _decode_frames(self) -> Iterator[DecodedFrame]:
        """Yield decoded frames; those between one with errors and the next key frame are marked as damaged.

        They are predicted from it, but decoders flag only the frame with the errors.
        """
        last = -math.inf
        for item in self._source.items():
            if not isinstance(item, DecodedFrame):
                continue
            time = float(item.pts * self._source.time_base)
            if item.repeated or item.native.is_corrupt:
                last = time
            elif item.key:
                last = -math.inf
            yield replace(item, damaged=True) if time - last <= _MAX_DAMAGE_SECONDS else item

    def _decode_stepwise(self, gap: Fraction) -> Iterator[DecodedFrame]:
        time, end = Fraction(0), self._source.duration or Fraction(0)
        while time < end:
            self._seek(time)
            # A frame that cannot be decoded is replaced by the next one that can.
            for _, item in zip(range(MAX_FAILURES), self._decode_frames(), strict=False):
                yield item
                time = max(time, item.pts * self._source.time_base)
                break
            time += gap

    def _to_samples(self, frames: Iterator[DecodedFrame]) -> Iterator[SampledFrame]:
        for frame in frames:
            if self._copies is None or not self._copies.fits(frame.native):
                self._copies = SmallCopies(frame.native, self._source, self._turned)
            yield SampledFrame(frame, frame.pts * self._source.time_base, self._copies)


def _has_other_videos(source: VideoSource) -> bool:
    return isinstance(source, FilmSource) and source.has_other_videos


def _check_decodable(source: VideoSource) -> VideoSource:
    """Return the source, after decoding a frame of its video track if there are other tracks."""
    if _has_other_videos(source) and not any(isinstance(item, DecodedFrame) for item in source.items()):
        raise NoFrameError(source)
    return source


def exact_time(seconds: float) -> Fraction:
    """Return the exact time of a rounded float, so that a frame is found again by its own time.

    >>> exact_time(14 / 25), Fraction(14 / 25) < Fraction(14, 25)
    (Fraction(14, 25), False)
    """
    return Fraction(seconds).limit_denominator(_MAX_TICKS_PER_SECOND)


def _select_frames(
    frames: Iterator[DecodedFrame], time_base: Fraction, start: Fraction, end: Fraction | None
) -> Iterator[DecodedFrame]:
    """Yield the frames in a time range; at least the nearest one, if there are any."""
    before: DecodedFrame | None = None
    begun = False
    for frame in frames:
        time = frame.pts * time_base
        if time < start:
            before = frame
            continue
        if before is not None and not begun and time > start:
            begun = True
            yield before
        if end is not None and time >= end and begun:
            return
        begun = True
        yield frame
    if before is not None and not begun:
        yield before


class SampledFrame:
    """A frame that yields small copies until the next frame is requested.

    Attributes:
        time: presentation time in seconds.
        shape: height and width of the full frame, upright and with square pixels.
        is_key: whether decoding can start at it.
        is_damaged: whether the decoder had to conceal errors in it, or in a frame since its key frame.
        is_interlaced: whether it is flagged as interlaced; `FilmSampler.image_at` deinterlaces such frames.
    """

    def __init__(self, frame: DecodedFrame, time: Fraction, small: SmallCopies) -> None:
        self.time, self.shape = time, small.shape
        self.is_key, self.is_damaged = frame.key, frame.damaged
        self.is_interlaced = bool(frame.native.interlaced_frame)
        self._native, self._small = frame.native, small

    def stored_luma(self) -> np.ndarray:
        """Return the stored luma, neither scaled nor rotated: H x W uint8."""
        return self._small.luma_of(self._native)

    def picture(self, side: int) -> Picture:
        """Return a copy with at most `side` pixels on its longer side: upright, square pixels, SDR."""
        return self._small.of(self._native, side)

    def glance(self, side: int) -> np.ndarray:
        """Return a copy like `picture` as FFmpeg converts it, H x W x 3 RGB uint8.

        Its colours differ a little, and more if the film is HDR, but no kernel has to be compiled for it.
        """
        return self._small.glance(self._native, side)


class SmallCopies:
    """Makes copies of frames of one size and format: scaled down as stored, then upright and in SDR.

    Attributes:
        shape: height and width of the full frames, upright and with square pixels.
        orientation: from the stored to the upright frames.
    """

    def __init__(self, first: av.VideoFrame, source: VideoSource, turned: Orientation | None = None) -> None:
        """Prepare copies.

        Args:
            first: a frame that gives size and pixel format.
            source: of the frames.
            turned: orientation instead of the one in the metadata.

        Raises:
            InputError: an unsupported matrix, of which swscale cannot make copies.
        """
        matrix_from_tags(source.name, ColorTags.of(first), source.codec, first.height, first.width)
        self._source = source
        self._stored = (first.width, first.height)
        self._format = first.format.name
        # swscale cannot scale indices into a palette.
        self._scaled_format = "rgba" if self._format == "pal8" else None
        self.orientation = turned or source.orientation or orientation_of(first)
        self._square = max(1, round(first.width * (source.sample_aspect or 1))), first.height
        width, height = self.orientation.size(*self._square)
        self.shape = height, width
        self._reformatter = av.video.reformatter.VideoReformatter()
        self._converters: dict[tuple[int, int], FrameConverter] = {}

    def warn_if_hdr(self) -> bool:
        """See `FrameConverter`."""
        return next((converter.warn_if_hdr() for converter in self._converters.values()), False)

    def fits(self, native: av.VideoFrame) -> bool:
        """Whether the frame has the same size and pixel format."""
        return (native.width, native.height) == self._stored and native.format.name == self._format

    def luma_of(self, native: av.VideoFrame) -> np.ndarray:
        """Return the stored luma of the frame in 8 bits: H x W uint8."""
        return self._reformatter.reformat(native, format="gray").to_ndarray()

    def glance(self, native: av.VideoFrame, side: int) -> np.ndarray:
        """See `SampledFrame`."""
        width, height = self._size(side)
        small = self._reformatter.reformat(native, width, height, "rgb24", interpolation="AREA")
        return self.orientation.plane(small.to_ndarray())

    def _size(self, side: int) -> tuple[int, int]:
        """Return the stored width and height of a copy with at most `side` pixels on its longer side."""
        factor = min(Fraction(1), Fraction(side, max(self._square)))
        width, height = (max(1, round(length * factor)) for length in self._square)
        return width, height

    def of(self, native: av.VideoFrame, side: int) -> Picture:
        """Return a copy of the frame with at most `side` pixels on its longer side."""
        width, height = self._size(side)
        small = self._reduced(native, width, height)
        if (width, height) not in self._converters:
            self._converters[width, height] = FrameConverter(
                small, self._source.codec, self._source.name, orientation=self.orientation
            )
        return self._converters[width, height].convert(small)[0]

    def _reduced(self, native: av.VideoFrame, width: int, height: int) -> av.VideoFrame:
        if (width, height) == self._stored:
            return native
        # A shared reformatter, since a new one would set up its filters for each frame.
        # In one thread, as copies are small and candidates are measured in parallel.
        small = self._reformatter.reformat(
            native, width, height, self._scaled_format, interpolation="AREA", threads=1
        )
        ColorTags.of(native).put_on(small)
        return small
