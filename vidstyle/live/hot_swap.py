"""A renderer whose style can change between pictures."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from vidstyle.backend import Backend, FrameRequest
from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cues.cue_list import CueList
from vidstyle.cues.cue_renderer import CueRenderer
from vidstyle.errors import VidstyleError
from vidstyle.live.latest import DropOldestQueue
from vidstyle.media.resize import resize_picture
from vidstyle.renderer import open_renderer
from vidstyle.style import Style
from vidstyle.style.resolve import structure_key

MIN_SIDE = 16
"""Pixels of the smallest working size."""
SHARPENING_WEIGHT, SHARPENING_DEVIATION_PX = 0.6, 0.8
"""Unsharp mask of a reduced picture before it is enlarged, chosen by eye on `oil` and `comic` of a person of
500 lines, at 3/8 of 1280 x 960."""


class HotSwapRenderer:
    """Restyles pictures with a style that can change between them.

    If only numbers and colours change, the renderer continues with the new values (`Backend.change_style`).
    For another style, a second renderer is prepared in the background with the current picture, so that no
    frame waits for shaders to compile or files to load. A cue list is such a style; it starts with its first
    picture.

    Attributes:
        style: the one that runs.
        scale: the share of the width and the height to work at.
    """

    def __init__(self, style: Style | CueList, device: str, notify: Callable[[str], None]) -> None:
        """Defer opening the device to the first picture, so that errors of the source are reported first.

        Args:
            notify: receives the errors of styles that cannot be used; called from another thread.
        """
        self.style = self._requested = style
        self.scale = 1.0
        self._device, self._notify = device, notify
        self._renderer: Backend | None = None
        self._pending: Style | CueList | None = None
        self._ready: tuple[Style | CueList, Backend] | None = None
        self._lock = threading.Lock()
        self._requests: DropOldestQueue[tuple[Style | CueList, FrameRequest]] = DropOldestQueue()
        self._thread = threading.Thread(target=self._prepare_all, name="vidstyle prepare", daemon=True)
        self._thread.start()

    @property
    def preparing(self) -> str:
        """The name of the style that is being prepared, or ""."""
        pending = self._pending
        return pending.name if pending is not None else ""

    def has_request(self, style: Style | CueList) -> bool:
        """Whether this was the last style requested; a request arrives with the next picture."""
        return style is self._requested

    def run(
        self, picture: Picture, time: float, target: Encoding, style: Style | CueList | None
    ) -> tuple[Picture, bool]:
        """Restyle a picture; return it, and whether the style has changed.

        Args:
            picture: without alpha.
            time: of its capture, in seconds.
            target: the encoding of the result.
            style: the style requested; None: only convert the picture.

        Raises:
            VidstyleError: the device does not exist, or the first style is invalid.
        """
        if style is None:
            return convert(picture, target), False
        height, width = picture.shape
        small = picture if self.scale == 1 else resize_picture(picture, *self.working_size(width, height))
        request = FrameRequest(small, time, target, seen_side=min(picture.shape))
        if style is not self._requested:
            self._request(style, request)
        before = self.style
        self._swap(time)
        if self._renderer is None:
            self._renderer = open_renderer(self.style, self._device)
        result = self._renderer.restyle(request)
        if result.shape != picture.shape:
            result = resize_picture(sharpen_luma(result), width, height)
        return result, self.style is not before

    def working_size(self, width: int, height: int) -> tuple[int, int]:
        """Width and height that pictures of a size are restyled at."""
        if self.scale == 1:
            return width, height
        across, down = (max(MIN_SIDE, round(side * self.scale / 2) * 2) for side in (width, height))
        return min(across, width), min(down, height)

    def close(self, timeout: float) -> None:
        """Close the renderers; one that is still being prepared after `timeout` seconds is closed later."""
        self._requests.close()
        self._thread.join(timeout)
        if self._renderer is not None:
            self._renderer.close()

    def _request(self, style: Style | CueList, request: FrameRequest) -> None:
        self._requested = style
        with self._lock:
            if self._renderer is not None and _key(style) == _key(self._pending or self.style):
                return  # `_swap` takes the values
            self._pending = style
        self._requests.put((style, request))

    def _swap(self, time: float) -> None:
        """Take a renderer that is ready, and the values that were requested since; `time`: of the picture."""
        with self._lock:
            ready, self._ready = self._ready, None
            if ready is not None and ready[0] is self._pending:
                self._pending = None
            is_pending = self._pending is not None
        if ready is not None:
            if self._renderer is not None:
                self._renderer.close()
            self.style, self._renderer = ready
            if isinstance(self._renderer, CueRenderer):
                self._renderer.start_at(time)
        if self._renderer is None or is_pending or self.style is self._requested:
            return
        if isinstance(self._requested, Style) and _key(self.style) == _key(self._requested):
            self._renderer.change_style(self._requested)
            self.style = self._requested

    def _prepare_all(self) -> None:
        while not self._requests.exhausted:
            waiting = self._requests.get()
            if waiting is not None:
                self._prepare(*waiting)
        with self._lock:
            unused, self._ready = self._ready, None
        if unused is not None:
            unused[1].close()

    def _prepare(self, style: Style | CueList, request: FrameRequest) -> None:
        """Open a renderer and run it once, so that everything is compiled and loaded."""
        try:
            renderer = open_renderer(style, self._device, announce=False)
            renderer.restyle(request)
        except VidstyleError as error:
            with self._lock:
                self._pending = None if self._pending is style else self._pending
            self._notify(f"{error}; {self.style.name} continues")
            return
        with self._lock:
            replaced, self._ready = self._ready, (style, renderer)
        if replaced is not None:
            replaced[1].close()


def sharpen_luma(picture: Picture) -> Picture:
    """Return the picture with steeper edges, by an unsharp mask of its 8-bit luma."""
    import cv2

    low, high = picture.encoding.luma_levels

    def sharpen(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind != "luma":
            return plane
        soft = cv2.GaussianBlur(plane, (0, 0), SHARPENING_DEVIATION_PX, borderType=cv2.BORDER_REPLICATE)
        steep = cv2.addWeighted(plane, 1 + SHARPENING_WEIGHT, soft, -SHARPENING_WEIGHT, 0)
        return np.clip(steep, round(low), round(high))

    return picture.map_planes(sharpen)


def _key(style: Style | CueList) -> tuple[object, ...]:
    """Return a key that is equal if only numbers and colours differ; each cue list has another one."""
    return (id(style),) if isinstance(style, CueList) else structure_key(style)
