"""A renderer for the empty style that loads modules for restyling only if a picture must change."""

from __future__ import annotations

from concurrent.futures import Future

from vidstyle.backend import Backend, FrameRequest, completed_future
from vidstyle.core.picture import Picture
from vidstyle.style import Style


class PassthroughRenderer(Backend):
    """Returns pictures unchanged; opens a `CpuRenderer` for another encoding or style."""

    frames_in_flight = 0
    device_kind = "cpu"

    def __init__(self, style: Style) -> None:
        self.style = style
        self._renderer: Backend | None = None

    def cancel(self) -> None:
        """See `Backend.cancel`."""
        if self._renderer:
            self._renderer.cancel()

    def close(self) -> None:
        """End the threads, if there are any."""
        if self._renderer:
            self._renderer.close()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self.style = style
        if self._renderer:
            self._renderer.change_style(style)

    def restyle(self, request: FrameRequest) -> Picture:
        """Return the picture itself if the style changes nothing; see `Backend.restyle`."""
        if self._renderer is None:
            if request.is_passthrough(self.style):
                return request.picture
            from vidstyle.cpu.renderer import CpuRenderer

            self._renderer = CpuRenderer(self.style)
        return self._renderer.restyle(request)

    def begin(self, request: FrameRequest) -> Future[Picture]:
        """Return the result of `restyle` as a future."""
        return completed_future(self.restyle(request))
