"""Reads films, images and image sequences: upright frames with repaired times, other streams as packets."""

from __future__ import annotations

import itertools
import os
from collections.abc import Collection, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import av

from vidstyle.core.closing import Closing
from vidstyle.errors import InputError, log
from vidstyle.media.frame import DecodedFrame, Frame
from vidstyle.media.options import ReadOptions, VideoInfo
from vidstyle.media.orientation import Orientation
from vidstyle.media.read.clock import ConstantRate
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.deinterlace import Deinterlacer
from vidstyle.media.read.film_source import DEFAULT_RATE, FilmSource
from vidstyle.media.read.frame_converter import FrameConverter
from vidstyle.media.read.open import open_media
from vidstyle.media.read.parts import PartedSource
from vidstyle.media.read.sequence import SequenceSource, is_animated_webp, is_pattern
from vidstyle.media.read.source import VideoSource
from vidstyle.media.read.transport_stream import FilePart, part_offsets
from vidstyle.media.read.trim import Trim

__all__ = ["ReadOptions", "Reader", "VideoInfo", "open_reader"]


def open_reader(source: str | os.PathLike[str], options: ReadOptions | None = None) -> Reader:
    """Open a film, a picture, a sequence such as "frames/%05d.png" or "*.png", or "-" for standard input.

    Raises:
        InputError: it cannot be read, or no frame of it can be decoded.
        UsageError: the options make no sense, or a URL that was not allowed.
    """
    options = options or ReadOptions()
    options.check()
    broken: list[int] = []
    while True:
        try:
            return _open_reader(source, options, broken)
        except NoFrameError as error:
            if error.stream is None or str(source) == "-":
                raise
            broken.append(error.stream)
            log.warning("no frame of video stream %d could be decoded: another is tried", error.stream)


def _open_reader(source: str | os.PathLike[str], options: ReadOptions, broken: Collection[int]) -> Reader:
    opened = open_source(source, options, broken)
    try:
        return Reader(opened, options)
    except BaseException:
        opened.close()
        raise


class NoFrameError(InputError):
    """Nothing of a video stream could be decoded; `stream` is its index if there are others."""

    stream: int | None = None


class Reader(Closing):
    """An open source. Iterate over it once; close it, or use it in a `with` statement.

    Attributes:
        name: what was opened, as it was named.
        info: what is delivered.
        container: the open container, for its chapters, tags and attachments; None for picture sequences.
        copied_streams: the streams whose packets are passed on: all but other videos.
        damage: what has been found wrong so far; complete when the iteration is over.
    """

    def __init__(self, source: VideoSource, options: ReadOptions) -> None:
        self._source, self._options = source, options
        self.name, self.container, self.damage = source.name, source.container, source.damage
        self.copied_streams = source.copied_streams
        self._rate = ConstantRate(options.fps) if options.fps else None
        if options.start:
            source.seek(options.start)
        self._items = self._trimmed()
        self._waiting: list[DecodedFrame | av.Packet] = []
        first = self._first_frame()
        turned = None if options.rotate is None else Orientation.from_rotation(options.rotate)
        self._converter = FrameConverter(
            first.native,
            source.codec,
            source.name,
            size=options.size,
            orientation=turned or source.orientation,
            sample_aspect=source.sample_aspect,
        )
        self._converter.warn_if_hdr()
        self.info = self._describe(first, still=source.may_be_still and self._is_alone())

    def __iter__(self) -> Iterator[Frame | av.Packet]:
        for item in itertools.chain(self._waiting, self._items):
            if not isinstance(item, DecodedFrame):
                yield item
                continue
            picture, native = self._converter.convert(item.native)
            frame = Frame(picture, item.pts, self._source.time_base, item.duration, native, item.key)
            if self._rate is None:
                yield frame
            else:
                yield from self._rate.push(frame)
        if self._rate is not None:
            yield from self._rate.flush()

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _trimmed(self) -> Iterator[DecodedFrame | av.Packet]:
        options, items = self._options, Deinterlacer(self._source.time_base).apply(self._source.items())
        if options.start is None and options.end is None:
            return items
        sounds = [stream.index for stream in self.copied_streams if stream.type == "audio"]
        return Trim(self._source.time_base, options.start, options.end, sounds).apply(items)

    def _first_frame(self) -> DecodedFrame:
        for item in self._items:
            self._waiting.append(item)
            if isinstance(item, DecodedFrame):
                return item
        if self.damage.decoded:
            raise InputError(self._source.name, "has no frame between the given start and end")
        error = NoFrameError(self._source.name, "no frame could be decoded")
        if isinstance(self._source, FilmSource) and self._source.has_other_videos:
            error.stream = self._source.stream.index
        raise error

    def _is_alone(self) -> bool:
        """Whether the first frame is the only one; reads on to the second."""
        for item in self._items:
            self._waiting.append(item)
            if isinstance(item, DecodedFrame):
                return False
        return True

    def _describe(self, first: DecodedFrame, still: bool) -> VideoInfo:
        picture, _ = self._converter.convert(first.native)
        source, converter = self._source, self._converter
        rate = self._options.fps or source.rate
        duration = _span(source.duration, self._options)
        whole = self._options == ReadOptions(rate=self._options.rate)
        frames = source.frames if whole else round(duration * rate) if duration and rate else None
        return VideoInfo(
            width=converter.width,
            height=converter.height,
            encoding=picture.encoding,
            color_tags=converter.color_tags,
            time_base=self._rate.time_base if self._rate else source.time_base,
            rate=rate,
            sample_aspect=converter.sample_aspect,
            duration=None if still else duration,
            frames=1 if still else frames,
            alpha=picture.alpha is not None,
            is_rgb=picture.color is not None,
            still=still,
        )


