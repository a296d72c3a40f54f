"""Restyle pictures one by one from other programs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, overload

import numpy as np

from vidstyle.core.closing import Closing
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.passthrough import PassthroughRenderer
from vidstyle.errors import UsageError, log, not_a_picture
from vidstyle.gpu.device.devices import DEVICE_NAMES, DeviceChoice, choose
from vidstyle.style import Style, load_style

if TYPE_CHECKING:
    import av

    from vidstyle.gpu.device.devices import Device

StyleLike = Style | str | Path | Mapping[str, object]
"""A style as `load_style` takes it: a `Style`, a name, a path or a table."""


class PendingPicture(Protocol):
    """A picture that is being restyled."""

    def result(self) -> Picture:
        """The restyled picture; waits for it."""


class Backend(Protocol):
    """Restyles one picture after another, on the CPU (`CpuRenderer`) or a GPU (`GpuRenderer`).

    It remembers earlier pictures where a style follows a film over time; a scene cut, a jump in time and
    another size reset that.

    Attributes:
        frames_in_flight: how many pictures may be started before the result of the first is asked for.
    """

    frames_in_flight: int

    def change_style(self, style: Style) -> None:
        """Use another style from the next `start` on; pictures in flight keep theirs.

        Device, threads and compiled programs are kept. Where only numbers and colours differ, memory of
        earlier pictures is kept too. A style that cannot be used raises with the next result.
        """

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> PendingPicture:
        """Start to restyle a picture; the arguments are those of `run`."""

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """The restyled picture, at its own size; waits for it.

        Args:
            picture: any picture; its planes are only read.
            time: presentation time in seconds, or None for a picture that stands alone.
            target: encoding of the result's planes; None: as the picture's own.
            rgb: packed RGB of the target's depth is wanted instead of luma and chroma.

        Raises:
            DeviceError: both the GPU and the CPU have failed.
            StyleError: the style cannot be used.
        """

    def close(self) -> None:
        """Release the device and its threads."""


def open_renderer(style: StyleLike, device: str = "auto", announce: bool = True) -> Backend:
    """Open a renderer on a device.

    Args:
        style: the style; an empty one needs no device.
        device: "auto" (a real GPU if there is one, else the CPU), "cpu", "gpu" or "gpu:N".
        announce: whether to log which device is used, and why.

    Raises:
        UsageError: an unknown device name.
        DeviceError: there is no such device.
        StyleError: the style cannot be used.
    """
    style = load_style(style)
    chosen = _choice(style, device).device
    renderer = _opened(style, chosen)
    if announce:
        announce_device(style, device)
    return renderer


def _opened(style: Style, device: Device | None) -> Backend:
    """Imports what this renderer needs alone."""
    if device is None and style.is_plain:
        return PassthroughRenderer(style)
    from vidstyle.cpu.renderer import CpuRenderer

    if device is None:
        return CpuRenderer(style)
    from vidstyle.gpu.renderer import GpuRenderer

    return GpuRenderer(style, device, CpuRenderer)


def announce_device(style: Style, device: str) -> None:
    """Log which device runs a style, and why, unless it is the CPU by request. Raises as `open_renderer`."""
    if notice := _choice(style, device).notice:
        log.info(notice, extra={"once": True})


def _choice(style: Style, device: str) -> DeviceChoice:
    return choose("cpu" if style.is_plain and device in DEVICE_NAMES else device)


class Renderer(Closing):
    """Restyles the frames of one film in order.

    Blocks that follow the film over time use presentation times; arrays count as 25 frames per second.

    >>> with Renderer("plain") as renderer:
    ...     frame = renderer(np.zeros((4, 6, 3), np.uint8))
    >>> frame.shape
    (4, 6, 3)
    """

    ARRAY_RATE = 25
    """Frames per second of arrays without a time."""

    def __init__(self, style: StyleLike, device: str = "auto") -> None:
        self._renderer = open_renderer(style, device)
        self._count = 0
        self._is_closed = False

    def close(self) -> None:
        """Release the device and its threads."""
        self._is_closed = True
        self._renderer.close()

    @overload
    def __call__(self, frame: np.ndarray, time: float | None = None) -> np.ndarray: ...

    @overload
    def __call__(self, frame: av.VideoFrame, time: float | None = None) -> av.VideoFrame: ...

    def __call__(
        self, frame: np.ndarray | av.VideoFrame, time: float | None = None
    ) -> np.ndarray | av.VideoFrame:
        """The restyled frame, of the type of the argument.

        Args:
            frame: an `av.VideoFrame`, which keeps its format, tags and time, or an H x W x 3 or
                H x W x 4 array in RGB order: uint8, uint16, or floats 0..1. It is only read.
            time: presentation time in seconds; None: the frame's own.

        Raises:
            UsageError: an array of another shape or type, no picture at all, or the renderer is closed.
            InputError: a frame in an unsupported pixel format, or floats that are NaN or outside -1..2.
        """
        if self._is_closed:
            raise UsageError("renderer", "is closed", "open another one")
        if isinstance(frame, np.ndarray):
            time = self._count / self.ARRAY_RATE if time is None else time
            self._count += 1
            return _array_run(self._renderer, frame, time)
        return self._frame_run(frame, time)

    def _frame_run(self, frame: av.VideoFrame, time: float | None) -> av.VideoFrame:
        from vidstyle.media.color_tags import ColorTags
        from vidstyle.media.frame import frame_from_picture, picture_from_frame

        picture = picture_from_frame(frame)
        time = frame.time if time is None else time
        result = self._renderer.run(picture, time, rgb=picture.color is not None)
        if result is picture:
            return frame
        restyled = frame_from_picture(result, tags=ColorTags.of(frame))
        if restyled.format.name != frame.format.name:
            restyled = restyled.reformat(format=frame.format.name)
        restyled.pts = frame.pts
        if frame.time_base is not None:
            restyled.time_base = frame.time_base
        return restyled


def stylize(picture: np.ndarray, style: StyleLike, device: str = "auto") -> np.ndarray:
    """Restyle one picture.

    Args:
        picture: H x W x 3 or H x W x 4 in RGB order: uint8, uint16, or floats 0..1; alpha is kept.
        style: what `load_style` takes.
        device: as for `open_renderer`.

    Returns:
        A new array of the same shape and type.

    Raises:
        UsageError: an array of another shape or type, or no array.
        InputError: floats that are NaN or outside -1..2.

    >>> bright = stylize(np.full((2, 2, 3), 0.5), {"format": 1, "background": [{"block": "brightness"}]})
    >>> bright.dtype, bright[0, 0].round(3).tolist()
    (dtype('float64'), [0.65, 0.65, 0.65])
    """
    with closing(open_renderer(style, device)) as renderer:
        return _array_run(renderer, picture, None)


def _array_run(renderer: Backend, array: np.ndarray, time: float | None) -> np.ndarray:
    if not isinstance(array, np.ndarray):
        raise not_a_picture(array, "an array")
    if array.ndim != 3:
        raise UsageError("picture", f"is an array of shape {array.shape}", "give H x W x 3 or H x W x 4")
    picture = Picture.from_array(array)
    target = Encoding(full_range=True, depth=picture.encoding.depth, step=(1, 1))
    color = renderer.run(picture, time, target, rgb=True).color
    assert color is not None
    if array.shape[2] == 4:
        color = np.concatenate([color, np.asarray(array[..., 3:])], axis=2)
    return np.array(color, array.dtype)
