"""Restyles one picture after another with a style that may change between two of them."""

from __future__ import annotations

import threading
from collections.abc import Callable

from vidstyle.block import Asset, Color, Slider
from vidstyle.blocks import all_blocks
from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu import CpuRenderer
from vidstyle.errors import VidstyleError
from vidstyle.live.latest import DropOldestQueue
from vidstyle.media.resize import resized
from vidstyle.renderer import Backend, open_renderer
from vidstyle.style import LAYERS, Step, Style

MIN_SIDE = 16
"""Pixels that a working size keeps at least."""


class HotSwapRenderer:
    """Runs a style; another is made ready beside it, on the picture of that moment, before it takes over.

    On the CPU, where that takes no time, other numbers and colours of the same steps take over at once.

    Attributes:
        style: the one that runs.
        scale: share of the width and the height to work at.
    """

    def __init__(self, style: Style, device: str, tell: Callable[[str], None]) -> None:
        """Nothing is opened before the first picture: a source that is not there is told first.

        Args:
            tell: is told why a style that was asked for does not run; from another thread.
        """
        self.style = self._asked = style
        self.scale = 1.0
        self._device, self._tell = device, tell
        self._renderer: Backend | None = None
        self._ready: tuple[Style, Backend] | None = None
        self._awaited: Style | None = None
        self._lock = threading.Lock()
        self._wishes: DropOldestQueue[tuple[Style, Picture, float, Encoding]] = DropOldestQueue()
        self._thread = threading.Thread(target=self._prepare_all, name="vidstyle prepare", daemon=True)
        self._thread.start()

    def run(
        self, picture: Picture, time: float, target: Encoding, style: Style | None
    ) -> tuple[Picture, bool]:
        """The picture in the style that is ready, and whether that is another than before.

        Args:
            picture: without alpha.
            time: of its capture, in seconds.
            target: how the planes of the result are to be encoded.
            style: the one that is wanted; None: the picture as it is, in that encoding.

        Raises:
            VidstyleError: there is no such device, or the first style cannot be used.
        """
        if style is None:
            return convert(picture, target), False
        height, width = picture.shape
        small = picture if self.scale == 1 else resized(picture, *self._working_size(width, height))
        if style is not self._asked:
            self._ask(style, small, time, target)
        changed = self._take_over()
        if self._renderer is None:
            self._renderer = open_renderer(self.style, self._device)
        result = self._renderer.run(small, time, target)
        return resized(result, width, height), changed

    def working_size(self, width: int, height: int) -> tuple[int, int]:
        """Width and height that pictures of a size are restyled at."""
        return (width, height) if self.scale == 1 else self._working_size(width, height)

    def close(self, seconds: float) -> None:
        """Let the devices go."""
        self._wishes.close()
        self._thread.join(seconds)
        if not self._thread.is_alive():
            self._take_over()
            if self._renderer is not None:
                self._renderer.close()

    def _working_size(self, width: int, height: int) -> tuple[int, int]:
        across, down = (max(MIN_SIDE, round(side * self.scale / 2) * 2) for side in (width, height))
        return min(across, width), min(down, height)

    def _ask(self, style: Style, picture: Picture, time: float, target: Encoding) -> None:
        self._asked = style
        with self._lock:
            # What is still being made ready would take over later, though it was asked for earlier.
            if self._awaited is None and self._takes_values(style):
                self._ready = style, open_renderer(style, self._device, announce=False)
                return
            self._awaited = style
        self._wishes.put((style, picture, time, target))

    def _takes_values(self, style: Style) -> bool:
        return isinstance(self._renderer, CpuRenderer) and _structure(style) == _structure(self.style)

    def _take_over(self) -> bool:
        with self._lock:
            ready, self._ready = self._ready, None
            if ready is not None and ready[0] is self._awaited:
                self._awaited = None
        if ready is None:
            return False
        if self._renderer is not None:
            self._renderer.close()
        self.style, self._renderer = ready
        return True

    def _prepare_all(self) -> None:
        while not self._wishes.over:
            wish = self._wishes.take()
            if wish is not None:
                self._prepare(*wish)

    def _prepare(self, style: Style, picture: Picture, time: float, target: Encoding) -> None:
        """Open a renderer and let it do all that it does only for the first picture."""
        try:
            renderer = open_renderer(style, self._device, announce=False)
            renderer.run(picture, time, target)
        except VidstyleError as error:
            self._tell(f"{error}; {self.style.name} goes on")
            with self._lock:
                self._awaited = None if self._awaited is style else self._awaited
            return
        with self._lock:
            before, self._ready = self._ready, (style, renderer)
        if before is not None:
            before[1].close()


def _structure(style: Style) -> tuple[object, ...]:
    """All of a style but numbers and colours: while it stays, there is nothing to load."""
    layers = [[_step_structure(step) for step in getattr(style, layer)] for layer in LAYERS]
    return style.is_plain, style.steady > 0, layers


def _step_structure(step: Step) -> tuple[object, ...]:
    block = all_blocks().get(step.block)
    kept: dict[str, object] = {}
    for name, parameter in block.parameters.items() if block else ():
        value = step.values.get(name, parameter.default)
        if isinstance(parameter.control, Asset) and value and value not in parameter.control.shipped():
            value = object()  # somebody's file, which may have become another: never alike
        if not isinstance(parameter.control, Slider | Color):
            kept[name] = value
    return step.block, step.save, step.source, step.on, kept
