"""Restyles pictures on a GPU, one late, and goes on without it when it is lost."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TooLate
from typing import Protocol

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import DeviceError
from vidstyle.gpu.compile.plan import Form
from vidstyle.gpu.device.choose import Device
from vidstyle.gpu.session import FrameRequest, GpuSession, InFlightFrame
from vidstyle.style import Style

log = logging.getLogger("vidstyle")

HANG_SECONDS = 10.0
"""A GPU that gives no picture for so long is taken for lost; software, which may be slow, never is."""


class Fallback(Protocol):
    """What restyles pictures when the GPU no longer does."""

    def run(self, picture: Picture, time: float | None, target: Encoding | None, rgb: bool) -> Picture:
        """As `CpuRenderer.run`."""

    def close(self) -> None:
        """Let go."""


class PendingFrame:
    """A picture on its way; `result` waits for it."""

    def __init__(self, renderer: GpuRenderer, request: FrameRequest, session: GpuSession | None) -> None:
        self._renderer = renderer
        self.request = request
        self.session = session
        self.drawn: Future[InFlightFrame] | None = session.start(request) if session else None

    def result(self) -> Picture:
        """The restyled picture.

        Raises:
            DeviceError: neither the GPU nor the CPU can make it.
            StyleError: the style cannot be used.
        """
        return self._renderer.finish(self)


class GpuRenderer:
    """Restyles one picture after another with one style on a GPU.

    Start a picture before you ask for the result of the one before: then the GPU works on one while the
    other travels. When the context is lost or its memory runs out, it is opened once more; when that fails
    too, the substitute takes over.

    Attributes:
        frames_in_flight: how many pictures may be under way before a result is asked for.
    """

    frames_in_flight = 1

    def __init__(
        self, style: Style, device: Device, substitute: Callable[[], Fallback], form: Form | None = None
    ) -> None:
        self.style = style
        self._device, self._form = device, form
        self._make_substitute = substitute
        self._substitute: Fallback | None = None
        self._session: GpuSession | None = GpuSession(style, device, form)
        self._rebuilt = False

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> PendingFrame:
        """Send a picture and start its passes; the arguments are those of `run`."""
        return PendingFrame(self, FrameRequest(picture, time, target or picture.encoding, rgb), self._session)

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """The picture in the style, at its own size; waits for it.

        Args:
            picture: any picture; its planes are only read.
            time: presentation time in seconds, or None for a picture that stands alone.
            target: how the planes of the result are to be encoded; None: as the picture's own.
            rgb: packed RGB of the target's depth is wanted instead of luma and chroma.
        """
        return self.start(picture, time, target, rgb).result()

    def finish(self, pending: PendingFrame) -> Picture:
        """The result of a started picture, on whatever works by now."""
        while (session := self._session) is not None:
            if pending.session is not session:
                pending = PendingFrame(self, pending.request, session)
            try:
                return self._wait(pending)
            except (DeviceError, MemoryError, TooLate) as error:
                self._give_up(session, error)
        return self._run_substitute(pending.request)

    def close(self) -> None:
        """Let the context go."""
        if self._session is not None:
            self._session.close()
        if self._substitute is not None:
            self._substitute.close()

    def _wait(self, pending: PendingFrame) -> Picture:
        assert pending.drawn is not None and pending.session is not None
        seconds = None if self._device.software else HANG_SECONDS
        drawn = pending.drawn.result(seconds)
        return pending.session.fetch(drawn).result(seconds)

    def _give_up(self, session: GpuSession, error: Exception) -> None:
        """Leave a context that has failed: open it once more, and no more than once."""
        hangs = isinstance(error, TooLate)
        reason = f"no picture for {HANG_SECONDS:g} s" if hangs else str(error).partition("\n")[0]
        session.close()
        self._session = None
        if not (self._rebuilt or hangs):
            self._rebuilt = True
            try:
                self._session = GpuSession(self.style, self._device, self._form)
                log.warning("the GPU is lost (%s): opened again", reason)
                return
            except DeviceError as again:
                reason = again.reason
        log.warning("the GPU is lost (%s): the CPU goes on", reason)

    def _run_substitute(self, request: FrameRequest) -> Picture:
        try:
            self._substitute = self._substitute or self._make_substitute()
            return self._substitute.run(request.picture, request.time, request.target, request.rgb)
        except MemoryError:
            raise DeviceError("the GPU", "is lost, and there is no memory to go on without it") from None
