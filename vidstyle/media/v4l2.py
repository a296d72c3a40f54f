"""Video4Linux devices: their names and modes, queried by ioctl."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

DEVICE_FOLDER = Path("/sys/class/video4linux")
CAPTURE_BIT, OUTPUT_BIT, DEVICE_CAPS_BIT = 0x1, 0x2, 0x80000000
"""Capability bits of a device (linux/videodev2.h)."""
CAPTURE_BUFFER_CODE = 1
DISCRETE_CODE = 1
CAMERA_PIXEL_FORMATS = {
    **{"YUYV": "yuyv422", "UYVY": "uyvy422", "NV12": "nv12", "YU12": "yuv420p", "422P": "yuv422p"},
    **{"RGB3": "rgb24", "BGR3": "bgr24", "GREY": "gray", "MJPG": "mjpeg", "H264": "h264"},
}
"""Supported formats: Video4Linux code and FFmpeg's name for `input_format`; cheapest to decode first."""
DEFAULT_SIZES = ((320, 240), (640, 360), (640, 480), (1280, 720), (1920, 1080))
"""Sizes that are listed for a device with a continuous range of sizes."""


@dataclass(frozen=True)
class CameraMode:
    """A mode of a camera.

    Attributes:
        format: FFmpeg's name of the pixel format or codec.
        width, height: in pixels.
        rates: frames per second, highest first; empty if unknown.
    """

    format: str
    width: int
    height: int
    rates: tuple[Fraction, ...] = ()

    def __str__(self) -> str:
        rates = ", ".join(f"{float(rate):.4g}" for rate in self.rates)
        return f"{self.format} {self.width}x{self.height}" + (f" at {rates} fps" if rates else "")


@dataclass(frozen=True)
class VideoDevice:
    """A camera.

    Attributes:
        path: of the device file.
        name: the name reported by the device.
        can_output: whether frames can be written to it, as to a virtual camera.
        can_capture: whether frames can be read from it.
        modes: the supported modes, in the device's order.
    """

    path: str
    name: str
    can_capture: bool = True
    can_output: bool = False
    modes: tuple[CameraMode, ...] = ()


def list_video_devices() -> list[VideoDevice]:
    """Return every Video4Linux device that can be queried, by number; none on other systems."""
    if not sys.platform.startswith("linux"):
        return []
    paths = [path for path in Path("/dev").glob("video*") if re.fullmatch(r"video\d+", path.name)]
    found = (query_video_device(str(path)) for path in sorted(paths, key=lambda path: int(path.name[5:])))
    return [device for device in found if device is not None]


def query_video_device(path: str) -> VideoDevice | None:
    """Query a device; return None if it is not a video device or cannot be opened."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    except OSError:
        return None
    try:
        name, flags = _capability(handle)
        modes = tuple(_modes(handle)) if flags & CAPTURE_BIT else ()
        return VideoDevice(path, name, bool(flags & CAPTURE_BIT), bool(flags & OUTPUT_BIT), modes)
    except OSError:
        return None
    finally:
        os.close(handle)


def _call_ioctl(
    handle: int, number: int, layout: str, *values: int | bytes, writes: bool = True
) -> tuple[int | bytes, ...]:
    """Call an ioctl on a zeroed structure and return the structure that the driver has filled in."""
    import fcntl

    content = bytearray(struct.pack(layout, *values))
    direction = 3 if writes else 2
    fcntl.ioctl(handle, direction << 30 | len(content) << 16 | ord("V") << 8 | number, content)
    return struct.unpack(layout, content)


def _capability(handle: int) -> tuple[str, int]:
    """Return the name and the capabilities of this device node (VIDIOC_QUERYCAP)."""
    _, card, _, _, flags, own, _ = _call_ioctl(
        handle, 0, "=16s32s32sIII12s", b"", b"", b"", 0, 0, 0, b"", writes=False
    )
    assert isinstance(card, bytes) and isinstance(flags, int) and isinstance(own, int)
    return card.split(b"\0")[0].decode("utf-8", "replace"), own if flags & DEVICE_CAPS_BIT else flags


def _modes(handle: int) -> Iterator[CameraMode]:
    # VIDIOC_ENUM_FMT
    for filled in _call_each_index(handle, 2, "=III32sII12s", CAPTURE_BUFFER_CODE, 0, b"", 0, 0, b""):
        code = int(filled[4])
        letters = code.to_bytes(4, "little").decode("latin-1")
        if letters not in CAMERA_PIXEL_FORMATS:
            continue
        for width, height in _sizes(handle, code):
            yield CameraMode(
                CAMERA_PIXEL_FORMATS[letters], width, height, tuple(_rates(handle, code, width, height))
            )


def _sizes(handle: int, code: int) -> Iterator[tuple[int, int]]:
    """Yield the sizes of a pixel format (VIDIOC_ENUM_FRAMESIZES)."""
    for filled in _call_each_index(handle, 74, "=III6I8s", code, 0, 0, 0, 0, 0, 0, 0, b""):
        kind, least_width, most_width, _, least_height, most_height, _ = (
            int(number) for number in filled[2:9]
        )
        if kind == DISCRETE_CODE:
            yield least_width, most_width  # of this type, they are the width and the height
            continue
        for width, height in DEFAULT_SIZES:
            if least_width <= width <= most_width and least_height <= height <= most_height:
                yield width, height
        return


def _rates(handle: int, code: int, width: int, height: int) -> list[Fraction]:
    """Return the rates of a size, for a range its limits (VIDIOC_ENUM_FRAMEINTERVALS)."""
    rates: set[Fraction] = set()
    for filled in _call_each_index(handle, 75, "=IIIII6I8s", code, width, height, 0, 0, 0, 0, 0, 0, 0, b""):
        numbers = [int(number) for number in filled[4:11]]
        intervals = [numbers[1:3]] if numbers[0] == DISCRETE_CODE else [numbers[1:3], numbers[3:5]]
        rates |= {Fraction(below, above) for above, below in intervals if above and below}
    return sorted(rates, reverse=True)


def _call_each_index(
    handle: int, number: int, layout: str, *values: int | bytes
) -> Iterator[tuple[int | bytes, ...]]:
    """Yield the structures for index 0, 1, 2 ... until the driver has no more."""
    with contextlib.suppress(OSError):
        for index in itertools.count():
            yield _call_ioctl(handle, number, layout, index, *values)


def list_device_names() -> list[str]:
    """Return the video devices of this machine with their names; Linux only."""
    if not DEVICE_FOLDER.is_dir():
        return []
    return [
        f"/dev/{device.name} ({(device / 'name').read_text().strip()})"
        for device in sorted(DEVICE_FOLDER.iterdir())
    ]
