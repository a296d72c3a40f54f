"""Virtual cameras (v4l2loopback): other programs read what is written as a camera."""

from __future__ import annotations

import os
from pathlib import Path

import av

from vidstyle.errors import DeviceError, OutputError, UsageError
from vidstyle.media.v4l2 import video_device
from vidstyle.media.write.stream import Stream, StreamOptions

CAMERA_FORMATS = {"yuyv422": "yuyv422", "nv12": "nv12", "yuv420p": "yuv420p", "i420": "yuv420p"}
"""Pixel formats that the readers of virtual cameras understand; browsers and calls want the first."""


def open_virtual_camera(path: str, options: StreamOptions, first: av.VideoFrame) -> Stream:
    """Begin to write to one.

    Raises:
        UsageError: a pixel format that cameras do not have.
        DeviceError: it is not there, or is no virtual camera.
    """
    pix_fmt = CAMERA_FORMATS.get(options.pix_fmt or "yuyv422")
    if pix_fmt is None:
        known = ", ".join(CAMERA_FORMATS)
        raise UsageError("--pix-fmt", f"{options.pix_fmt} is none of a virtual camera's", f"use {known}")
    check_virtual_camera(path)
    try:
        return Stream(path, path, "v4l2", options, first, pix_fmt)
    except OutputError as error:
        raise DeviceError(path, error.reason) from error


def check_virtual_camera(path: str) -> None:
    """Raise DeviceError if nothing can be written there; it says what brings a virtual camera about."""
    device = video_device(path)
    if device is not None and device.can_output:
        return
    number = "".join(character for character in path if character.isdigit()) or "9"
    make = f"sudo modprobe v4l2loopback video_nr={number} card_label=vidstyle exclusive_caps=1"
    if device is not None:
        raise DeviceError(
            path, f"is the camera {device.name}, and takes no pictures", f"make another: {make}"
        )
    if Path(path).exists() and not os.access(path, os.R_OK | os.W_OK):
        raise DeviceError(path, "no permission to open it", "join the group that owns it, mostly video")
    if Path(path).exists():
        raise DeviceError(path, "is not a virtual camera")
    raise DeviceError(path, "there is no such virtual camera", f"make one: {make}")
