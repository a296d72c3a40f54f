"""A live session: the newest picture of a source, restyled, to all targets."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from vidstyle.live.audio import AudioRouter
from vidstyle.live.capture import Capture
from vidstyle.live.control import Controls, Status
from vidstyle.live.meter import Meter, RateMeter
from vidstyle.live.options import LiveOptions, TargetContext
from vidstyle.live.process import FrameProcessor
from vidstyle.live.recorder import Recorder
from vidstyle.live.summary import LiveSummary
from vidstyle.live.target import LiveFrame, Target
from vidstyle.live.target_group import TargetGroup
from vidstyle.media.audio import AudioChunk
from vidstyle.media.capture.input import CapturedFrame, LiveSource

log = logging.getLogger("vidstyle")

DEFAULT_RATE = Fraction(30)
WATCH_SECONDS = 0.1
END_SECONDS = 2.0


class LiveSession:
    """One run from a source to targets; `run` takes it to its end."""

    def __init__(
        self,
        source: LiveSource,
        controls: Controls,
        makers: Sequence[Callable[[TargetContext], Target]],
        options: LiveOptions | None = None,
    ) -> None:
        """Nothing is opened before `run`.

        Args:
            makers: each makes a target once the first picture tells what it is to take.
        """
        self._source, self._controls = source, controls
        self._destinations = TargetGroup(makers)
        self._message = ""
        self._options = options or LiveOptions()
        self._restyling = FrameProcessor(controls, self._options, self._tell)
        self._sound = AudioRouter(self._options, self._push_audio)
        self._capture = Capture(source, self._sound.push_audio)
        self._meter, self._restyled, self._pace = Meter(), Meter(), RateMeter()
        self._keepsakes = Recorder(self._tell)
        self._rate = self._options.rate or DEFAULT_RATE
        self._began: float | None = None
        self._frames = self._unready = 0
        self._over = threading.Event()
        self._error: BaseException | None = None
        controls.attach(self.status)

    def run(self, stop: threading.Event, watch: Callable[[], None] | None = None) -> LiveSummary:
        """Go on until the source ends, somebody quits, or `stop` is set; all targets are closed then.

        Args:
            watch: called about ten times a second from this thread.

        Raises:
            VidstyleError: the source never gave a picture, there is no such device, or no target is left.
        """
        style = threading.Thread(target=self._guarded, name="vidstyle style", daemon=True)
        self._capture.start()
        self._sound.start()
        style.start()
        try:
            while not self._over.wait(WATCH_SECONDS) and not stop.is_set() and not self._is_done():
                if watch is not None:
                    watch()
        finally:
            self._over.set()
            style.join(END_SECONDS)
            self._close(idle=not style.is_alive())
        if self._error is not None:
            raise self._error
        return self._summary()

    def status(self) -> Status:
        """How it is now."""
        return Status(
            style=self._restyling.style,
            bypass=self._controls.bypassed,
            source=self._source.name,
            source_state=self._capture.state,
            size=self._restyling.size,
            frames=self._frames,
            dropped=self._dropped,
            repeated=self._destinations.repeated,
            rate=self._pace.now,
            latency_ms=self._restyled.recent_latency(),
            given_up=self._restyling.given_up,
            targets=self._destinations.states,
            recording=self._keepsakes.recording,
            message=self._message,
        )

    @property
    def _dropped(self) -> int:
        return self._capture.pictures.dropped - self._unready

    def _is_done(self) -> bool:
        now, options = time.monotonic(), self._options
        if self._controls.quitting.is_set():
            return True
        self._error = self._error or self._capture.failure
        if self._error is not None:
            return True
        return options.seconds is not None and now - (self._began or now) >= options.seconds

    def _guarded(self) -> None:
        try:
            self._style_all()
        except BaseException as error:  # a thread's error is raised again in the calling thread
            self._error = error
        finally:
            self._over.set()

    def _style_all(self) -> None:
        pictures = self._capture.pictures
        while not self._over.is_set() and not pictures.over:
            captured = pictures.take(WATCH_SECONDS)
            if captured is not None:
                self._style(captured)
                if self._frames == self._options.frames:
                    return
        if self._capture.error is not None:
            raise self._capture.error

    def _style(self, captured: CapturedFrame) -> None:
        begin = time.monotonic()
        picture = self._restyling.frame(captured, self._capture, self._source.name)
        frame = LiveFrame(picture, captured.time, self._frames)
        if self._began is None:
            frame = self._begin(frame)
            begin = time.monotonic()
        self._restyled.delivered(frame.captured)
        self._destinations.offer(frame)
        self._keepsakes.offer(frame, self._controls, self._rate)
        self._frames += 1
        self._pace.count()
        self._restyling.took(time.monotonic() - begin)

    def _begin(self, frame: LiveFrame) -> LiveFrame:
        """Open the targets with the first frame, whose time begins when all is ready.

        What came while the style and the targets were made ready is not counted as dropped.
        """
        self._rate = self._options.rate or self._capture.rate or DEFAULT_RATE
        self._restyling.hold(self._rate)
        sound = self._sound.wait(self._capture.has_sound)
        setting = TargetContext(frame, self._rate, self._meter, self._controls, sound)
        self._keepsakes.sound = sound
        self._destinations.open(setting)
        self._capture.pictures.take(0)
        self._began, self._unready = time.monotonic(), self._capture.pictures.dropped
        return replace(frame, captured=self._began)

    def _push_audio(self, chunk: AudioChunk) -> None:
        """Pass sound on to the targets that take any; called from the thread that takes it."""
        self._destinations.push_audio(chunk)
        self._keepsakes.push_audio(chunk)

    def _tell(self, message: str) -> None:
        """Say something, here and in the status; from any thread."""
        self._message = message
        log.info(message)

    def _close(self, idle: bool) -> None:
        """Let go of everything; of what restyles only when it is `idle`, for else it still works there."""
        self._capture.close(END_SECONDS)
        self._sound.close(END_SECONDS)
        failure = self._destinations.close()
        self._keepsakes.close()
        if idle:
            self._restyling.close(END_SECONDS)
        self._error = self._error or failure

    def _summary(self) -> LiveSummary:
        return LiveSummary(
            source=self._source.name,
            frames=self._frames,
            dropped=self._dropped,
            elapsed=0.0 if self._began is None else time.monotonic() - self._began,
            restyled_ms=self._restyled.latency(),
            latency_ms=self._meter.latency(),
            size=self._restyling.size,
            rate=float(self._rate),
            given_up=self._restyling.given_up,
            deliveries=self._destinations.deliveries,
        )
