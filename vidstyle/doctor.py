"""Diagnosis of this machine and installation, for bug reports."""

from __future__ import annotations

import os
import platform
import sys
from importlib import metadata
from typing import Any

import vidstyle
from vidstyle.core.kernels.object_files import cache_state
from vidstyle.core.machine.cores import core_count
from vidstyle.errors import DeviceError
from vidstyle.gpu.device.devices import Device, choose, list_devices
from vidstyle.media.codecs import ffmpeg_version, list_decoder_devices, try_encoders
from vidstyle.media.hdr_encoding import try_hdr_encoders
from vidstyle.media.v4l2 import list_device_names

LIBRARIES = ("av", "numpy", "opencv-contrib-python-headless", "numba", "moderngl", "click", "rich", "tomlkit")


def diagnose() -> dict[str, Any]:
    """The facts by name. Encoders are opened, not only listed, which takes a second or two."""
    return {
        "vidstyle": vidstyle.__version__,
        "python": f"{platform.python_version()} ({sys.executable})",
        "system": platform.platform(),
        "cores": str(core_count()),
        "memory": _memory(),
        "libraries": {name: _version(name) for name in LIBRARIES},
        "ffmpeg": ffmpeg_version(),
        "encoders": try_encoders(),
        "hdr encoders": try_hdr_encoders(),
        "decoder devices": list_decoder_devices(),
        "gpu": _gpus(),
        "device auto": choose("auto").notice,
        "cameras": list_device_names(),
        "kernel cache": cache_state(),
    }


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "missing"


def _gpus() -> list[str] | str:
    """A line for each OpenGL device, or the reason why there is none."""
    try:
        choose("gpu")
    except DeviceError as error:
        return f"none ({error.reason}; {error.remedy})"
    return [_describe(device) for device in list_devices()]


def _describe(device: Device) -> str:
    version = f"OpenGL {device.version // 100}.{device.version // 10 % 10}"
    software = " (software: not a GPU)" if device.software else ""
    size = device.texture_size
    return f"{device}{software}, {version}, textures up to {size} x {size}, {device.form} passes"


def _memory() -> str:
    try:
        size = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # not on Windows
        return "unknown"
    return f"{size / 2**30:.1f} GiB"
