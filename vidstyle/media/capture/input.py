"""Live input: the interface of sources, and decoding without delay with capture times."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import av

from vidstyle.core.machine.cores import imposed_threads
from vidstyle.errors import DeviceError, InputError, VidstyleError, error_reason, log
from vidstyle.media.audio import AudioChunk, SourceAudio, find_audio_stream
from vidstyle.media.capture.monotonic import Clock
from vidstyle.media.rational import to_fraction
from vidstyle.media.read.source import choose_stream, frame_rate

MAX_STAMP_AGE_SECONDS = 2.0
"""A driver's timestamp is a capture time of a clock if its age on that clock is below this."""


class OpenedSource(Protocol):
    """An open stream of frames or of audio."""

    def close(self) -> None:
        """Close the stream, from the thread that reads it."""


T = TypeVar("T", bound=OpenedSource)
T_co = TypeVar("T_co", bound=OpenedSource, covariant=True)


class CaptureSource(Protocol[T_co]):
    """A source that can be opened, and reopened after a connection loss."""

    @property
    def name(self) -> str:
        """The name for messages."""

    @property
    def reconnects(self) -> bool:
        """Whether to reopen the source after a connection loss."""

    def open(self, stopping: threading.Event, clock: Clock) -> T_co:
        """Open the source and start capturing.

        Args:
            stopping: when set, opening is cancelled and the open stream ends.
            clock: for timestamps and pacing.

        Raises:
            DeviceError: a device is missing or busy.
            InputError: any other source cannot be read.
        """


WaitForFrame = Callable[[threading.Event, float], bool]
"""Wait for data until a timeout in seconds or until the event is set; return whether there is data."""
FIRST_FRAME_TIMEOUT_SECONDS, STALL_TIMEOUT_SECONDS = 5.0, 2.0
"""Timeouts of a driver: for its first frame, and for each later one (plus one frame interval)."""


@dataclass(frozen=True)
class CapturedFrame:
    """A captured frame.

    Attributes:
        native: the decoded frame.
        time: capture time, in seconds of `time.monotonic`.
    """

    native: av.VideoFrame
    time: float


