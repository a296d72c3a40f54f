"""Encoders: options for quality and speed, pixel formats, and a check which of them work."""

from __future__ import annotations

import difflib
import os
import re
import sys
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction

import av
from av.codec.hwaccel import hwdevices_available

from vidstyle.errors import UsageError, is_memory_short
from vidstyle.media.pixel_formats import PlaneLayout, layout_of

SOFTWARE_ENCODERS = {
    **{"h264": "libx264", "hevc": "libx265", "av1": "libsvtav1", "vp9": "libvpx-vp9", "vp8": "libvpx"},
    **{"mpeg2": "mpeg2video", "mpeg4": "mpeg4", "mjpeg": "mjpeg", "prores": "prores_ks"},
    "dnxhr": "dnxhd",
}
"""Software encoder that replaces a hardware encoder, by codec."""
HARDWARE_SUFFIXES = (
    "nvenc",
    "qsv",
    "amf",
    "vaapi",
    "v4l2m2m",
    "videotoolbox",
    "mf",
    "vulkan",
    "rkmpp",
    "omx",
)
"""Endings of the names of hardware encoders, after an underscore."""

LOW_DEPTH_FORMATS = re.compile(r"(rgb|bgr)(8|4|4_byte|5\d\d[lb]e)|pal8|mono\w+")
"""Names of formats with fewer than eight bits per colour channel."""


@dataclass(frozen=True)
class QualityOptions:
    """How `--crf` and `--preset` map to the options of an encoder.

    Attributes:
        crf: the encoder's option for the quality, "q" for a fixed quantizer, or "" if it has none.
        preset: the encoder's option for the speed, or "".
        quality, speed: default values; "" keeps the default of the encoder.
        speeds: the accepted presets; empty: the encoder checks the preset.
        options: always set.
    """

    crf: str = ""
    preset: str = ""
    quality: str = ""
    speed: str = ""
    speeds: tuple[str, ...] = ()
    options: dict[str, str] = field(default_factory=dict)


X26_PRESETS = (
    *("ultrafast", "superfast", "veryfast", "faster", "fast"),
    *("medium", "slow", "slower", "veryslow", "placebo"),
)
_QUANTIZER_OPTIONS = QualityOptions("q", quality="2")
_NVENC_OPTIONS = QualityOptions("cq", "preset", "19", "p4", options={"rc": "vbr"})
_QSV_OPTIONS = QualityOptions("global_quality", "preset", "20", "medium")
_AMF_OPTIONS = QualityOptions("qvbr_quality_level", "quality")
_WEBP_OPTIONS = QualityOptions(options={"quality": "90"})
QUALITY_OPTIONS: dict[str, QualityOptions] = {
    "libx264": QualityOptions("crf", "preset", "18", "veryfast", X26_PRESETS),
    "libx264rgb": QualityOptions("crf", "preset", "18", "veryfast", X26_PRESETS),
    "libx265": QualityOptions("crf", "preset", "20", "fast", X26_PRESETS, {"x265-params": "log-level=none"}),
    "libsvtav1": QualityOptions("crf", "preset", "26", "8", tuple("0123456789") + ("10", "11", "12", "13")),
    "libvpx-vp9": QualityOptions(
        "crf", "cpu-used", "24", "4", options={"b": "0", "row-mt": "1", "deadline": "good"}
    ),
    "libvpx": QualityOptions("crf", "cpu-used", "8", "4", options={"b": "20M", "deadline": "good"}),
    **dict.fromkeys(("h264_nvenc", "hevc_nvenc", "av1_nvenc"), _NVENC_OPTIONS),
    **dict.fromkeys(("h264_qsv", "hevc_qsv", "av1_qsv", "vp9_qsv"), _QSV_OPTIONS),
    **dict.fromkeys(("h264_amf", "hevc_amf", "av1_amf"), _AMF_OPTIONS),
    **dict.fromkeys(
        ("mpeg4", "mpeg2video", "mpeg1video", "mjpeg", "wmv1", "wmv2", "flv"), _QUANTIZER_OPTIONS
    ),
    **dict.fromkeys(("libwebp", "libwebp_anim"), _WEBP_OPTIONS),
    "apng": QualityOptions(options={"pred": "mixed"}),
}


