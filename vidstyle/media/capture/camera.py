"""Cameras, selected by path, number or name, and screen capture."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av

from vidstyle.errors import DeviceError, error_reason
from vidstyle.media.capture.input import LiveInput, WaitForFrame
from vidstyle.media.capture.monotonic import Clock
from vidstyle.media.v4l2 import (
    CAMERA_PIXEL_FORMATS,
    CameraMode,
    VideoDevice,
    list_video_devices,
    query_video_device,
)

CAPTURE_DEMUXERS = {"darwin": "avfoundation", "win32": "dshow"}
"""FFmpeg's demuxers for cameras on systems other than Linux."""
DEFAULT_CAMERA_RATE = Fraction(30)


@dataclass(frozen=True)
class Camera:
    """A camera; see `LiveSource`.

    Attributes:
        name: path, number or part of the name on Linux, the camera's name elsewhere; "" is the first camera.
        size, rate: requested values; the closest mode of the camera is used.
        input_format: FFmpeg's name of the requested pixel format or codec; None: the best one.
    """

    name: str = ""
    size: tuple[int, int] | None = None
    rate: Fraction | None = None
    input_format: str | None = None
    reconnects: bool = True

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """Open the camera in the mode closest to the requested one.

        Raises:
            DeviceError: the camera is missing or busy; the message lists the available cameras.
        """
        if sys.platform in CAPTURE_DEMUXERS:
            return self._open_other(CAPTURE_DEMUXERS[sys.platform], stopping, clock)
        device = find_camera(self.name)
        modes = [mode for mode in device.modes if self.input_format in (None, mode.format)]
        rate = self.rate or DEFAULT_CAMERA_RATE
        mode = choose_mode(modes, self.size, rate)
        if mode is None:
            known = ", ".join(sorted({mode.format for mode in device.modes})) or "no supported format"
            raise DeviceError(device.path, f"has no mode {self.input_format or 'to use'}", f"it has {known}")
        options = _capture_options((mode.width, mode.height), mode_rate(mode, rate))
        return _open_device(device.path, "v4l2", options | {"input_format": mode.format}, stopping, clock)

    def _open_other(self, system_format: str, stopping: threading.Event, clock: Clock) -> LiveInput:
        names = [name for name, _ in list_cameras()]
        name = self.name or (names[0] if names else "0")
        options = _capture_options(self.size, self.rate)
        if self.input_format is not None:
            options["pixel_format"] = self.input_format
        target = f"video={name}" if system_format == "dshow" else name
        return _open_device(target, system_format, options, stopping, clock)


@dataclass(frozen=True)
class Screen:
    """Screen capture; see `LiveSource`.

    Attributes:
        name: the X11 display, such as ":0.0" or ":0.0+100,200"; "": the value of `DISPLAY`.
        size: size of the captured area; None: the whole screen.
        rate: frames per second.
    """

    name: str = ""
    size: tuple[int, int] | None = None
    rate: Fraction | None = None
    reconnects: bool = True

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """Start capturing.

        Raises:
            DeviceError: there is no such screen.
        """
        options = _capture_options(self.size, self.rate)
        if sys.platform == "win32":
            return _open_device("desktop", "gdigrab", options, stopping, clock)
        if sys.platform == "darwin":
            return _open_device(self.name or "Capture screen 0", "avfoundation", options, stopping, clock)
        display = self.name or os.environ.get("DISPLAY", "")
        if not display:
            raise DeviceError("screen", "DISPLAY is not set", "set it, or use screen::0")
        try:
            return _open_device(display, "x11grab", options, stopping, clock)
        except DeviceError as error:
            raise DeviceError(f"screen:{display}", "there is no such screen", "use screen::0") from error


def _capture_options(size: tuple[int, int] | None, rate: Fraction | None) -> dict[str, str]:
    options = {"framerate": str(rate or DEFAULT_CAMERA_RATE)}
    return options | ({"video_size": "{}x{}".format(*size)} if size else {})


def find_camera(name: str) -> VideoDevice:
    """Return the camera with this path, number or part of a name; "": the first camera.

    Raises:
        DeviceError: there is none; the message lists the available cameras.
    """
    path = f"/dev/video{name}" if name.isdigit() else name
    cameras = [device for device in list_video_devices() if device.can_capture]
    if not name and cameras:
        return cameras[0]
    for device in cameras:
        if path and (path == device.path or os.path.realpath(path) == device.path):
            return device
    named = [device for device in cameras if name and name.lower() in device.name.lower()]
    if named:
        return named[0]
    own = query_video_device(path) if path.startswith("/dev/") else None
    if own is not None and own.can_capture:
        return own
    if not name:
        raise DeviceError("camera", "no camera found", "use a film, a URL, screen or test")
    raise DeviceError(name, _explain_missing(path, own), _suggest_cameras())


def list_cameras() -> list[tuple[str, VideoDevice]]:
    """Return each camera with the name that selects it; modes are known on Linux only."""
    if sys.platform in CAPTURE_DEMUXERS:
        found = av.device.enumerate_input_devices(CAPTURE_DEMUXERS[sys.platform])
        found = [each for each in found if each.media_types != ["audio"]]
        return [(each.name, VideoDevice(each.name, each.description)) for each in found]
    return [(device.path, device) for device in list_video_devices()]


