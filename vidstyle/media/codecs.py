"""Encoders: their quality and speed options, pixel formats, and which of them work here."""

from __future__ import annotations

import difflib
import os
import sys
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction

import av
from av.codec.hwaccel import hwdevices_available

from vidstyle.errors import UsageError, is_memory_short
from vidstyle.media.pixel_formats import PlaneLayout, layout_of

SOFTWARE = {
    **{"h264": "libx264", "hevc": "libx265", "av1": "libsvtav1", "vp9": "libvpx-vp9", "vp8": "libvpx"},
    **{"mpeg2": "mpeg2video", "mpeg4": "mpeg4", "mjpeg": "mjpeg", "prores": "prores_ks"},
}
"""The software encoder that stands in for a hardware one of the same codec."""
HARDWARE = ("nvenc", "qsv", "amf", "vaapi", "v4l2m2m", "videotoolbox", "mf", "vulkan", "rkmpp", "omx")
"""What the names of hardware encoders end with, after an underscore."""

LOW_DEPTH_FORMATS = ("rgb8", "bgr8", "rgb4", "bgr4", "rgb5", "bgr5", "rgb4_byte", "bgr4_byte", "pal8", "mono")
"""Prefixes of the names of formats with less than eight bits per colour."""


@dataclass(frozen=True)
class QualityOptions:
    """How `--crf` and `--preset` map to the options of an encoder.

    Attributes:
        crf: its option for the quality, "q" for a fixed quantiser, or "" if it has none.
        preset: its option for the speed, or "".
        quality, speed: the values when none are asked for; "" leaves the encoder's own.
        speeds: the accepted presets; empty: the encoder checks them itself.
        options: always set.
    """

    crf: str = ""
    preset: str = ""
    quality: str = ""
    speed: str = ""
    speeds: tuple[str, ...] = ()
    options: dict[str, str] = field(default_factory=dict)


X26_SPEEDS = (
    *("ultrafast", "superfast", "veryfast", "faster", "fast"),
    *("medium", "slow", "slower", "veryslow", "placebo"),
)
_QUANTISER = QualityOptions("q", quality="2")
_NVENC = QualityOptions("cq", "preset", "19", "p4", options={"rc": "vbr"})
_QSV = QualityOptions("global_quality", "preset", "20", "medium")
_AMF = QualityOptions("qvbr_quality_level", "quality")
_WEBP = QualityOptions(options={"quality": "90"})
QUALITY: dict[str, QualityOptions] = {
    "libx264": QualityOptions("crf", "preset", "18", "veryfast", X26_SPEEDS),
    "libx264rgb": QualityOptions("crf", "preset", "18", "veryfast", X26_SPEEDS),
    "libx265": QualityOptions("crf", "preset", "20", "fast", X26_SPEEDS, {"x265-params": "log-level=none"}),
    "libsvtav1": QualityOptions("crf", "preset", "26", "8", tuple("0123456789") + ("10", "11", "12", "13")),
    "libvpx-vp9": QualityOptions(
        "crf", "cpu-used", "24", "4", options={"b": "0", "row-mt": "1", "deadline": "good"}
    ),
    "libvpx": QualityOptions("crf", "cpu-used", "8", "4", options={"b": "20M", "deadline": "good"}),
    **dict.fromkeys(("h264_nvenc", "hevc_nvenc", "av1_nvenc"), _NVENC),
    **dict.fromkeys(("h264_qsv", "hevc_qsv", "av1_qsv", "vp9_qsv"), _QSV),
    **dict.fromkeys(("h264_amf", "hevc_amf", "av1_amf"), _AMF),
    **dict.fromkeys(("mpeg4", "mpeg2video", "mpeg1video", "mjpeg", "wmv1", "wmv2", "flv"), _QUANTISER),
    **dict.fromkeys(("libwebp", "libwebp_anim"), _WEBP),
    "apng": QualityOptions(options={"pred": "mixed"}),
}


def find_encoder(name: str) -> tuple[str, str]:
    """The encoder that a name means, and the canonical name of its codec: "hevc" gives libx265.

    Raises:
        UsageError: no video encoder is called so; it names those that come near.
    """
    try:
        codec = av.Codec(SOFTWARE.get(name, name), "w")
    except av.codec.codec.UnknownCodecError:
        codec = None
    if codec is not None and codec.type == "video":
        return codec.name, codec.canonical_name
    near = difflib.get_close_matches(name, [*QUALITY, *SOFTWARE, "prores_ks", "ffv1", "utvideo"], 3, 0.5)
    remedy = f"did you mean {' or '.join(near)}?" if near else "libx264 plays everywhere"
    raise UsageError("--codec", f"there is no video encoder {name!r} in this build", remedy)


def software_encoder(name: str) -> str | None:
    """The software encoder of the same codec if the name is a hardware encoder's, else None.

    >>> software_encoder("hevc_nvenc"), software_encoder("libx264")
    ('libx265', None)
    """
    codec, _, hardware = name.rpartition("_")
    return SOFTWARE.get(codec) if hardware in HARDWARE else None