def find_encoder(name: str) -> tuple[str, str]:
    """Return the encoder for a name, and the canonical name of its codec: "hevc" gives libx265.

    Raises:
        UsageError: there is no such video encoder; the message suggests similar names.
    """
    try:
        codec = av.Codec(SOFTWARE_ENCODERS.get(name, name), "w")
    except av.codec.codec.UnknownCodecError:
        codec = None
    if codec is not None and codec.type == "video":
        return codec.name, codec.canonical_name
    near = difflib.get_close_matches(
        name, [*QUALITY_OPTIONS, *SOFTWARE_ENCODERS, "prores_ks", "ffv1", "utvideo"], 3, 0.5
    )
    remedy = f"did you mean {' or '.join(near)}?" if near else "libx264 plays everywhere"
    raise UsageError("--codec", f"there is no video encoder {name!r} in this build", remedy)


def find_software_encoder(name: str) -> str | None:
    """Return the software encoder of the same codec for the name of a hardware encoder, else None.

    >>> find_software_encoder("hevc_nvenc"), find_software_encoder("libx264")
    ('libx265', None)
    """
    codec, _, hardware = name.rpartition("_")
    return SOFTWARE_ENCODERS.get(codec) if hardware in HARDWARE_SUFFIXES else None


def encoder_options(
    encoder: str, crf: float | None, preset: str | None, optional: Collection[str] = ()
) -> dict[str, str]:
    """Return the options of an encoder for a quality and a speed; None selects the default.

    Args:
        optional: "crf", "preset" or both: ignored if the encoder has no such setting.

    Raises:
        UsageError: the encoder has no such setting.
    """
    knobs = QUALITY_OPTIONS.get(encoder, QualityOptions())
    crf = None if "crf" in optional and not knobs.crf else crf
    preset = None if "preset" in optional and not knobs.preset else preset
    if crf is not None and not knobs.crf:
        raise UsageError("--crf", f"the encoder {encoder} has no such setting", "remove it")
    if preset is not None and not knobs.preset:
        raise UsageError("--preset", f"the encoder {encoder} has no such setting", "remove it")
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


def choose_pix_fmt(
    encoder: str,
    depth: int,
    subsampling: tuple[int, int],
    rgb: bool,
    alpha: bool,
    raw_formats: Collection[str] = (),
) -> str:
    """Return the default pixel format of an encoder: 4:2:0 for the codecs that play everywhere.

    For other codecs, the format that loses least of a source of this depth, subsampling, colours and alpha.

    Args:
        raw_formats: formats of an encoder that lists none.
    """
    codec = av.Codec(encoder, "w")
    names = [each.name for each in codec.video_formats or ()] or list(raw_formats) or ["yuv420p"]
    if codec.canonical_name in ("h264", "hevc", "av1", "vp8", "vp9") and encoder != "libx264rgb":
        deep = depth > 8 and codec.canonical_name in ("hevc", "av1", "vp9")
        wanted = ["yuv420p10le", "p010le"] if deep else ["yuv420p", "nv12"]
        if alpha and codec.canonical_name in ALPHA_CODECS:
            wanted = ["yuva420p"]
        return next((name for name in wanted if name in names), names[0])
    layouts = [layout for name in names if (layout := writable_layout(name))]
    return min(
        layouts, key=lambda layout: _rank_conversion(layout, depth or 16, subsampling, rgb, alpha)
    ).name


ALPHA_CODECS = ("vp8", "vp9")
"""Codecs whose alpha channel is stored next to the packets, for which a container needs a place."""
DNXHR_PROFILES = {("luma", 8): "dnxhr_hq", ("luma", 10): "dnxhr_hqx"}


