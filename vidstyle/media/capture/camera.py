"""Cameras, by path, number or name, and screen capture."""

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
from vidstyle.media.v4l2 import FORMATS, Mode, VideoDevice, video_device, video_devices

SYSTEM_FORMATS = {"darwin": "avfoundation", "win32": "dshow"}
"""FFmpeg's input devices for cameras on systems other than Linux."""
DEFAULT_RATE = Fraction(30)


@dataclass(frozen=True)
class Camera:
    """A camera; see `LiveSource`.

    Attributes:
        name: path, number or part of the name on Linux, the camera's name elsewhere; "" is the first camera.
        size, rate: requested; the closest mode of the camera is used.
        input_format: FFmpeg's name of the pixel format or codec to request, or None for the best.
    """

    name: str = ""
    size: tuple[int, int] | None = None
    rate: Fraction | None = None
    input_format: str | None = None
    reconnects: bool = True

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """Open it in the closest mode to the one requested.

        Raises:
            DeviceError: missing or busy; the message lists the available cameras.
        """
        if sys.platform in SYSTEM_FORMATS:
            return self._open_other(SYSTEM_FORMATS[sys.platform], stopping, clock)
        device = find_camera(self.name)
        modes = [mode for mode in device.modes if self.input_format in (None, mode.format)]
        rate = self.rate or DEFAULT_RATE
        mode = choose_mode(modes, self.size, rate)
        if mode is None:
            known = ", ".join(sorted({mode.format for mode in device.modes})) or "no supported format"
            raise DeviceError(device.path, f"has no mode {self.input_format or 'to use'}", f"it has {known}")
        options = _capture_options((mode.width, mode.height), mode_rate(mode, rate))
        return _opened(device.path, "v4l2", options | {"input_format": mode.format}, stopping, clock)

    def _open_other(self, system_format: str, stopping: threading.Event, clock: Clock) -> LiveInput:
        names = [name for name, _ in camera_list()]
        name = self.name or (names[0] if names else "0")
        options = _capture_options(self.size, self.rate)
        if self.input_format is not None:
            options["pixel_format"] = self.input_format
        target = f"video={name}" if system_format == "dshow" else name
        return _opened(target, system_format, options, stopping, clock)