def encoder_options(
    encoder: str, crf: float | None, preset: str | None, habitual: Collection[str] = ()
) -> dict[str, str]:
    """The encoder's own options for a quality and a speed; None for the default.

    Args:
        habitual: "crf", "preset" or both: left out where the encoder has no such setting.

    Raises:
        UsageError: the encoder has no such setting.
    """
    knobs = QUALITY.get(encoder, QualityOptions())
    crf = None if "crf" in habitual and not knobs.crf else crf
    preset = None if "preset" in habitual and not knobs.preset else preset
    if crf is not None and not knobs.crf:
        raise UsageError("--crf", f"the encoder {encoder} has no such setting", "leave it out")
    if preset is not None and not knobs.preset:
        raise UsageError("--preset", f"the encoder {encoder} has no such setting", "leave it out")
    if preset is not None and knobs.speeds and preset not in knobs.speeds:
        raise UsageError("--preset", f"{encoder} has no {preset!r}", f"use one of {', '.join(knobs.speeds)}")
    quality = knobs.quality if crf is None else f"{crf:g}"
    speed = knobs.speed if preset is None else preset
    options = dict(knobs.options)
    if quality and knobs.crf != "q":
        options[knobs.crf] = quality
    elif quality:
        options |= {"flags": "+qscale", "global_quality": str(round(118 * float(quality)))}
    return options | ({knobs.preset: speed} if speed else {})


def choose_pix_fmt(encoder: str, depth: int, step: tuple[int, int], rgb: bool, alpha: bool) -> str:
    """The default pixel format for an encoder: 4:2:0 for the codecs that play everywhere.

    For other codecs, the one that keeps most of a source of that depth, chroma step, colour kind and alpha.
    """
    codec = av.Codec(encoder, "w")
    names = [video_format.name for video_format in codec.video_formats or ()] or ["yuv420p"]
    if codec.canonical_name in ("h264", "hevc", "av1", "vp8", "vp9") and encoder != "libx264rgb":
        deep = depth > 8 and codec.canonical_name in ("hevc", "av1", "vp9")
        wanted = ("yuv420p10le", "p010le") if deep else ("yuv420p", "nv12")
        return next((name for name in wanted if name in names), names[0])
    layouts = [layout for name in names if (layout := writable_layout(name))]
    return min(layouts, key=lambda layout: _loss(layout, depth or 16, step, rgb, alpha)).name


def writable_layout(pix_fmt: str) -> PlaneLayout | None:
    """The layout of a pixel format, or None if pictures cannot be put into it without loss.

    Raises:
        ValueError: there is no such format.
    """
    layout = layout_of(pix_fmt)
    backward = layout is not None and layout.big_endian and not layout.reordered_as
    return None if backward or pix_fmt.startswith(LOW_DEPTH_FORMATS) else layout


def _loss(layout: PlaneLayout, depth: int, step: tuple[int, int], rgb: bool, alpha: bool) -> tuple[int, ...]:
    """Sort key of layouts: what they would lose, then what they would waste."""
    steps = list(zip(layout.step, step, strict=True))
    return (
        layout.planes < 3,
        alpha and not layout.alpha,
        (layout.kind != "luma") != rgb,
        max(0, depth - layout.depth),
        sum(max(0, its - wanted) for its, wanted in steps),
        layout.alpha and not alpha,
        max(0, layout.depth - depth) + sum(max(0, wanted - its) for its, wanted in steps),
        bool(layout.reordered_as),
    )


def open_encoder(context: av.CodecContext) -> None:
    """Open it, and leave the scheduling of threads as it is.

    As root SVT-AV1 gives its threads, and the one that opens it, the highest real-time priority, with which
    they keep everything else off the processor.

    Raises:
        FFmpegError, ValueError: its settings are refused.
    """
    if context.name == "libsvtav1":
        os.environ.setdefault("SVT_LOG", "1")  # otherwise it writes to standard error
    before = _scheduling() if sys.platform == "linux" else None
    try:
        context.open()
    finally:
        if before is not None and (changed := _scheduling()) != before:
            for thread in map(int, os.listdir("/proc/self/task")):
                with suppress(OSError):  # it has ended, perhaps
                    if _scheduling(thread) == changed:
                        os.sched_setscheduler(thread, *before)


def _scheduling(thread: int = 0) -> tuple[int, os.sched_param]:
    """Policy and priority of a thread; 0: of this one."""
    return os.sched_getscheduler(thread), os.sched_getparam(thread)


ENCODERS = (
    "libx264", "libx265", "libsvtav1", "libvpx-vp9", "ffv1", "prores_ks",
    "h264_nvenc", "hevc_nvenc", "av1_nvenc", "h264_qsv", "hevc_qsv", "h264_amf", "hevc_amf",
    "h264_videotoolbox", "hevc_videotoolbox", "h264_mf",
)  # fmt: skip
"""The encoders that `vidstyle doctor` tries."""


def ffmpeg_version() -> str:
    """The version of the FFmpeg inside PyAV."""
    return str(av.ffmpeg_version_info)


def encoders() -> dict[str, str]:
    """For each encoder "works", or why it does not: one frame is encoded with it."""
    return {name: _try_encoder(name) for name in ENCODERS}


def decoder_devices() -> list[str]:
    """The kinds of devices that this build can decode on, whether present or not."""
    return list(hwdevices_available())


def _try_encoder(name: str) -> str:
    if name not in av.codecs_available:
        return "not in this build"
    if is_memory_short():  # libsvtav1 ends the process where it gets none
        return "unknown (not enough memory to try it)"
    codec = av.Codec(name, "w")
    context = codec.create("video")
    context.width = context.height = 256
    context.pix_fmt = (codec.video_formats or [av.VideoFormat("yuv420p")])[0].name
    context.options = {"x265-params": "log-level=none"} if name == "libx265" else {}
    context.framerate, context.time_base = Fraction(25), Fraction(1, 25)
    frame = av.VideoFrame(256, 256, context.pix_fmt)
    frame.pts = 0
    try:
        open_encoder(context)
        context.encode(frame)
        context.encode(None)
    except av.FFmpegError as error:
        return f"no ({error.strerror})"
    return "works"
