"""Restyles pictures on a GPU, and on the CPU when the GPU is lost."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout
from typing import Protocol

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import DeviceError, log
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.device.devices import Device
from vidstyle.gpu.session import FrameRequest, GpuSession, InFlightFrame
from vidstyle.style import Style

HANG_SECONDS = 10.0
"""A GPU counts as lost after this time without a picture. Software renderers may be slow and never count as
lost."""


class Fallback(Protocol):
    """The renderer that takes over when the GPU is lost; see `Backend`."""

    def change_style(self, style: Style) -> None: ...

    def run(self, picture: Picture, time: float | None, target: Encoding | None, rgb: bool) -> Picture: ...

    def close(self) -> None: ...


class PendingFrame:
    """A picture that is being restyled; `result` waits for it."""

    def __init__(self, renderer: GpuRenderer, request: FrameRequest, session: GpuSession | None) -> None:
        self._renderer = renderer
        self.request = request
        self.session = session
        self.started: Future[InFlightFrame] | None = session.start(request) if session else None

    def result(self) -> Picture:
        """The restyled picture.

        Raises:
            DeviceError: neither the GPU nor the CPU can restyle it.
            StyleError: the style cannot be used.
        """
        return self._renderer.finish(self)


class GpuRenderer:
    """Restyles one picture after another on a GPU; implements `Backend`.

    Start a picture before requesting the result of the previous one: the GPU then works on one picture while
    the other is transferred. If the context is lost or out of memory, it is reopened once; after a second
    failure the fallback takes over.

    Args:
        fallback: creates the fallback renderer for a style.
        form: form of the passes; None for the best form of the device.
    """

    frames_in_flight = 1

    def __init__(
        self, style: Style, device: Device, fallback: Callable[[Style], Fallback], form: Form | None = None
    ) -> None:
        self._style = style
        self._device, self._form = device, form
        self._make_fallback = fallback
        self._fallback: Fallback | None = None
        self._session: GpuSession | None = GpuSession(device, form)
        self._reopened = False

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self._style = style

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> PendingFrame:
        """Upload a picture and start its passes."""
        request = FrameRequest(self._style, picture, time, target or picture.encoding, rgb)
        return PendingFrame(self, request, self._session)

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """Restyle a picture and wait for it."""
        return self.start(picture, time, target, rgb).result()

    def finish(self, pending: PendingFrame) -> Picture:
        """Return the result of a started picture; restyle it again if the context was lost since."""
        while (session := self._session) is not None:
            if pending.session is not session:
                pending = PendingFrame(self, pending.request, session)
            try:
                return self._wait(pending)
            except (DeviceError, MemoryError, FutureTimeout) as error:
                self._reopen(session, error)
        return self._run_fallback(pending.request)

    def close(self) -> None:
        """Close the context and the fallback."""
        for each in (self._session, self._fallback):
            if each is not None:
                each.close()

    def _wait(self, pending: PendingFrame) -> Picture:
        assert pending.started is not None and pending.session is not None
        seconds = None if self._device.software else HANG_SECONDS
        return pending.session.fetch(pending.started.result(seconds)).result(seconds)

    def _reopen(self, session: GpuSession, error: Exception) -> None:
        """Close a context that has failed and reopen it, once."""
        hangs = isinstance(error, FutureTimeout)
        reason = f"no picture for {HANG_SECONDS:g} s" if hangs else str(error).partition("\n")[0]
        session.close()
        self._session = None
        if not (self._reopened or hangs):
            self._reopened = True
            try:
                self._session = GpuSession(self._device, self._form)
                log.warning("the GPU is lost (%s): reopened", reason)
                return
            except DeviceError as again:
                reason = again.reason
        log.warning("the GPU is lost (%s): continuing on the CPU", reason)

    def _run_fallback(self, request: FrameRequest) -> Picture:
        try:
            self._fallback = self._fallback or self._make_fallback(request.style)
            self._fallback.change_style(request.style)
            return self._fallback.run(request.picture, request.time, request.target, request.rgb)
        except MemoryError:
            raise DeviceError(
                "the GPU", "is lost, and there is not enough memory to continue on the CPU"
            ) from None