class LiveInput:
    """Decodes one video stream without delay. Iterate over it once, in one thread.

    Attributes:
        codec: FFmpeg's name of the decoder.
        rate: frames per second, or None if unknown.
        sample_aspect: sample aspect ratio (width / height), or None.
        has_sound: whether audio is delivered along with the frames.
    """

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        stopping: threading.Event,
        clock: Clock,
        *,
        paced: bool = False,
        loop: bool = False,
        stamped: bool = False,
        sound: bool = False,
        wait: WaitForFrame | None = None,
        timeout: float | None = None,
    ) -> None:
        """Read from an open container, which `close` closes.

        Args:
            stopping: ends the iteration; may be set from any thread.
            clock: for timestamps and pacing.
            paced: whether frames are delivered in real time, by their timestamps.
            loop: whether to start again at the end.
            stamped: whether the driver's timestamps are capture times of the monotonic clock.
            sound: whether to decode audio, too.
            wait: waits for the next packet, so that reading does not block in the driver.
            timeout: seconds without a packet after which the source is lost.

        Raises:
            InputError: it has no video stream.
        """
        self._container, self._name = container, name
        try:
            self._stream = choose_stream(container, name)
        except InputError:
            container.close()
            raise
        context: Any = self._stream.codec_context
        context.thread_count = imposed_threads()
        if not paced:
            # Each thread of frame threading would delay the output by a frame.
            context.thread_type = "SLICE"
            context.flags |= av.codec.context.Flags.low_delay
        self._context = context
        heard = find_audio_stream(container) if sound else None
        self._audio = SourceAudio(heard) if heard else None
        self.has_sound = heard is not None
        self._loop, self._stamped = loop, stamped
        self._pace = PlaybackClock() if paced else None
        self._stopping, self._clock, self._wait, self._timeout = stopping, clock, wait, timeout
        self.codec = str(context.name)
        self.rate = frame_rate(self._stream)
        self.sample_aspect = to_fraction(self._stream.sample_aspect_ratio or 0) or None

    def __iter__(self) -> Iterator[CapturedFrame | AudioChunk]:
        """Yield frames and audio until the source ends.

        Raises:
            InputError: the connection was lost.
            DeviceError: the driver delivers no more frames.
        """
        while not self._stopping.is_set():
            try:
                yield from self._read_once()
                if not self._loop:
                    return
                self._container.seek(0)
            except VidstyleError:
                raise
            except (av.FFmpegError, OSError) as error:
                raise lost_source_error(self._name, error) from error
            self._context.flush_buffers()
            if self._pace:
                self._pace.restart()
            if self._audio:
                self._audio.restart()

    def close(self) -> None:
        """Close the source; call it after the iteration."""
        self._container.close()

    def _read_once(self) -> Iterator[CapturedFrame | AudioChunk]:
        packets = self._container.demux([self._stream, *([self._audio.stream] if self._audio else [])])
        for packet in self._wait_for_packets(packets):
            if self._audio is not None and packet.stream_index != self._stream.index:
                yield from self._audio.decode(packet)
                continue
            for captured in self._decode(packet):
                stamp = _stamp_seconds(captured.native)
                if self._audio is not None and stamp is not None:
                    self._audio.set_origin(stamp, captured.time)
                yield captured
            if self._stopping.is_set():
                return

    def _wait_for_packets(self, packets: Iterator[av.Packet]) -> Iterator[av.Packet]:
        if self._wait is None:
            yield from self._detect_stall(packets)
            return
        seconds = FIRST_FRAME_TIMEOUT_SECONDS
        while self._wait(self._stopping, seconds):
            packet = next(packets, None)
            if packet is None:
                return
            yield packet
            seconds = STALL_TIMEOUT_SECONDS + (float(1 / self.rate) if self.rate else 0.0)
        if not self._stopping.is_set():
            raise DeviceError(self._name, f"has delivered no frame for {seconds:.1f} s")

    def _detect_stall(self, packets: Iterator[av.Packet]) -> Iterator[av.Packet]:
        asked = self._clock.now()
        for packet in packets:
            if self._timeout is not None and self._clock.now() - asked >= self._timeout:
                raise InputError(self._name, f"was lost: no data for {self._timeout:g} s")
            yield packet
            asked = self._clock.now()

    def _decode(self, packet: av.Packet) -> Iterator[CapturedFrame]:
        arrived = self._clock.now()
        try:
            frames = self._context.decode(packet if packet.size else None)
        except av.InvalidDataError as error:  # one frame is lost, not the stream
            log.debug("a packet could not be decoded: %s", error)
            return
        except av.EOFError:
            return
        for frame in frames:
            if self._pace is not None:
                self._clock.wait(self._stopping, self._pace.until(_stamp_seconds(frame), self._clock.now()))
                arrived = self._clock.now()
            yield CapturedFrame(frame, _capture_time(frame, arrived) if self._stamped else arrived)


def lost_source_error(name: str, error: Exception) -> InputError:
    """Return the error for a source that can no longer be read."""
    return InputError(name, f"was lost: {error_reason(error)}")


def _stamp_seconds(frame: av.VideoFrame) -> float | None:
    return None if frame.pts is None or frame.time_base is None else float(frame.pts * frame.time_base)


def _capture_time(frame: av.VideoFrame, arrived: float) -> float:
    """Return the capture time of a frame: its timestamp if plausible, else its arrival."""
    stamp = _stamp_seconds(frame)
    return stamp if stamp is not None and 0 <= arrived - stamp < MAX_STAMP_AGE_SECONDS else arrived


LiveSource = CaptureSource[LiveInput]
"""A source of live video."""


MAX_PACED_GAP_SECONDS = 10.0
"""A larger gap between two timestamps restarts the clock."""


class PlaybackClock:
    """Paces frames in real time by their timestamps."""

    def __init__(self) -> None:
        self._origin: float | None = None
        self._last = self._step = self._due = 0.0

    def until(self, stamp: float | None, now: float) -> float:
        """Return the seconds until a frame with this timestamp is due; 0 if it is late."""
        if stamp is None:
            return 0.0
        if self._origin is None or not -1 < stamp - self._last < MAX_PACED_GAP_SECONDS:
            self._origin = max(now, self._due + self._step) - stamp
        elif stamp > self._last:
            self._step = stamp - self._last
        self._last, self._due = stamp, self._origin + stamp
        return max(0.0, self._due - now)

    def restart(self) -> None:
        """Restart the clock: the next frame is due one frame interval after the last one."""
        self._origin = None
