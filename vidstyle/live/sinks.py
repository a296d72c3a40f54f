"""The kinds of targets: streams at a constant rate, video files, and none at all."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from vidstyle.core.convert import convert
from vidstyle.core.picture import Picture
from vidstyle.live.clock import MONOTONIC, Clock
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame
from vidstyle.live.target_thread import Sink, TargetThread
from vidstyle.media.audio import AudioChunk
from vidstyle.media.color_tags import default_tags
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo
from vidstyle.media.write.writer import WriteOptions, open_writer

if TYPE_CHECKING:
    from vidstyle.media.write.stream import Stream

TIME_BASE = Fraction(1, 90000)
FILE_CAPACITY = 8
"""Frames that may wait for a disk or an encoder that pauses."""


class ConstantRateTarget(TargetThread):
    """A stream at a constant rate: if no new frame arrives in time, the last one is repeated."""

    def __init__(
        self,
        name: str,
        open_sink: Callable[[LiveFrame], StreamSink],
        meter: LatencyMeter,
        rate: Fraction,
        reconnects: bool,
        clock: Clock = MONOTONIC,
    ) -> None:
        super().__init__(name, open_sink, meter, reconnects, clock)
        self._pacer = FramePacer(rate)
        self._last: LiveFrame | None = None
        self._early = 0

    @property
    def dropped(self) -> int:
        """Number of frames that were dropped for newer ones, or because they came too early."""
        return super().dropped + self._early

    def _timeout(self) -> float | None:
        return self._pacer.timeout(self._clock.now())

    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        before = self._pacer.last
        number = self._pacer.slot(self._clock.now())
        if number is None:
            self._early += frame is not None
            self._last = frame or self._last  # should the next be late, this one is repeated in its place
        elif frame is None:
            self._repeat(sink, number)
        else:
            if isinstance(sink, StreamSink) and sink.needs_every:
                for missing in range(before + 1, number):
                    self._repeat(sink, missing)
            self._write(sink, frame, number)
            self._last = frame
            self._count(frame)

    def _repeat(self, sink: Sink, number: int) -> None:
        if self._last is not None:
            self._write(sink, self._last, number)
            self.repeated += 1


class StreamSink:
    """Writes to an open stream."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._offset = 0.0
        self.needs_every = stream.needs_every

    def write(self, frame: LiveFrame, number: int) -> None:
        """See Sink."""
        self._offset = self._stream.write(frame.video, number) - frame.captured

    def push_audio(self, chunk: AudioChunk) -> None:
        """See Sink; sound is placed beside the frame that was captured with it."""
        self._stream.push_audio(chunk, chunk.time + self._offset)

    def close(self) -> None:
        """See Sink."""
        self._stream.close()


class FileTarget(TargetThread):
    """A video file, in which every frame has the time of its capture."""

    capacity = FILE_CAPACITY

    def __init__(
        self,
        target: str | Path,
        meter: LatencyMeter,
        rate: Fraction,
        options: WriteOptions,
        clock: Clock = MONOTONIC,
    ) -> None:
        super().__init__(
            str(target), lambda first: FileSink(target, first, rate, options), meter, clock=clock
        )

    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        if frame is not None:
            self._write(sink, frame, self.delivered)
            self._count(frame)


class FileSink:
    """Writes a file of any container that `vidstyle render` writes."""

    def __init__(
        self, target: str | Path, first: LiveFrame, rate: Fraction, options: WriteOptions, still: bool = False
    ) -> None:
        """Raises VidstyleError if the file exists, or cannot be written."""
        height, width = first.picture.shape
        encoding = first.picture.encoding
        tags = default_tags(encoding, height)
        info = VideoInfo(width, height, encoding, tags, TIME_BASE, rate, still=still)
        self._writer = open_writer(target, info, options)
        self._start: float | None = None
        self._duration = round(1 / (rate * TIME_BASE))
        self._convert(first)  # so that frames do not wait for what is compiled or allocated only once

    def write(self, frame: LiveFrame, number: int) -> None:
        """See Sink; the frame's own time counts instead of its number."""
        self._start = frame.captured if self._start is None else self._start
        pts = round((frame.captured - self._start) / TIME_BASE)
        self._writer.write(Frame(self._convert(frame), pts, TIME_BASE, self._duration))

    def push_audio(self, chunk: AudioChunk) -> None:
        """See Sink; sound before the first frame is left out."""
        if self._start is not None and self._writer is not None:
            self._writer.push_audio(chunk, chunk.time - self._start)

    def close(self) -> None:
        """See Sink."""
        self._writer.finish()

    def _convert(self, frame: LiveFrame) -> Picture:
        return convert(frame.picture, self._writer.encoding, self._writer.wants_rgb)


class NullTarget:
    """Discards every frame, for measurements."""

    name = "null"
    state = "running"
    dropped = repeated = 0

    def __init__(self, meter: LatencyMeter) -> None:
        self._meter = meter
        self.delivered = 0

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self.delivered += 1
        self._meter.record(frame.captured)

    def close(self) -> None:
        """See Target."""


TOLERANCE = 0.75
"""Share of a frame's duration by which it may miss its slot, so that jitter drops and repeats nothing."""
MAX_GAP = 1.0
"""Seconds without a write after which the reader itself has stood still; slots go on from there."""


class FramePacer:
    """Assigns frames to the slots of a constant rate.

    Attributes:
        last: number of the slot that was filled last; -1 before the first.
    """

    def __init__(self, rate: Fraction) -> None:
        self._rate = float(rate)
        self._start: float | None = None
        self.last = -1

    def slot(self, now: float) -> int | None:
        """The slot of a frame that arrives now, or None if it is too early and is dropped.

        Args:
            now: in seconds, of any monotonic clock.
        """
        next_slot = self.last + 1
        if self._start is None or now - self._time(next_slot) > MAX_GAP:
            self._start = now - next_slot / self._rate
        position = (now - self._start) * self._rate
        if position < next_slot - TOLERANCE:
            return None
        self.last = next_slot if position <= next_slot + TOLERANCE else round(position)
        return self.last

    def timeout(self, now: float) -> float | None:
        """Seconds until the last frame must be repeated, or None before the first."""
        return None if self._start is None else max(0.0, self._time(self.last + 1 + TOLERANCE) - now)

    def _time(self, slot: float) -> float:
        assert self._start is not None
        return self._start + slot / self._rate
