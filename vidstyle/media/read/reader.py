"""Reads films, pictures and image sequences: upright frames with repaired times, other streams as packets."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Callable, Collection, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

import av

from vidstyle.core.closing import Closing
from vidstyle.errors import InputError, log
from vidstyle.media.frame import DecodedFrame, Frame
from vidstyle.media.hdr_metadata import HdrMetadata, first_metadata, read_metadata
from vidstyle.media.options import ReadOptions, VideoInfo
from vidstyle.media.orientation import Orientation
from vidstyle.media.read.clock import ConstantRate
from vidstyle.media.read.deinterlace import Deinterlacer
from vidstyle.media.read.file_structure.transport_stream import (
    RecordingPart,
    RecordingStream,
    find_recording_parts,
    opened_stream,
)
from vidstyle.media.read.film_source import DEFAULT_FRAME_RATE, FilmSource
from vidstyle.media.read.frame_converter import FrameConverter
from vidstyle.media.read.open import open_media
from vidstyle.media.read.parts import open_recording, open_recording_stream
from vidstyle.media.read.sequence import SequenceSource, is_animated_webp, is_pattern
from vidstyle.media.read.source import VideoSource
from vidstyle.media.read.trim import Trimmer

__all__ = ["ReadOptions", "Reader", "VideoInfo", "open_reader"]

Used = TypeVar("Used")


def open_reader(source: str | os.PathLike[str], options: ReadOptions | None = None) -> Reader:
    """Open a film, a picture, a sequence such as "frames/%05d.png" or "*.png", or "-" for standard input.

    Raises:
        InputError: the source cannot be read, or no frame of it can be decoded.
        UsageError: invalid options, or a URL without `allow_url`.
    """
    options = options or ReadOptions()
    options.check()
    return use_source(source, options, lambda opened: Reader(opened, options))


def use_source(
    source: str | os.PathLike[str], options: ReadOptions, use: Callable[[VideoSource], Used]
) -> Used:
    """Open a source and return the result of `use`; try the next video track if the longest has no frame.

    Raises:
        InputError: the source cannot be read, or no frame of it can be decoded.
        UsageError: a URL without `allow_url`.
    """
    broken: list[int] = []
    while True:
        opened = open_source(source, options, broken)
        try:
            return use(opened)
        except NoFrameError as error:
            opened.close()
            if error.stream is None or str(source) == "-":
                raise
            broken.append(error.stream)
            log.warning("no frame of video stream %d could be decoded; trying another stream", error.stream)
        except BaseException:
            opened.close()
            raise


class NoFrameError(InputError):
    """No frame of a source could be decoded.

    Attributes:
        stream: index of the video stream, if there are others; else None.
    """

    def __init__(self, source: VideoSource) -> None:
        super().__init__(source.name, "no frame could be decoded")
        self.stream: int | None = None
        if isinstance(source, FilmSource) and source.has_other_videos:
            self.stream = source.stream.index


class Reader(Closing):
    """An open source. Iterate over it once; close it, or use it in a `with` statement.

    Attributes:
        name: the source, as the caller named it.
        info: description of the delivered video.
        container: the open container, for its chapters, tags and attachments; None for image sequences.
        copied_streams: the streams whose packets are passed through: all except other video streams.
        damage: the damage found so far; complete at the end of the iteration.
    """

    def __init__(self, source: VideoSource, options: ReadOptions) -> None:
        self._source, self._options = source, options
        self.name, self.container, self.damage = source.name, source.container, source.damage
        self.copied_streams = source.copied_streams
        self._rate = ConstantRate(options.fps) if options.fps else None
        if options.start:
            source.seek(options.start)
        self._items = self._trim_items()
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
            keep_hdr=options.hdr == "keep",
            matte=options.matte,
        )
        self._converter.warn_if_hdr()
        self.info = self._describe(first, still=source.may_be_still and self._is_alone())
        if options.hdr == "keep" and not self.info.encoding.is_hdr:
            log.info("%s is SDR: --hdr keep changes nothing", self.name)

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

    @property
    def can_seek(self) -> bool:
        """Whether `seek` and `skip_pictures` work: for films in files, except recordings in several parts."""
        return isinstance(self._source, FilmSource) and Path(self.name).is_file()

    def seek(self, time: Fraction) -> None:
        """Continue before a time in seconds of the delivered film; frames keep their times.

        The first frames may differ from the same frames of the whole film, since earlier ones are missing.
        """
        self._source.seek(time + (self._options.start or 0))
        self._waiting, self._items = [], self._trim_items()
        self._rate = ConstantRate(self._options.fps) if self._options.fps else None

    def skip_pictures(self) -> None:
        """Deliver only the packets of the copied streams."""
        assert isinstance(self._source, FilmSource)
        self._source.skips_pictures = True
        self._waiting = [item for item in self._waiting if not isinstance(item, DecodedFrame)]

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _trim_items(self) -> Iterator[DecodedFrame | av.Packet]:
        options, items = self._options, Deinterlacer(self._source.time_base).apply(self._source.items())
        if options.start is None and options.end is None:
            return items
        sounds = [stream.index for stream in self.copied_streams if stream.type == "audio"]
        return Trimmer(self._source.time_base, options.start, options.end, sounds).apply(items)

    def _first_frame(self) -> DecodedFrame:
        for item in self._items:
            self._waiting.append(item)
            if isinstance(item, DecodedFrame):
                return item
        if self.damage.decoded:
            raise InputError(self._source.name, "has no frame between the given start and end")
        raise NoFrameError(self._source)

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
        duration = _selected_duration(source.duration, self._options)
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
            hdr=self._hdr_metadata(first) if picture.encoding.is_hdr else HdrMetadata(),
        )

    def _hdr_metadata(self, first: DecodedFrame) -> HdrMetadata:
        """Return the plausible static metadata of a film; report the dynamic metadata, which is dropped."""
        if not self.can_seek:
            return read_metadata(first.native).plausible()
        assert isinstance(self._source, FilmSource)
        metadata, dynamic = first_metadata(self.name, self._source.stream.index)
        if dynamic:
            names = " and ".join(dynamic)
            log.warning("%s: metadata of %s is dropped, as it describes other pictures", self.name, names)
        return metadata.plausible()


def _selected_duration(duration: Fraction | None, options: ReadOptions) -> Fraction | None:
    """Return the duration of the selected range in seconds."""
    if duration is None and options.end is None:
        return None
    end = options.end if duration is None else min(duration, options.end or duration)
    assert end is not None
    return max(Fraction(0), end - (options.start or 0))


def open_source(
    source: str | os.PathLike[str], options: ReadOptions, broken: Collection[int] = ()
) -> VideoSource:
    """Open a film, an image sequence, an animation, or standard input for "-".

    Args:
        broken: indexes of video streams to ignore.

    Raises:
        InputError: the source cannot be read.
        UsageError: a URL without `allow_url`.
    """
    if is_pattern(source):
        rate = options.fps or options.rate or DEFAULT_FRAME_RATE
        return SequenceSource.from_pattern(str(source), rate, options.max_pixels)
    if str(source) != "-" and is_animated_webp(Path(source)):
        return SequenceSource.from_webp(Path(source), options.max_pixels)
    format, demuxer_options = options.raw.demuxer(options.format, options.rate or DEFAULT_FRAME_RATE)
    stream = opened_stream(sys.stdin.buffer) if str(source) == "-" and format is None else None
    if isinstance(stream, RecordingStream):
        return open_recording_stream(stream, "standard input", options)
    container = open_media(
        stream or source,
        allow_url=options.allow_url,
        max_pixels=options.max_pixels,
        hwaccel=options.hwaccel,
        format=format,
        options=demuxer_options,
    )
    try:
        if str(source) == "-":
            return FilmSource(container, "standard input", options.max_pixels, None)
        file = Path(source) if Path(source).is_file() else None
        parts = (
            find_recording_parts(file) if file and container.format.name == "mpegts" else [RecordingPart()]
        )
        if file is None or len(parts) == 1:
            pixels = options.max_pixels
            return FilmSource(container, str(source), pixels, file, broken=broken, recording=parts[0])
    except BaseException:
        container.close()
        raise
    container.close()
    return open_recording(file, parts, options)
