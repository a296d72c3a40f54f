"""A renderer for the empty style that loads modules for restyling only if a picture must change."""

from __future__ import annotations

from concurrent.futures import Future
from typing import TYPE_CHECKING

from vidstyle.core.closing import Closing
from vidstyle.core.picture import Encoding, Picture
from vidstyle.style import Style

if TYPE_CHECKING:
    from vidstyle.cpu.renderer import CpuRenderer


class PassthroughRenderer(Closing):
    """Returns pictures unchanged; opens a `CpuRenderer` for another encoding or style.

    Attributes:
        frames_in_flight: see `CpuRenderer`.
    """

    frames_in_flight = 0

    def __init__(self, style: Style) -> None:
        self.style = style
        self._renderer: CpuRenderer | None = None

    def close(self) -> None:
        """End the threads, if there are any."""
        if self._renderer:
            self._renderer.close()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self.style = style
        if self._renderer:
            self._renderer.change_style(style)

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """Restyle a picture; see `Backend.run` for the arguments."""
        if self._renderer is None:
            if is_passthrough(picture, self.style, target, rgb):
                return picture
            from vidstyle.cpu.renderer import CpuRenderer

            self._renderer = CpuRenderer(self.style)
        return self._renderer.run(picture, time, target, rgb)

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Future[Picture]:
        """Return the result of `run` as a future."""
        return completed_future(self.run(picture, time, target, rgb))


def completed_future(picture: Picture) -> Future[Picture]:
    """Return a completed future with this result."""
    future: Future[Picture] = Future()
    future.set_result(picture)
    return future


def is_passthrough(picture: Picture, style: Style, target: Encoding | None, rgb: bool) -> bool:
    """Whether the result is the picture itself."""
    same = target in (None, picture.encoding) and rgb == (picture.color is not None)
    return style.is_plain and same