def _explain_missing(path: str, own: VideoDevice | None) -> str:
    if own is not None:
        return "is an output device, not a camera"
    if path.startswith("/dev/") and Path(path).exists():
        return "no permission to open it" if not os.access(path, os.R_OK | os.W_OK) else "is not a camera"
    return "no such camera" if path.startswith("/dev/") else "no such file, and no such camera"


def _suggest_cameras() -> str:
    there = [f"{path} ({device.name})" for path, device in list_cameras() if device.can_capture]
    return "available: " + ", ".join(there) if there else "use a film, or 'test' for a test picture"


def _open_device(
    target: str, system_format: str, options: dict[str, str], stopping: threading.Event, clock: Clock
) -> LiveInput:
    is_v4l2 = system_format == "v4l2"
    try:
        before = find_descriptors(target)
        container = av.open(target, "r", system_format, options)
    except (av.FFmpegError, OSError, ValueError) as error:
        busy = getattr(error, "errno", None) == errno.EBUSY
        reason = "is in use by another program" if busy else f"cannot be opened: {error_reason(error)}"
        raise DeviceError(target, reason, _suggest_cameras()) from error
    # FFmpeg does not expose the file descriptor of the device.
    opened = find_descriptors(target) - before if is_v4l2 else set()
    wait = wait_for_input(min(opened), clock) if opened else None
    return LiveInput(container, target, stopping, clock, stamped=is_v4l2, wait=wait)


DEFAULT_SIZE = (1280, 720)
"""Default maximum width and height; larger modes are used only on request."""
MIN_RATE_RATIO = Fraction(98, 100)
"""Ratio from which a rate is sufficient: 29.97 is accepted for 30."""
FORMAT_COSTS = {name: place for place, name in enumerate(CAMERA_PIXEL_FORMATS.values())}


def choose_mode(
    modes: Sequence[CameraMode], size: tuple[int, int] | None, rate: Fraction
) -> CameraMode | None:
    """Return the closest mode, or None if the camera has no supported one.

    The rate has priority: frames can be scaled, but a slow mode cannot be made faster. Among equal modes, the
    cheapest to decode is chosen: MJPEG only if raw video is too slow.

    Args:
        modes: supported modes.
        size: width and height; None: the largest up to 1280x720.
        rate: frames per second.

    >>> slow = CameraMode("yuyv422", 1280, 720, (Fraction(10),))
    >>> fast = CameraMode("mjpeg", 1280, 720, (Fraction(30),))
    >>> choose_mode([slow, fast], (1280, 720), Fraction(30)).format
    'mjpeg'
    """
    return min(modes, key=lambda mode: _distance(mode, size, rate), default=None)


def mode_rate(mode: CameraMode, rate: Fraction) -> Fraction:
    """Return the lowest sufficient rate of the mode, else its highest; `rate` if the mode lists none."""
    enough = [each for each in mode.rates if each >= rate * MIN_RATE_RATIO]
    return min(enough) if enough else max(mode.rates, default=rate)


def _distance(mode: CameraMode, size: tuple[int, int] | None, rate: Fraction) -> tuple[float, ...]:
    reached = mode_rate(mode, rate)
    missing = 0.0 if reached >= rate * MIN_RATE_RATIO else float(rate - reached)
    pixels = mode.width * mode.height
    wanted = size or DEFAULT_SIZE
    too_small = max(0, wanted[0] - mode.width) + max(0, wanted[1] - mode.height)
    too_large = max(0, mode.width - wanted[0]) + max(0, mode.height - wanted[1])
    if size is None:
        # Any size up to the default is accepted, the largest preferred.
        return (
            missing,
            float(too_large > 0),
            float(pixels if too_large else -pixels),
            FORMAT_COSTS[mode.format],
        )
    return (missing, float(too_small > 0), float(too_small + too_large), FORMAT_COSTS[mode.format])


POLL_SECONDS = 0.1
"""Interval at which a wait checks whether to stop."""
DESCRIPTOR_FOLDER = Path("/proc/self/fd")


def wait_for_input(descriptor: int, clock: Clock) -> WaitForFrame:
    """Return a function that waits until a device is readable or disconnected."""
    poll = select.poll()
    # A disconnected device counts as readable: reading it raises the error.
    poll.register(descriptor, select.POLLIN | select.POLLERR | select.POLLHUP)

    def wait(stopping: threading.Event, seconds: float) -> bool:
        until = clock.now() + seconds
        while not stopping.is_set() and clock.now() < until:
            if poll.poll(POLL_SECONDS * 1000):
                return True
        return False

    return wait


def find_descriptors(path: str) -> set[int]:
    """Return the file descriptors of this process that refer to the device; Linux only, else empty."""
    found = set()
    for entry in DESCRIPTOR_FOLDER.iterdir() if DESCRIPTOR_FOLDER.is_dir() else ():
        with contextlib.suppress(OSError):  # closed in the meantime
            if os.fstat(int(entry.name)).st_rdev == os.stat(path).st_rdev:
                found.add(int(entry.name))
    return found