def format_options(encoder: str, layout: PlaneLayout) -> dict[str, str]:
    """Return options that an encoder needs for a pixel format."""
    if encoder == "dnxhd":
        is_full = layout.subsampling == (1, 1)
        return {"profile": "dnxhr_444" if is_full else DNXHR_PROFILES[layout.kind, layout.depth]}
    # libvpx has no place for the alpha of a frame that is never shown.
    return {"auto-alt-ref": "0"} if encoder.startswith("libvpx") and layout.alpha else {}


def writable_layout(pix_fmt: str) -> PlaneLayout | None:
    """Return the layout of a pixel format, or None if pictures cannot be stored in it without loss.

    Raises:
        ValueError: there is no such format.
    """
    layout = layout_of(pix_fmt)
    backward = layout is not None and layout.big_endian and not layout.reordered_as
    return None if backward or LOW_DEPTH_FORMATS.fullmatch(pix_fmt) else layout


def _rank_conversion(
    layout: PlaneLayout, depth: int, subsampling: tuple[int, int], rgb: bool, alpha: bool
) -> tuple[int, ...]:
    """Return a sort key for layouts: first what they lose, then what they waste."""
    steps = list(zip(layout.subsampling, subsampling, strict=True))
    return (
        layout.planes < 3,
        alpha and not layout.alpha,
        max(0, depth - layout.depth),
        (layout.kind != "luma") != rgb,
        sum(max(0, its - wanted) for its, wanted in steps),
        layout.alpha and not alpha,
        max(0, layout.depth - depth) + sum(max(0, wanted - its) for its, wanted in steps),
        bool(layout.reordered_as),
    )


def open_encoder(context: av.CodecContext) -> None:
    """Open an encoder without changing the scheduling of threads.

    If it runs as root, SVT-AV1 sets the highest real-time priority for its threads and for the thread that
    opens it, which blocks all other processes.

    Raises:
        FFmpegError, ValueError: the encoder rejects its settings.
    """
    if context.name == "libsvtav1":
        os.environ.setdefault("SVT_LOG", "1")  # otherwise it writes to standard error
    before = _scheduling() if sys.platform == "linux" else None
    try:
        context.open()
    finally:
        if before is not None and (changed := _scheduling()) != before:
            for thread in map(int, os.listdir("/proc/self/task")):
                with suppress(OSError):  # it may have ended
                    if _scheduling(thread) == changed:
                        os.sched_setscheduler(thread, *before)


def _scheduling(thread: int = 0) -> tuple[int, os.sched_param]:
    """Return policy and priority of a thread; 0: the current thread."""
    return os.sched_getscheduler(thread), os.sched_getparam(thread)


DOCTOR_ENCODERS = (
    "libx264", "libx265", "libsvtav1", "libvpx-vp9", "ffv1", "prores_ks",
    "h264_nvenc", "hevc_nvenc", "av1_nvenc", "h264_qsv", "hevc_qsv", "h264_amf", "hevc_amf",
    "h264_videotoolbox", "hevc_videotoolbox", "h264_mf",
)  # fmt: skip
"""The encoders that `vidstyle doctor` tries."""


def ffmpeg_version() -> str:
    """Return the version of FFmpeg in PyAV."""
    return str(av.ffmpeg_version_info)


def try_encoders() -> dict[str, str]:
    """Encode one frame with each encoder; return "works" or the reason why it does not, by name."""
    return {name: _try_encoder(name) for name in DOCTOR_ENCODERS}


def list_decoder_devices() -> list[str]:
    """Return the device types that this build can decode on, present or not."""
    return list(hwdevices_available())


def _try_encoder(name: str) -> str:
    if name not in av.codecs_available:
        return "not in this build"
    if is_memory_short():  # libsvtav1 ends the process if an allocation fails
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