def _span(duration: Fraction | None, options: ReadOptions) -> Fraction | None:
    """The seconds of the part that is read."""
    if duration is None and options.end is None:
        return None
    end = options.end if duration is None else min(duration, options.end or duration)
    assert end is not None
    return max(Fraction(0), end - (options.start or 0))


def open_source(
    source: str | os.PathLike[str], options: ReadOptions, broken: Collection[int] = ()
) -> VideoSource:
    """A film, a sequence of numbered pictures, an animation, or what comes on standard input for "-".

    Args:
        broken: indexes of video streams that are not taken.

    Raises:
        InputError: it cannot be read.
        UsageError: a URL that was not allowed.
    """
    if is_pattern(source):
        rate = options.fps or options.rate or DEFAULT_RATE
        return SequenceSource.from_pattern(str(source), rate, options.max_pixels)
    if str(source) != "-" and is_animated_webp(Path(source)):
        return SequenceSource.from_webp(Path(source), options.max_pixels)
    format, demuxer_options = options.raw.demuxer(options.format, options.rate or DEFAULT_RATE)
    container = open_media(
        source,
        allow_url=options.allow_url,
        max_pixels=options.max_pixels,
        hwaccel=options.hwaccel,
        format=format,
        options=demuxer_options,
    )
    try:
        name = "standard input" if str(source) == "-" else str(source)
        file = None if str(source) == "-" or not Path(source).is_file() else Path(source)
        offsets = part_offsets(file) if file and container.format.name == "mpegts" else [0]
        if file is None or len(offsets) == 1:
            return FilmSource(container, name, options.max_pixels, file, broken=broken)
    except BaseException:
        container.close()
        raise
    container.close()
    return _open_parts(file, offsets, options)


def _open_parts(file: Path, offsets: Sequence[int], options: ReadOptions) -> PartedSource:
    """The parts of a recording that begin at some offsets; those without pictures are passed over."""
    damage, parts = DecodeReport(), []
    for start, end in itertools.pairwise([*offsets, file.stat().st_size]):
        try:
            part = open_media(FilePart(file, start, end), max_pixels=options.max_pixels, format="mpegts")
            parts.append(FilmSource(part, str(file), options.max_pixels, file, damage))
        except InputError as error:
            log.warning("%s: bytes %d to %d are left out: %s", file, start, end, error.reason)
            damage.cut_off = True
    if not parts:
        raise InputError(file, "not a readable video")
    return PartedSource(parts)
