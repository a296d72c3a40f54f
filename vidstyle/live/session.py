"""A live session: the newest frame of a source, restyled, to all targets."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from vidstyle.errors import log
from vidstyle.live.capture import Capture, MicrophoneCapture, ReconnectingSource
from vidstyle.live.control import Controls, LiveOptions, Status
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.process import FrameProcessor
from vidstyle.live.recorder import Recorder
from vidstyle.live.target import LiveFrame, Target, TargetContext
from vidstyle.live.targets import Delivery, TargetGroup
from vidstyle.media.audio import AudioChunk
from vidstyle.media.capture.input import CapturedFrame, LiveSource
from vidstyle.media.capture.monotonic import MONOTONIC, Clock

DEFAULT_RATE = Fraction(30)
POLL_SECONDS = 0.1
"""Interval at which the end of the session is checked for."""
END_SECONDS = 2.0
"""Time that each part of the session may take to stop."""


class LiveSession:
    """One run from a source to targets."""

    def __init__(
        self,
        source: LiveSource,
        controls: Controls,
        makers: Sequence[Callable[[TargetContext], Target]],
        options: LiveOptions | None = None,
        clock: Clock = MONOTONIC,
    ) -> None:
        """Store the arguments; devices are opened in `run`.

        Args:
            makers: each makes a target once the first frame is known.
            clock: by which the session goes, its threads included.
        """
        self._source, self._controls, self._clock = source, controls, clock
        self._options = options or LiveOptions()
        self._message = self._hint = ""
        self._targets = TargetGroup(makers)
        self._processor = FrameProcessor(controls, self._options, self._notify)
        microphone = self._options.microphone if self._options.sound else None
        self._microphone = MicrophoneCapture(microphone, self._push_audio, clock) if microphone else None
        self._capture = Capture(source, self._push_source_audio, clock)
        self._inputs: list[ReconnectingSource[Any]] = [self._capture]
        self._inputs += [self._microphone] if self._microphone else []
        self._delivered, self._restyled = LatencyMeter(clock), LatencyMeter(clock)
        self._recorder = Recorder(self._notify, controls.recorded.append)
        self._context: TargetContext | None = None
        self._began: float | None = None
        self._frames = self._dropped_at_start = 0
        self._ended = threading.Event()
        self._error: BaseException | None = None
        controls.status = self.status

    def run(self, stop: threading.Event, hint: str = "") -> LiveSummary:
        """Run until the source ends, the user quits, or `stop` is set; then close all targets.

        Args:
            hint: a message to log once all targets are open.

        Raises:
            VidstyleError: no frame was captured, the device does not exist, or all targets failed.
        """
        self._hint = hint
        worker = threading.Thread(target=self._run_worker, name="vidstyle style", daemon=True)
        for each in self._inputs:
            each.start()
        worker.start()
        try:
            while not (self._clock.wait(self._ended, POLL_SECONDS) or stop.is_set() or self._is_done()):
                pass
        finally:
            self._ended.set()
            for each in self._inputs:
                each.close(END_SECONDS)
            worker.join(END_SECONDS)
            self._close()
        if self._error is not None:
            raise self._error
        return self._summary()

    def status(self) -> Status:
        """The present status."""
        return Status(
            style=self._processor.style,
            preparing=self._processor.preparing,
            bypass=self._controls.bypassed,
            split=self._controls.split,
            source=self._source.name,
            source_state=self._capture.state,
            size=self._processor.size,
            frames=self._frames,
            dropped=self._dropped,
            repeated=sum(delivery.repeated for delivery in self._targets.deliveries),
            rate=self._restyled.rate,
            latency_ms=self._restyled.recent_latency(),
            degraded=self._processor.degraded,
            full_size=self._controls.full_size,
            targets=self._targets.states,
            recording=self._recorder.recording,
            recorded=tuple(path.name for path in self._controls.recorded),
            message=self._message,
        )

    @property
    def _dropped(self) -> int:
        return self._capture.frames.dropped - self._dropped_at_start

    def _is_done(self) -> bool:
        now, seconds = self._clock.now(), self._options.seconds
        self._error = self._error or self._capture.startup_error
        is_over = seconds is not None and now - (self._began or now) >= seconds
        return self._controls.quitting.is_set() or self._error is not None or is_over

    def _run_worker(self) -> None:
        frames = self._capture.frames
        try:
            while not (self._ended.is_set() or frames.exhausted or self._frames == self._options.frames):
                captured = frames.get()
                if captured is not None:
                    self._process(captured)
            self._error = self._error or self._capture.error
        except BaseException as error:  # raised again in the calling thread
            self._error = error
        finally:
            self._ended.set()
            self._processor.close(END_SECONDS)  # here, as a long frame may outlast the session

    def _process(self, captured: CapturedFrame) -> None:
        begin = self._clock.now()
        frame = self._restyle(captured)
        if self._context is None:
            self._context = self._open_targets(frame)
            self._began = begin = self._clock.now()
            frame = replace(self._newest_of(frame), captured=begin)
        self._restyled.record(frame.captured)
        self._targets.offer(frame)
        self._recorder.offer(frame, self._context)
        self._processor.record_time(self._clock.now() - begin)
        self._frames += 1

    def _restyle(self, captured: CapturedFrame) -> LiveFrame:
        picture = self._processor.process(captured, self._capture, self._source.name)
        shown = self._processor
        return LiveFrame(picture, captured.time, self._frames, shown.original, shown.style, shown.undivided)

    def _newest_of(self, first: LiveFrame) -> LiveFrame:
        """Return the newest frame that arrived while targets were opened, or the first.

        It may be the last one of the source, so it is not discarded. Those before it do not count as dropped.
        """
        captured = self._capture.frames.get(0)
        self._dropped_at_start = self._capture.frames.dropped
        return self._restyle(captured) if captured else first

    def _open_targets(self, frame: LiveFrame) -> TargetContext:
        """Open the targets with the first frame; the time of the output begins when all are open."""
        rate = self._options.rate or self._capture.rate or DEFAULT_RATE
        sound = self._options.sound and (self._capture.has_sound or self._microphone is not None)
        if self._microphone is not None:
            self._microphone.wait()
        context = TargetContext(frame, rate, self._delivered, self._controls, sound, self._clock)
        self._processor.set_rate(rate)
        self._targets.open(context)
        if self._hint:
            log.info(self._hint)
        return context

    def _push_source_audio(self, chunk: AudioChunk) -> None:
        if self._microphone is None:
            self._push_audio(chunk)

    def _push_audio(self, chunk: AudioChunk) -> None:
        """Pass sound on; called from the thread that captures it."""
        self._targets.push_audio(chunk)
        self._recorder.push_audio(chunk)

    def _notify(self, message: str) -> None:
        """Show a message to the user, in the log and the status; thread-safe."""
        self._message = message
        log.info(message)

    def _close(self) -> None:
        """Close all targets."""
        error = self._targets.close()
        self._recorder.close()
        self._error = self._error or error

    def _summary(self) -> LiveSummary:
        rate = float(self._context.rate if self._context else self._options.rate or DEFAULT_RATE)
        totals = {"rate": rate, "latency_ms": self._delivered.latency()}
        return LiveSummary(
            **vars(self.status()) | totals,
            elapsed=0.0 if self._began is None else self._clock.now() - self._began,
            restyled_ms=self._restyled.latency(),
            deliveries=self._targets.deliveries,
        )


@dataclass(frozen=True, kw_only=True)
class LiveSummary(Status):
    """The final status of a session, with totals.

    Attributes:
        elapsed: seconds from the first frame to the end.
        restyled_ms: median and 99th percentile from capture until a frame is restyled.
        latency_ms: the same until a target has written it, of all frames; 0 if no target records it.
        rate: frames per second that the targets were opened for.
        deliveries: for each target.
    """

    elapsed: float
    restyled_ms: tuple[float, float]
    deliveries: tuple[Delivery, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the summary as plain values for JSON."""
        return {
            "source": self.source,
            "frames": self.frames,
            "dropped": self.dropped,
            "repeated": self.repeated,
            "elapsed": round(self.elapsed, 3),
            "fps": round(self.frames / self.elapsed, 2) if self.elapsed > 0 else 0.0,
            "rate": round(self.rate, 3),
            "restyled_ms": _as_dict(self.restyled_ms),
            "latency_ms": _as_dict(self.latency_ms),
            "size": list(self.size),
            "given_up": self.degraded,
            "targets": [vars(delivery) for delivery in self.deliveries],
        }

    def lines(self) -> list[str]:
        """Return the summary as lines of text."""
        lost = f"{self.dropped} dropped, {self.repeated} repeated"
        first = f"{self.frames} frames in {self.elapsed:.1f} s, {lost}"
        restyled = "capture to restyled: " + _text(self.restyled_ms)
        delivered = "capture to delivered: " + _text(self.latency_ms)
        return [first, restyled, *([delivered] if any(self.latency_ms) else []), *map(str, self.deliveries)]


def _as_dict(latency: tuple[float, float]) -> dict[str, float]:
    return {"median": round(latency[0], 2), "p99": round(latency[1], 2)}


def _text(latency: tuple[float, float]) -> str:
    return f"median {latency[0]:.1f} ms, 99 % within {latency[1]:.1f} ms"
