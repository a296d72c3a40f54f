"""The OpenGL devices of this machine, and the selection of one."""

from __future__ import annotations

import glob
import os
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from vidstyle.errors import DeviceError, UsageError
from vidstyle.gpu.device.context import close_context, count_devices, open_context

if TYPE_CHECKING:
    from vidstyle.gpu.compile.glsl import Form

DEVICE_NAMES = ("auto", "cpu", "gpu", "gpu:N")
"""Names of devices; N is a number."""
SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swr", "swiftshader", "software", "basic render")
"""Words in the names of software renderers, which do not count as a GPU (docs/rules.md, Devices)."""
DEVICE_FILES = ("/dev/dri/renderD*", "/dev/nvidia[0-9]*", "/dev/dxg")
"""Device files of graphics cards on Linux: with a Mesa driver, of NVIDIA, and of Windows in WSL."""


@dataclass(frozen=True)
class Device:
    """An OpenGL device.

    Attributes:
        index: number of the device for `open_context`.
        name: name of the renderer.
        version: version of OpenGL, 450 for 4.5; some drivers return the highest requested one
            (`GL_VERSIONS`).
        software: whether it renders on the CPU.
        texture_size: maximum width and height of a texture, in pixels.
    """

    index: int
    name: str
    version: int
    software: bool
    texture_size: int

    @property
    def form(self) -> Form:
        """The default form of passes on this device."""
        return "compute" if self.version >= 430 else "fragment"

    def __str__(self) -> str:
        return f"gpu:{self.index}, {self.name}"


@dataclass(frozen=True)
class DeviceChoice:
    """The device that a style runs on.

    Attributes:
        device: the OpenGL device, or None for the CPU.
        notice: one line with the device and the reason; empty if the user requested the CPU.
    """

    device: Device | None
    notice: str = ""


def list_devices() -> list[Device]:
    """Return all devices that can be opened, in the order of their numbers; cached."""
    return [device for device in map(_device, range(count_devices())) if isinstance(device, Device)]


def has_gpu_hardware() -> bool:
    """Whether the machine may have a graphics card, without the delay of loading OpenGL."""
    return not sys.platform.startswith("linux") or bool(_device_files())


def choose(device: str) -> DeviceChoice:
    """Choose a device by name.

    Args:
        device: "auto" for the first hardware GPU, or the CPU if there is none; "cpu"; "gpu" for the first
            hardware GPU, or the first software renderer if there is none; "gpu:N" for the device with this
            number.

    Raises:
        UsageError: the name is unknown.
        DeviceError: the device does not exist.
    """
    if device == "cpu":
        return DeviceChoice(None)
    if device == "auto":
        return _choose_auto()
    if not re.fullmatch("gpu(:[0-9]{1,4})?", device):
        raise UsageError(device, "is not a device", f"choose one of {', '.join(DEVICE_NAMES)}")
    return _choice(_first_gpu() or _first_device(device) if device == "gpu" else _numbered(device))


def _choose_auto() -> DeviceChoice:
    if not has_gpu_hardware():
        return DeviceChoice(None, "no GPU: this machine has no graphics card; using the CPU")
    if gpu := _first_gpu():
        return _choice(gpu)
    try:
        reason = f"{_first_device('auto').name} is a software renderer"
    except DeviceError as error:
        reason = error.reason
    return DeviceChoice(None, f"no GPU: {_why_unusable() or reason}; using the CPU")


def _choice(device: Device) -> DeviceChoice:
    if device.software:
        return DeviceChoice(device, f"{device}, is a software renderer: --device cpu is faster")
    return DeviceChoice(device, f"using {device}")


def _first_gpu() -> Device | None:
    """Return the first hardware GPU, without opening later devices."""
    devices = (_device(index) for index in range(count_devices()))
    return next((each for each in devices if isinstance(each, Device) and not each.software), None)


def _first_device(word: str) -> Device:
    if devices := list_devices():
        return devices[0]
    failure = _device(0)
    assert isinstance(failure, DeviceError)
    raise DeviceError(f"--device {word}", failure.reason, failure.remedy)


def _numbered(word: str) -> Device:
    devices = {f"gpu:{device.index}": device for device in list_devices() or [_first_device(word)]}
    if word not in devices:
        names = " or ".join(map(str, devices.values()))
        raise DeviceError(f"--device {word}", "there is no such device", f"choose {names}")
    return devices[word]


@cache
def _device(index: int) -> Device | DeviceError:
    """Return a device, or the error that prevents opening it.

    It is opened in another thread, as a new context would replace the caller's current one.
    """
    with ThreadPoolExecutor(1) as thread:
        try:
            return thread.submit(_probe, index).result()
        except DeviceError as error:
            return error


def _probe(index: int) -> Device:
    context = open_context(index)
    try:
        info = context.info
        name = info["GL_RENDERER"]
        software = any(word in name.lower() for word in SOFTWARE_NAMES)
        return Device(index, name, context.version_code, software, info["GL_MAX_TEXTURE_SIZE"])
    finally:
        close_context(context)


def _device_files() -> list[str]:
    return sorted(path for pattern in DEVICE_FILES for path in glob.glob(pattern))


def _why_unusable() -> str:
    """Return why a graphics card cannot be used, for the two common cases on Linux, or an empty text."""
    files = _device_files()
    closed = [path for path in files if not os.access(path, os.R_OK | os.W_OK)]
    if closed:
        return f"{closed[0]} may not be opened by this user (group video or render?)"
    if any(os.path.basename(path).startswith("nvidia") for path in files):
        return "NVIDIA's OpenGL is not installed (in a container: NVIDIA_DRIVER_CAPABILITIES=all)"
    return ""
