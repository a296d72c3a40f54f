"""The kinds of targets: streams at one rate, film files, and nothing at all."""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from vidstyle.core.convert import convert
from vidstyle.core.picture import Picture
from vidstyle.live.meter import Meter
from vidstyle.live.target import LiveFrame
from vidstyle.live.target_thread import Sink, TargetThread
from vidstyle.media.audio import AudioChunk
from vidstyle.media.color_tags import usual_tags
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo
from vidstyle.media.write.film import FilmWriter
from vidstyle.media.write.writer import WriteOptions, open_writer

if TYPE_CHECKING:
    from vidstyle.media.write.stream import Stream

TIME_BASE = Fraction(1, 90000)
FILE_ROOM = 8
"""Frames that may wait for a disk or an encoder that pauses."""


class ConstantRateTarget(TargetThread):
    """A stream at a constant rate: where no new picture is there in time, the last is shown again."""

    def __init__(
        self,
        name: str,
        open_sink: Callable[[LiveFrame], StreamSink],
        meter: Meter,
        rate: Fraction,
        reconnects: bool,
    ) -> None:
        super().__init__(name, open_sink, meter, reconnects)
        self._ticks = FramePacer(rate)
        self._last: LiveFrame | None = None
        self._early = 0

    @property
    def dropped(self) -> int:
        """Frames that were left out, newer ones being there, or the last tick being theirs."""
        return super().dropped + self._early

    def _patience(self) -> float | None:
        return self._ticks.wait(time.monotonic())

    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        before = self._ticks.last
        number = self._ticks.place(time.monotonic())
        if number is None:
            self._early += frame is not None
            self._last = frame or self._last  # should the next be late, this one is shown in its place
        elif frame is None:
            self._show_again(sink, number)
        else:
            if isinstance(sink, StreamSink) and sink.needs_every:
                for missing in range(before + 1, number):
                    self._show_again(sink, missing)
            self._write(sink, frame, number)
            self._last = frame
            self._count(frame)

    def _show_again(self, sink: Sink, number: int) -> None:
        if self._last is not None:
            self._write(sink, self._last, number)
            self.repeated += 1


class StreamSink:
    """An open stream as a sink."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._shift = 0.0
        self.needs_every = stream.needs_every

    def write(self, frame: LiveFrame, number: int) -> None:
        """See Sink."""
        self._shift = self._stream.write(frame.video, number) - frame.captured

    def push_audio(self, chunk: AudioChunk) -> None:
        """See Sink; sound goes beside the picture that was taken with it."""
        self._stream.push_audio(chunk, chunk.time + self._shift)

    def close(self) -> None:
        """See Sink."""
        self._stream.close()


class FileTarget(TargetThread):
    """A film file, in which every picture has the time of its capture."""

    room = FILE_ROOM

    def __init__(
        self,
        target: str | Path,
        meter: Meter,
        rate: Fraction,
        options: WriteOptions,
        aspect: Fraction | None = None,
    ) -> None:
        """`aspect`: width of a pixel for each unit of height; None: square."""
        super().__init__(
            str(target), lambda first: FileSink(target, first, rate, options, aspect), meter, reconnects=False
        )

    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        if frame is not None:
            self._write(sink, frame, self.delivered)
            self._count(frame)


class FileSink:
    """A file of the kind that `vidstyle render` writes."""

    def __init__(
        self,
        target: str | Path,
        first: LiveFrame,
        rate: Fraction,
        options: WriteOptions,
        aspect: Fraction | None = None,
        still: bool = False,
    ) -> None:
        """Raises VidstyleError: the file exists, or cannot be written."""
        height, width = first.picture.shape
        encoding = first.picture.encoding
        tags = usual_tags(encoding, height)
        info = VideoInfo(width, height, encoding, tags, TIME_BASE, rate, sample_aspect=aspect, still=still)
        self._writer = open_writer(target, info, options)
        self._zero: float | None = None
        self._step = round(1 / (rate * TIME_BASE))
        self._converted(first)  # what is done only once is done before pictures wait for it

    def write(self, frame: LiveFrame, number: int) -> None:
        """See Sink; the number is left aside for the frame's own time."""
        self._zero = frame.captured if self._zero is None else self._zero
        pts = round((frame.captured - self._zero) / TIME_BASE)
        self._writer.write(Frame(self._converted(frame), pts, TIME_BASE, self._step))

    def push_audio(self, chunk: AudioChunk) -> None:
        """See Sink; what was heard before the first picture is left out."""
        if self._zero is not None and isinstance(self._writer, FilmWriter):
            self._writer.push_audio(chunk, chunk.time - self._zero)

    def close(self) -> None:
        """See Sink."""
        self._writer.finish()

    def _converted(self, frame: LiveFrame) -> Picture:
        return convert(frame.picture, self._writer.encoding, self._writer.wants_rgb)


class NullTarget:
    """Takes every picture and keeps none, for measuring."""

    name = "null"
    state = "running"
    dropped = repeated = 0
    error = None

    def __init__(self, meter: Meter) -> None:
        self._meter = meter
        self.delivered = 0

    def start(self, first: LiveFrame) -> None:
        """There is nothing to open."""

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self.delivered += 1
        self._meter.delivered(frame.captured)

    def close(self) -> None:
        """See Target."""


LATE = 0.75
"""By how much of a tick a picture may miss its own, so that trembling makes none drop and none repeat."""
MAX_GAP = 1.0
"""After so many seconds without a write the reader itself stood still, and the count goes on from there."""


class FramePacer:
    """Numbers ticks from the first picture on.

    Attributes:
        last: the number of the tick that was filled last; -1 before the first.
    """

    def __init__(self, rate: Fraction) -> None:
        self._rate = float(rate)
        self._zero: float | None = None
        self.last = -1

    def place(self, now: float) -> int | None:
        """The tick for a picture that is there now, or None if it is too early and to be left out.

        Args:
            now: in seconds of `time.monotonic`.
        """
        wanted = self.last + 1
        if self._zero is None or now - self._time(wanted) > MAX_GAP:
            self._zero = now - wanted / self._rate
        position = (now - self._zero) * self._rate
        if position < wanted - LATE:
            return None
        self.last = wanted if position <= wanted + LATE else round(position)
        return self.last

    def wait(self, now: float) -> float | None:
        """Seconds until the last picture must be shown again, or None if there was none yet."""
        return None if self._zero is None else max(0.0, self._time(self.last + 1 + LATE) - now)

    def _time(self, position: float) -> float:
        assert self._zero is not None
        return self._zero + position / self._rate
