"""Restyle pictures one by one from other programs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from vidstyle.backend import Backend, FrameRequest
from vidstyle.core.closing import Closing
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.hdr_renderer import HdrRenderer
from vidstyle.cpu.passthrough import PassthroughRenderer
from vidstyle.cues.cue_list import CueList
from vidstyle.errors import UsageError, log, not_a_picture
from vidstyle.gpu.device.devices import DEVICE_NAMES, DeviceChoice, choose
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.style import PLAIN, Style, load_style

if TYPE_CHECKING:
    import av

    from vidstyle.core.scene_cuts import KnownCuts, SceneCuts
    from vidstyle.gpu.device.devices import Device
    from vidstyle.regions.face_tracks import FaceFollower, FacelessStart
    from vidstyle.regions.faces import FaceFinder
    from vidstyle.regions.focus import FaceSource

StyleLike = Style | str | Path | Mapping[str, object]
"""A style as `load_style` takes it: a `Style`, a name, a path or a table."""


def open_renderer(
    style: StyleLike | CueList,
    device: str = "auto",
    announce: bool = True,
    cuts: KnownCuts | None = None,
    faces: FaceSource | None = None,
) -> Backend:
    """Open a renderer on a device.

    Args:
        style: the style, or the styles over time; an empty one needs no device.
        device: "auto" (a real GPU if there is one, else the CPU), "cpu", "gpu" or "gpu:N".
        announce: whether to log which device is used, and why.
        cuts: scene cuts of the film; None: they are detected.
        faces: finds the faces for focus; None: they are found in each picture, and followed through a film.

    Raises:
        UsageError: an unknown device name.
        DeviceError: there is no such device.
        StyleError: the style cannot be used.
    """
    style = style if isinstance(style, CueList) else load_style(style)
    chosen = _choice(style, device).device

    def opened(style: Style, cuts: SceneCuts | None) -> Backend:
        return _with_masks(style, chosen, cuts or _shared_cuts(chosen), faces)

    renderer: Backend
    if chosen is None and style.is_plain and faces is None:
        plain = load_style(PLAIN)
        renderer = MaskRenderer(plain, lambda: PassthroughRenderer(plain), cuts)
    elif isinstance(style, CueList):
        from vidstyle.cues.cue_renderer import CueRenderer

        renderer = CueRenderer(style, opened, cuts)
    else:
        renderer = opened(style, cuts)
    if announce:
        announce_device(style, device)
    return renderer


def runs_on_cpu(style: Style | CueList, device: str) -> bool:
    """Whether `open_renderer` with this device opens a renderer on the CPU; raises as it does."""
    return _choice(style, device).device is None


def has_followed_faces(style: Style) -> bool:
    """Whether `open_renderer` opens a renderer that tracks faces in focus."""
    is_focused = style.focus and style.height is not None and not style.is_plain
    return bool(is_focused and _face_finder().has_model)


def follow_faces(style: Style, cuts: KnownCuts, faceless: FacelessStart | None = None) -> FaceFollower | None:
    """Return a follower of the faces in focus; None if the style has none.

    Args:
        cuts: scene cuts of the film; a cut must be added before its frame is followed.
        faceless: see `FaceFollower`.
    """
    if not has_followed_faces(style):
        return None
    from vidstyle.regions.face_tracks import FaceFollower

    return FaceFollower(_face_finder(), cuts, faceless)


def _with_masks(
    style: Style, device: Device | None, cuts: SceneCuts | None, faces: FaceSource | None
) -> Backend:
    """Open a renderer that computes the masks that a style reads."""
    return MaskRenderer(style, lambda: _with_focus(style, device, cuts, faces), cuts)


def _with_focus(
    style: Style, device: Device | None, cuts: SceneCuts | None, faces: FaceSource | None
) -> Backend:
    """Open a renderer that keeps writing, and restyles faces in finer detail, if they can be found."""
    from vidstyle.regions.face_tracks import FaceFollower
    from vidstyle.regions.focus import FocusRenderer
    from vidstyle.regions.still_faces import NO_FACES

    if faces is None:
        faces = FaceFollower(_face_finder(), cuts) if _face_finder().has_model else NO_FACES
    return FocusRenderer(style, lambda style, cuts: _opened(style, device, cuts), faces, cuts)


def _shared_cuts(device: Device | None) -> SceneCuts | None:
    """Return what detects cuts for all parts of a renderer; None on a GPU, as its thread lags behind."""
    from vidstyle.core.scene_cuts import SceneCutDetector

    return SceneCutDetector() if device is None else None


def _face_finder() -> FaceFinder:
    from vidstyle.regions.faces import FaceFinder

    return FaceFinder()


def _opened(style: Style, device: Device | None, cuts: SceneCuts | None) -> Backend:
    """Imports what this renderer needs alone."""
    from vidstyle.cpu.renderer import CpuRenderer

    if device is None:
        return CpuRenderer(style, cuts=cuts)
    from vidstyle.gpu.renderer import GpuRenderer

    return GpuRenderer(style, device, partial(CpuRenderer, cuts=cuts), cuts=cuts)


def announce_device(style: Style | CueList, device: str) -> None:
    """Log which device runs a style, and why, unless it is the CPU by request; and if focus is impossible.

    Raises as `open_renderer`.
    """
    if notice := _choice(style, device).notice:
        log.info(notice, extra={"once": True})
    if style.focus and not style.is_plain and not _face_finder().has_model:
        log.info("focus on faces is off: install vidstyle[comic] to detect them", extra={"once": True})


def _choice(style: Style | CueList, device: str) -> DeviceChoice:
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
        self._renderer = HdrRenderer(open_renderer(style, device), load_style(style).is_plain)
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
            return restyle_array(self._renderer, frame, time)
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
        return restyle_array(renderer, picture)


def restyle_array(
    renderer: Backend, array: np.ndarray, time: float | None = None, seen_side: float | None = None
) -> np.ndarray:
    """Restyle an array; the result is a new array of the same shape and type.

    Args:
        array: as for `stylize`.
        time: presentation time in seconds, or None for a picture that stands alone.
        seen_side: see `FrameRequest`.

    Raises:
        UsageError, InputError: as `stylize`.
    """
    if not isinstance(array, np.ndarray):
        raise not_a_picture(array, "an array")
    if array.ndim != 3:
        raise UsageError("picture", f"is an array of shape {array.shape}", "give H x W x 3 or H x W x 4")
    picture = Picture.from_array(array)
    target = Encoding(full_range=True, depth=picture.encoding.depth, subsampling=(1, 1))
    request = FrameRequest(picture, time, target, rgb=True, seen_side=seen_side)
    color = renderer.restyle(request).color
    assert color is not None
    if array.shape[2] == 4:
        color = np.concatenate([color, np.asarray(array[..., 3:])], axis=2)
    return np.array(color, array.dtype)
