"""Pictures rendered by the server: previews of frames, thumbnails of steps, exact results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction
from time import perf_counter

import numpy as np

from vidstyle.core.cores import available_cores
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.cpu.step_pictures import step_pictures
from vidstyle.design.working_size import WorkingSize
from vidstyle.preview.clip import Clip
from vidstyle.renderer import Backend, open_renderer
from vidstyle.style import Style
from vidstyle.style.nodes import StepKey

MAX_LARGE_SECONDS = 0.5
"""Target time for a preview while nothing changes."""
_RGB_ENCODING = Encoding(full_range=True, depth=8, step=(1, 1))


class Restyler:
    """Renders previews. All methods must be called from the same thread.

    Attributes:
        size: the size of previews during edits.
    """

    def __init__(self, device: str) -> None:
        """`device`: see `open_renderer`."""
        self._device = device
        self._backend: Backend | None = None
        self.size = WorkingSize()

    def render_preview(self, style: Style, clip: Clip, number: int, side: int) -> np.ndarray:
        """Render a frame fast enough to follow a slider, of at most `side`; H x W x 3 uint8."""
        aspect = max(clip.size) / min(clip.size)
        return self._render(style, clip, number, self.size.side(side, aspect))

    def render_large(self, style: Style, clip: Clip, number: int, side: int) -> np.ndarray:
        """Render a frame at a larger size, within `MAX_LARGE_SECONDS`; H x W x 3 uint8."""
        aspect = max(clip.size) / min(clip.size)
        return self._render(style, clip, number, self.size.side(side, aspect, MAX_LARGE_SECONDS))

    def _render(self, style: Style, clip: Clip, number: int, side: int) -> np.ndarray:
        style = replace(style, steady=0.0)
        frame = clip.frame(number, side)
        if self._backend is None:
            self._backend = open_renderer(style, self._device, announce=False)
        self._backend.change_style(style)
        began = perf_counter()
        color = _run(self._backend, frame, None)
        self.size.record(frame.shape[0] * frame.shape[1], perf_counter() - began)
        return color

    def close(self) -> None:
        """Release the device."""
        if self._backend is not None:
            self._backend.close()


class StepPictures:
    """Renders thumbnails of the output of each step."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-steps")

    def of(self, style: Style, frame: np.ndarray) -> dict[StepKey, np.ndarray]:
        """See `step_pictures`."""
        return step_pictures(style, Picture.from_array(frame), self._pool)

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()


def render_exactly(style: Style, frame: np.ndarray) -> np.ndarray:
    """Render a frame, H x W x 3 uint8, on the CPU, whose result is the reference."""
    with CpuRenderer(replace(style, steady=0.0)) as renderer:
        return _run(renderer, frame, None)


def render_second(
    style: Style, clip: Clip, first: int, side: int, stopped: Callable[[], bool]
) -> Iterator[tuple[int, int, np.ndarray]]:
    """Render one second of the clip with temporal smoothing; yield frame number, frame count and picture."""
    count = min(max(1, round(clip.fps)), clip.count - first if not clip.live else round(clip.fps))
    with CpuRenderer(style) as renderer:
        for number in range(count):
            if stopped():
                return
            time = Fraction(first + number) / Fraction(clip.fps)
            yield first + number, count, _run(renderer, clip.frame(first + number, side), float(time))


def _run(backend: Backend, frame: np.ndarray, time: float | None) -> np.ndarray:
    color = backend.run(Picture.from_array(frame), time, _RGB_ENCODING, rgb=True).color
    assert color is not None
    return color
