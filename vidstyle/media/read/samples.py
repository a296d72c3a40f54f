"""Small copies of a film's frames: of all, or, where that would take too long, of its key frames only."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
from av.stream import Discard

from vidstyle.core.picture import Picture
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.options import ReadOptions
from vidstyle.media.orientation import orientation_of
from vidstyle.media.read.convert import FrameConverter
from vidstyle.media.read.decoder import PATIENCE
from vidstyle.media.read.film import FilmSource
from vidstyle.media.read.open import open_media
from vidstyle.media.read.reader import open_source
from vidstyle.media.read.source import VideoSource


@dataclass(frozen=True)
class Extent:
    """How much there is of a film, as its headers have it.

    Attributes:
        seconds, frames: 0 where nothing is said.
        pixels: of one frame.
    """

    seconds: Fraction
    frames: int
    pixels: int


def measure_extent(source: str | os.PathLike[str], options: ReadOptions | None = None) -> Extent:
    """How much there is to decode; only headers are read, and of numbered pictures the first.

    Raises:
        InputError: it cannot be read.
    """
    with closing(open_source(source, options or ReadOptions())) as opened:
        stream = opened.stream if isinstance(opened, FilmSource) else None
        pixels = stream.width * stream.height if stream else 0
        return Extent(opened.duration or Fraction(0), opened.frames or 0, pixels)


def sample_all(
    source: str | os.PathLike[str],
    start: Fraction = Fraction(0),
    end: Fraction | None = None,
    options: ReadOptions | None = None,
) -> Iterator[SampledFrame]:
    """A small copy of every frame between two times, and of the one that is on the screen at the start.

    Args:
        source: what `open_reader` opens, "-" left out.
        start, end: seconds.

    Raises:
        InputError: it cannot be read.
    """
    options = options or ReadOptions()
    with closing(_only_pictures(open_source(source, options))) as opened:
        if start:
            opened.seek(start)
        yield from _samples(opened, _between(_stamped(opened), opened.time_base, start, end))


def sample_keys(
    source: str | os.PathLike[str], gap: Fraction, options: ReadOptions | None = None
) -> Iterator[SampledFrame]:
    """A small copy of the film's key frames, of none that comes sooner than `gap` seconds after another.

    No other frame is decoded. Of numbered pictures, each of which is a key frame, one in each gap is read.

    Args:
        source: as for `sample_all`.

    Raises:
        InputError: it cannot be read.
    """
    options = options or ReadOptions()
    opened = open_source(source, options)
    if isinstance(opened, FilmSource):
        opened.close()
        container = open_media(source, allow_url=options.allow_url, max_pixels=options.max_pixels)
        file = Path(source) if Path(source).is_file() else None
        film = _KeyFrames(container, str(source), options.max_pixels, file, gap)
        with closing(_only_pictures(film)) as opened:
            yield from _samples(opened, _stamped(opened))
    else:
        yield from _samples(opened, _steps(opened, gap))


class _KeyFrames(FilmSource):
    """A film of which only key frames reach the decoder."""

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        max_pixels: int,
        file: Path | None,
        gap: Fraction,
    ) -> None:
        super().__init__(container, name, max_pixels, file)
        self._gap = gap
        # The demuxers that can then do not even read the others.
        self.stream.discard = Discard.nonkey

    def _packets(self) -> Iterator[av.Packet]:
        last: Fraction | None = None
        for packet in super()._packets():
            if not packet.is_keyframe:
                continue
            stamp = packet.pts if packet.pts is not None else packet.dts
            time = None if stamp is None or packet.time_base is None else stamp * packet.time_base
            if last is None or time is None or not 0 <= time - last < self._gap:
                last = time
                yield packet


def _only_pictures(source: VideoSource) -> VideoSource:
    """The source, from which nothing is read but its film."""
    for stream in source.copied_streams:
        stream.discard = Discard.all
    source.copied_streams = []
    return source


def _stamped(source: VideoSource) -> Iterator[DecodedFrame]:
    return (item for item in source.items() if isinstance(item, DecodedFrame))


def _steps(source: VideoSource, gap: Fraction) -> Iterator[DecodedFrame]:
    time, end = Fraction(0), source.duration or Fraction(0)
    while time < end:
        source.seek(time)
        # The frame that cannot be read stands for nothing: the next of the few that can is taken.
        for _, item in zip(range(PATIENCE), _stamped(source), strict=False):
            yield item
            time = max(time, item.pts * source.time_base)
            break
        time += gap


def _between(
    frames: Iterator[DecodedFrame], time_base: Fraction, start: Fraction, end: Fraction | None
) -> Iterator[DecodedFrame]:
    """At least one frame, if there are any: the nearest to the span."""
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


def _samples(source: VideoSource, frames: Iterator[DecodedFrame]) -> Iterator[SampledFrame]:
    small: SmallCopies | None = None
    for frame in frames:
        if small is None or not small.fits(frame.native):
            small = SmallCopies(frame.native, source)
        yield SampledFrame(frame.pts * source.time_base, frame.native, small)


class SampledFrame:
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

    def __init__(self, first: av.VideoFrame, source: VideoSource) -> None:
        """For frames of the size of the first one."""
        self._source = source
        self._stored = (first.width, first.height)
        self._orientation = source.orientation or orientation_of(first)
        self._square = max(1, round(first.width * (source.sample_aspect or 1))), first.height
        width, height = self._orientation.size(*self._square)
        self.shape = height, width
        self._reformatter = av.video.reformatter.VideoReformatter()
        self._converters: dict[tuple[int, int], FrameConverter] = {}

    def fits(self, native: av.VideoFrame) -> bool:
        """Whether the frame is of that size."""
        return (native.width, native.height) == self._stored

    def of(self, native: av.VideoFrame, side: int) -> Picture:
        """A copy of the frame with so many pixels on its longer side, or all there are."""
        factor = min(Fraction(1), Fraction(side, max(self._square)))
        width, height = (max(1, round(length * factor)) for length in self._square)
        small = self._reduced(native, width, height)
        if (width, height) not in self._converters:
            self._converters[width, height] = FrameConverter(
                small, self._source.codec, self._source.name, orientation=self._orientation
            )
        return self._converters[width, height].convert(small)[0]

    def _reduced(self, native: av.VideoFrame, width: int, height: int) -> av.VideoFrame:
        if (width, height) == self._stored:
            return native
        # One that is kept: each frame's own would set up its filters again.
        small = self._reformatter.reformat(native, width, height, interpolation="AREA")
        ColorTags.of(native).put_on(small)
        return small
