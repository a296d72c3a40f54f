"""Restyles pictures on a GPU, and on the CPU when the GPU is lost."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout

from vidstyle.backend import Backend, FrameRequest
from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import SceneCuts
from vidstyle.errors import DeviceError, log
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.device.devices import Device
from vidstyle.gpu.session import GpuSession, InFlightFrame
from vidstyle.style import Style
from vidstyle.style.wiring import needs_cpu

HANG_SECONDS = 10.0
"""A GPU counts as lost after this time without a picture. Software renderers may be slow and never count as
lost."""


class PendingFrame:
    """A picture that is being restyled; `result` waits for it."""

    def __init__(
        self, renderer: GpuRenderer, style: Style, request: FrameRequest, session: GpuSession | None
    ) -> None:
        self._renderer = renderer
        self.style, self.request = style, request
        self.session = session
        self.started: Future[InFlightFrame] | None = session.start(style, request) if session else None

    def result(self) -> Picture:
        """The restyled picture.

        Raises:
            DeviceError: neither the GPU nor the CPU can restyle it.
            StyleError: the style cannot be used.
        """
        return self._renderer.finish(self)


class GpuRenderer(Backend):
    """Restyles one picture after another on a GPU.

    Start a picture before requesting the result of the previous one: the GPU then works on one picture while
    the other is transferred. If the context is lost or out of memory, it is reopened once; after a second
    failure the fallback takes over.

    Args:
        fallback: creates the fallback renderer for a style.
        form: form of the passes; None for the best form of the device.
        cuts: scene cuts of the film; None: they are detected.
    """

    frames_in_flight = 1
    device_kind = "gpu"

    def __init__(
        self,
        style: Style,
        device: Device,
        fallback: Callable[[Style], Backend],
        form: Form | None = None,
        cuts: SceneCuts | None = None,
    ) -> None:
        self._style = style
        self._device, self._form, self._cuts = device, form, cuts
        self._make_fallback = fallback
        self._fallback: Backend | None = None
        self._session: GpuSession | None = GpuSession(device, form, cuts=cuts)
        self._reopened = False

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self._style = style

    def begin(self, request: FrameRequest) -> PendingFrame:
        """Upload a picture and start its passes."""
        request.edited()  # here, as the thread of the context has more to do
        if not needs_cpu(self._style):
            return PendingFrame(self, self._style, request, self._session)
        log.info("%s has a network: it runs on the CPU", self._style.name, extra={"once": True})
        return PendingFrame(self, self._style, request, None)

    def cancel(self) -> None:
        """Do nothing: a started picture is finished soon."""

    def finish(self, pending: PendingFrame) -> Picture:
        """Return the result of a started picture; restyle it again if the context was lost since."""
        while not needs_cpu(pending.style) and (session := self._session) is not None:
            if pending.session is not session:
                pending = PendingFrame(self, pending.style, pending.request, session)
            try:
                return self._wait(pending)
            except (DeviceError, MemoryError, FutureTimeout) as error:
                self._reopen(session, error)
        return self._run_fallback(pending)

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
                self._session = GpuSession(self._device, self._form, cuts=self._cuts)
                log.warning("the GPU is lost (%s): reopened", reason)
                return
            except DeviceError as again:
                reason = again.reason
        log.warning("the GPU is lost (%s): continuing on the CPU", reason)

    def _run_fallback(self, pending: PendingFrame) -> Picture:
        try:
            self._fallback = self._fallback or self._make_fallback(pending.style)
            self._fallback.change_style(pending.style)
            return self._fallback.restyle(pending.request)
        except MemoryError:
            raise DeviceError(
                "the GPU", "is lost, and there is not enough memory to continue on the CPU"
            ) from None