@dataclass(frozen=True)
class Screen:
    """Screen capture; see `LiveSource`.

    Attributes:
        name: of the X11 display, such as ":0.0" or ":0.0+100,200"; "" is that of `DISPLAY`.
        size: of the captured area; None: the whole screen.
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
            return _opened("desktop", "gdigrab", options, stopping, clock)
        if sys.platform == "darwin":
            return _opened(self.name or "Capture screen 0", "avfoundation", options, stopping, clock)
        display = self.name or os.environ.get("DISPLAY", "")
        if not display:
            raise DeviceError("screen", "no X11 display is named", "set DISPLAY, or give screen::0")
        try:
            return _opened(display, "x11grab", options, stopping, clock)
        except DeviceError as error:
            raise DeviceError(f"screen:{display}", "there is no such screen", "give screen::0") from error


def _capture_options(size: tuple[int, int] | None, rate: Fraction | None) -> dict[str, str]:
    options = {"framerate": str(rate or DEFAULT_RATE)}
    return options | ({"video_size": "{}x{}".format(*size)} if size else {})


def find_camera(name: str) -> VideoDevice:
    """The camera of this path, number or part of a name; "" is the first camera.

    Raises:
        DeviceError: there is none; the message lists the available cameras.
    """
    path = f"/dev/video{name}" if name.isdigit() else name
    cameras = [device for device in video_devices() if device.can_capture]
    if not name and cameras:
        return cameras[0]
    for device in cameras:
        if path and (path == device.path or os.path.realpath(path) == device.path):
            return device
    named = [device for device in cameras if name and name.lower() in device.name.lower()]
    if named:
        return named[0]
    own = video_device(path) if path.startswith("/dev/") else None
    if own is not None and own.can_capture:
        return own
    if not name:
        raise DeviceError("camera", "there is none here", "give a film, a URL, screen or test")
    raise DeviceError(name, _reason(path, own), _what_there_is())


def camera_list() -> list[tuple[str, VideoDevice]]:
    """Each camera with the name that selects it; modes are known on Linux only."""
    if sys.platform in SYSTEM_FORMATS:
        found = av.device.enumerate_input_devices(SYSTEM_FORMATS[sys.platform])
        found = [each for each in found if each.media_types != ["audio"]]
        return [(each.name, VideoDevice(each.name, each.description)) for each in found]
    return [(device.path, device) for device in video_devices()]


def _reason(path: str, own: VideoDevice | None) -> str:
    if own is not None:
        return "is an output device, not a camera"
    if path.startswith("/dev/") and Path(path).exists():
        return "no permission to open it" if not os.access(path, os.R_OK | os.W_OK) else "is not a camera"
    return "no such camera" if path.startswith("/dev/") else "no such file, and no such camera"


def _what_there_is() -> str:
    there = [f"{path} ({device.name})" for path, device in camera_list() if device.can_capture]
    return "there is " + (", ".join(there) or "none here: give a film, or 'test' for a test picture")


def _opened(
    target: str, system_format: str, options: dict[str, str], stopping: threading.Event, clock: Clock
) -> LiveInput:
    is_v4l2 = system_format == "v4l2"
    try:
        before = device_descriptors(target)
        container = av.open(target, "r", system_format, options)
    except (av.FFmpegError, OSError, ValueError) as error:
        busy = getattr(error, "errno", None) == errno.EBUSY
        reason = "is in use by another program" if busy else f"cannot be opened: {error_reason(error)}"
        raise DeviceError(target, reason, _what_there_is()) from error
    # FFmpeg does not expose the file descriptor of the device.
    opened = device_descriptors(target) - before if is_v4l2 else set()
    wait = wait_for_input(min(opened), clock) if opened else None
    return LiveInput(container, target, stopping, clock, stamped=is_v4l2, wait=wait)


DEFAULT_SIZE = (1280, 720)
"""Larger modes are used only on request."""
RATE_TOLERANCE = Fraction(98, 100)
"""A rate counts as reached from this part of it on: 29.97 is enough for 30."""
COST = {name: place for place, name in enumerate(FORMATS.values())}


def choose_mode(modes: Sequence[Mode], size: tuple[int, int] | None, rate: Fraction) -> Mode | None:
    """The closest mode, or None if the camera has no supported one.

    The rate comes first, since frames can be scaled but a slow mode cannot be made faster. Among equals the
    cheapest to decode is chosen: MJPEG only where raw video is too slow.

    Args:
        modes: supported modes.
        size: width and height; None: the largest up to 1280x720.
        rate: frames per second.

    >>> slow, fast = Mode("yuyv422", 1280, 720, (Fraction(10),)), Mode("mjpeg", 1280, 720, (Fraction(30),))
    >>> choose_mode([slow, fast], (1280, 720), Fraction(30)).format
    'mjpeg'
    """
    return min(modes, key=lambda mode: _distance(mode, size, rate), default=None)


def mode_rate(mode: Mode, rate: Fraction) -> Fraction:
    """The lowest sufficient rate of the mode, else its highest; `rate` itself if the mode lists none."""
    enough = [each for each in mode.rates if each >= rate * RATE_TOLERANCE]
    return min(enough) if enough else max(mode.rates, default=rate)


def _distance(mode: Mode, size: tuple[int, int] | None, rate: Fraction) -> tuple[float, ...]:
    reached = mode_rate(mode, rate)
    missing = 0.0 if reached >= rate * RATE_TOLERANCE else float(rate - reached)
    pixels = mode.width * mode.height
    wanted = size or DEFAULT_SIZE
    too_small = max(0, wanted[0] - mode.width) + max(0, wanted[1] - mode.height)
    too_large = max(0, mode.width - wanted[0]) + max(0, mode.height - wanted[1])
    if size is None:
        # Any size up to the default is accepted, the largest preferred.
        return (missing, float(too_large > 0), float(pixels if too_large else -pixels), COST[mode.format])
    return (missing, float(too_small > 0), float(too_small + too_large), COST[mode.format])


POLL_SECONDS = 0.1
"""How often a wait checks whether to stop."""
DESCRIPTORS = Path("/proc/self/fd")


def wait_for_input(descriptor: int, clock: Clock) -> WaitForFrame:
    """A function that waits until a device is readable or disconnected."""
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


def device_descriptors(path: str) -> set[int]:
    """The file descriptors of this process that refer to the device; Linux only, else empty."""
    found = set()
    for entry in DESCRIPTORS.iterdir() if DESCRIPTORS.is_dir() else ():
        with contextlib.suppress(OSError):  # closed meanwhile
            if os.fstat(int(entry.name)).st_rdev == os.stat(path).st_rdev:
                found.add(int(entry.name))
    return found
