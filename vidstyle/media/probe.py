"""What FFmpeg can do on this machine."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import av
from av.codec.hwaccel import hwdevices_available

ENCODERS = (
    "libx264", "libx265", "libsvtav1", "libvpx-vp9", "ffv1", "prores_ks",
    "h264_nvenc", "hevc_nvenc", "av1_nvenc", "h264_qsv", "hevc_qsv", "h264_amf", "hevc_amf",
    "h264_videotoolbox", "hevc_videotoolbox", "h264_mf",
)  # fmt: skip
"""Those that people ask for by name."""
CAMERA_FOLDER = Path("/sys/class/video4linux")


def ffmpeg_version() -> str:
    """The version of the FFmpeg inside PyAV."""
    return str(av.ffmpeg_version_info)


def encoders() -> dict[str, str]:
    """For each encoder "works", or why it does not: one frame is encoded with it."""
    os.environ.setdefault("SVT_LOG", "0")  # it talks on standard error otherwise
    return {name: _try_encoder(name) for name in ENCODERS}


def decoder_devices() -> list[str]:
    """The kinds of devices that this build can decode on, whether there is one here or not."""
    return list(hwdevices_available())


def cameras() -> list[str]:
    """The video devices of this machine with their names; Linux only."""
    if not CAMERA_FOLDER.is_dir():
        return []
    return [
        f"/dev/{device.name} ({(device / 'name').read_text().strip()})"
        for device in sorted(CAMERA_FOLDER.iterdir())
    ]


def _try_encoder(name: str) -> str:
    if name not in av.codecs_available:
        return "not in this build"
    codec = av.Codec(name, "w")
    context = codec.create("video")
    context.width = context.height = 256
    context.pix_fmt = (codec.video_formats or [av.VideoFormat("yuv420p")])[0].name
    context.options = {"x265-params": "log-level=none"} if name == "libx265" else {}
    context.framerate, context.time_base = Fraction(25), Fraction(1, 25)
    frame = av.VideoFrame(256, 256, context.pix_fmt)
    frame.pts = 0
    try:
        context.encode(frame)
        context.encode(None)
    except av.FFmpegError as error:
        return f"no ({error.strerror})"
    return "works"
