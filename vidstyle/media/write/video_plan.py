"""Selects encoder, pixel format and settings for video, and checks that the encoder accepts them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import av

from vidstyle.core.machine.cores import available_cores, imposed_threads
from vidstyle.core.picture import SITINGS, Encoding
from vidstyle.errors import UsageError, error_reason, is_memory_short, log
from vidstyle.media.codecs import (
    ALPHA_CODECS,
    SOFTWARE_ENCODERS,
    choose_pix_fmt,
    encoder_options,
    find_encoder,
    find_software_encoder,
    format_options,
    open_encoder,
    writable_layout,
)
from vidstyle.media.color_tags import FULL_RANGE, UNSPECIFIED_CODE, ColorTags
from vidstyle.media.hdr_encoding import (
    HDR_PIX_FMTS,
    MIN_HDR_DEPTH,
    hdr_options,
    missing_hdr,
    stores_metadata,
    with_parameters,
)
from vidstyle.media.hdr_metadata import HdrMetadata
from vidstyle.media.options import VideoInfo, WriteOptions
from vidstyle.media.pixel_formats import PlaneLayout
from vidstyle.media.write.containers import ContainerKind, hdr_endings

RANGED_CODECS = ("h264", "hevc", "av1", "vp9", "vvc")
"""Codecs whose streams signal full range; for other codecs, the container may signal it."""
LIMITED_CODECS = ("vp8", "prores", "dnxhd", "mpeg1video", "mpeg2video", "theora", "flv1", "wmv1", "wmv2")
"""Codecs that players treat as limited range, independent of the container."""
RGB_MATRIX = 0
"""The H.273 code of the identity matrix."""
MAX_TIME_BASES = {"mpeg4": 65535, "mpeg2video": 60000, "mpeg1video": 60000, "flv1": 1000, "wmv2": 1000}
"""Maximum denominator of the time base of codecs that store times in the video stream."""
DEFAULT_FRAME_RATE = Fraction(25)
MAX_DELAY_SECONDS = 1
"""Maximum delay of an encoder in seconds of film, which are lost if the program is killed."""
X264_LOOKAHEAD = {
    **{"ultrafast": 0, "superfast": 0, "veryfast": 10, "faster": 20, "fast": 30},
    **{"medium": 40, "slow": 50, "slower": 60, "veryslow": 60, "placebo": 60},
}
"""Lookahead of x264 in frames, for each preset."""
X264_REORDERED_FRAMES = 3
"""Delay of x264 in frames for reordering B-frames."""


@dataclass(frozen=True)
class VideoPlan:
    """How pictures are encoded.

    Attributes:
        encoder, codec: name of the encoder, and canonical name of its codec.
        pix_fmt: pixel format of the frames for the encoder, and its layout.
        size: encoded width and height, padded to a multiple of the subsampling.
        encoding: expected encoding of the pictures.
        tags: colour tags.
        time_base, rate: time base and nominal rate of the frames.
        max_gap: maximum time between two frames, in seconds; None: unlimited.
        options: encoder options.
        codec_tag: the code of the codec in the container; "": the usual one.
        hdr: static metadata of HDR pictures.
    """

    encoder: str
    codec: str
    pix_fmt: str
    layout: PlaneLayout
    size: tuple[int, int]
    encoding: Encoding
    tags: ColorTags
    time_base: Fraction
    rate: Fraction
    max_gap: Fraction | None
    sample_aspect: Fraction | None
    options: dict[str, str]
    codec_tag: str = ""
    hdr: HdrMetadata = HdrMetadata()

    @property
    def rgb(self) -> bool:
        """Whether it expects RGB pictures."""
        return self.layout.kind != "luma"

    def configure(self, context: av.VideoCodecContext) -> None:
        """Set up an encoder that is not open yet."""
        context.width, context.height = self.size
        context.pix_fmt = self.pix_fmt
        context.time_base = self.time_base
        context.framerate = self.rate
        context.thread_type = "AUTO"
        context.thread_count = imposed_threads()
        if self.sample_aspect:
            context.sample_aspect_ratio = self.sample_aspect
        if self.codec_tag:
            context.codec_tag = self.codec_tag
        self.tags.put_on(context)
        context.options = dict(self.options)


def plan_video(target: str, kind: ContainerKind, info: VideoInfo, options: WriteOptions) -> VideoPlan:
    """Return the plan for a film, after opening the encoder with this size and format.

    Raises:
        UsageError: the container does not support the codec, or the encoder refuses size, format or settings.
    """
    encoder, pix_fmt = options.codec or kind.codec, options.pix_fmt
    if info.encoding.is_hdr and options.codec is None and kind.hdr:
        encoder = SOFTWARE_ENCODERS[kind.hdr[0]]
    elif options.codec is None and pix_fmt is None:
        encoder, pix_fmt = kind.alpha if info.alpha and kind.alpha else (encoder, kind.pix_fmt)
    stand_in = find_software_encoder(encoder)
    try:
        plan = _make_plan(kind, info, options, encoder, pix_fmt)
        _try_encoder(target, plan)
    except UsageError as error:
        if stand_in is None:
            raise
        log.warning("%s cannot be used here (%s); %s is used instead", encoder, error.reason, stand_in)
        # The names of presets differ between hardware and software encoders.
        plan = _make_plan(kind, info, replace(options, preset=None), stand_in, pix_fmt)
        _try_encoder(target, plan)
    _announce(target, info, plan)
    return plan


def _make_plan(
    kind: ContainerKind, info: VideoInfo, options: WriteOptions, name: str, pix_fmt: str | None
) -> VideoPlan:
    encoder, codec = find_encoder(name)
    if kind.video and codec not in kind.video:
        remedy = f"use one of {', '.join(kind.video)}, or an output name that ends in .mkv"
        raise UsageError("--codec", f"{kind.endings[0]} files do not support {codec}", remedy)
    source = info.encoding
    if source.is_hdr:
        _check_hdr_support(kind, codec, encoder)
    # Only containers with a place for alpha next to the packets can hold the alpha of VP8 and VP9.
    alpha = info.alpha and (kind.alpha is not None or codec not in ALPHA_CODECS)
    pix_fmt = pix_fmt or choose_pix_fmt(
        encoder, source.depth, source.subsampling, info.is_rgb, alpha, kind.raw_formats
    )
    # The colour tags signal the full range of the old yuvj formats.
    layout = _layout(pix_fmt.replace("yuvj", "yuv"))
    encoding = _encoding(info, layout, codec, kind)
    if pix_fmt.startswith("yuvj"):
        encoding = replace(encoding, full_range=True)
    rate = info.rate or DEFAULT_FRAME_RATE
    rate = min(rate, Fraction(kind.max_rate or rate))
    own = encoder_options(encoder, options.crf, options.preset, options.optional)
    own |= format_options(encoder, layout)
    if source.is_hdr:
        _check_hdr_format(layout)
        own = with_parameters(own, hdr_options(encoder, info.hdr))
    return VideoPlan(
        encoder=encoder,
        codec=codec,
        pix_fmt=layout.name,
        layout=layout,
        size=(
            _pad_length(info.width, layout.subsampling[0]),
            _pad_length(info.height, layout.subsampling[1]),
        ),
        encoding=encoding,
        tags=_tags(info, encoding, layout, kind),
        time_base=_time_base(kind, codec, info, rate),
        rate=rate,
        max_gap=kind.max_gap_frames / rate if kind.max_gap_frames else None,
        sample_aspect=info.sample_aspect,
        options=own | _latency(encoder, rate, own.get("preset", "")) | _siting(encoding),
        codec_tag=kind.codec_tags.get(codec, ""),
        hdr=info.hdr if stores_metadata(encoder) else HdrMetadata(),
    )


def _check_hdr_support(kind: ContainerKind, codec: str, encoder: str) -> None:
    """Raise UsageError if a container, or a codec in it, does not keep HDR."""
    if not kind.hdr:
        remedy = f"use one of {', '.join(hdr_endings())}, or --hdr map"
        raise UsageError("--hdr keep", f"{kind.endings[0]} files do not store HDR", remedy)
    if codec not in kind.hdr:
        names = " or ".join(SOFTWARE_ENCODERS[each] for each in kind.hdr)
        reason = f"{encoder} does not store HDR in {kind.endings[0]} files"
        raise UsageError("--hdr keep", reason, f"use --codec {names}, or --hdr map")


def _check_hdr_format(layout: PlaneLayout) -> None:
    if layout.depth < MIN_HDR_DEPTH or layout.kind != "luma" or layout.planes < 3:
        reason = f"{layout.name} cannot be used for HDR"
        raise UsageError("--pix-fmt", reason, f"use {HDR_PIX_FMTS[0]}, or --hdr map")


def _layout(pix_fmt: str) -> PlaneLayout:
    try:
        layout = writable_layout(pix_fmt)
    except ValueError:
        layout = None
    if layout is None:
        reason = f"{pix_fmt!r} is not a supported pixel format"
        raise UsageError("--pix-fmt", reason, "yuv420p plays everywhere")
    return layout


def _pad_length(length: int, step: int) -> int:
    """Round the length up to a multiple of the step.

    >>> _pad_length(641, 2), _pad_length(640, 2)
    (642, 640)
    """
    return -(-length // step) * step


def _encoding(info: VideoInfo, layout: PlaneLayout, codec: str, kind: ContainerKind) -> Encoding:
    """Return the source's matrix, range and siting, adapted to the new layout and to the signalled range."""
    if layout.kind != "luma":
        return Encoding("bt709", True, layout.depth, (1, 1))
    if codec == "mjpeg":  # JFIF knows no other
        siting = (layout.subsampling[0] - 1) / 2, (layout.subsampling[1] - 1) / 2
        return Encoding("bt601", True, layout.depth, layout.subsampling, siting)
    if info.is_rgb:
        matrix = "bt2020" if info.encoding.is_hdr else "bt709"
        return Encoding(matrix, False, layout.depth, layout.subsampling, transfer=info.encoding.transfer)
    siting = info.encoding.siting
    if layout.subsampling != info.encoding.subsampling or siting not in SITINGS.values():
        siting = SITINGS["left"] if layout.subsampling[1] == 2 else SITINGS["topleft"]
    has_range = codec in RANGED_CODECS or kind.ranged and codec not in LIMITED_CODECS
    full_range = info.encoding.full_range and has_range
    return replace(
        info.encoding,
        depth=layout.depth,
        subsampling=layout.subsampling,
        siting=siting,
        full_range=full_range,
    )


def _tags(info: VideoInfo, encoding: Encoding, layout: PlaneLayout, kind: ContainerKind) -> ColorTags:
    """Return the tags for the encoding: the source's tags, and defaults for missing ones."""
    if layout.kind != "luma" and kind.untagged:
        return ColorTags(UNSPECIFIED_CODE, UNSPECIFIED_CODE, RGB_MATRIX, FULL_RANGE)
    matrix = info.color_tags.matrix if encoding.matrix == info.encoding.matrix else UNSPECIFIED_CODE
    tags = replace(info.color_tags, matrix=matrix).completed(encoding, info.height)
    return tags if layout.kind == "luma" else replace(tags, matrix=RGB_MATRIX)


def _siting(encoding: Encoding) -> dict[str, str]:
    name = next((name for name, place in SITINGS.items() if place == encoding.siting), None)
    return {"chroma_sample_location": name} if name and encoding.subsampling == (2, 2) else {}


def _time_base(kind: ContainerKind, codec: str, info: VideoInfo, rate: Fraction) -> Fraction:
    """Return the source's time base, or a coarser one if container or codec require it."""
    if kind.strict_rate:
        return 1 / rate
    finest = MAX_TIME_BASES.get(codec, kind.max_time_base)
    if finest is None or info.time_base.denominator <= finest:
        return info.time_base
    return 1 / rate if codec in MAX_TIME_BASES and rate.numerator <= finest else Fraction(1, finest)


def _latency(encoder: str, rate: Fraction, preset: str) -> dict[str, str]:
    """Return settings that limit the delay of an encoder, to which its threads and lookahead contribute.

    The lookahead is never longer than the preset's.
    """
    held = int(rate * MAX_DELAY_SECONDS)
    if encoder in ("libvpx", "libvpx-vp9"):
        return {"lag-in-frames": str(min(25, max(1, held)))}
    if encoder not in ("libx264", "libx264rgb"):
        return {}
    room = max(2, held - X264_REORDERED_FRAMES)
    threads = max(1, available_cores() * 3 // 2)
    lookahead = X264_LOOKAHEAD[preset]
    if threads + lookahead <= room:
        return {}
    threads = min(threads, max(1, room * 2 // 3))
    return {"threads": str(threads), "rc-lookahead": str(min(lookahead, room - threads))}


def _try_encoder(target: str, plan: VideoPlan) -> None:
    """Open and close the encoder with the settings of the plan."""
    if plan.encoder in ("rawvideo", "wrapped_avframe"):
        return
    context = av.CodecContext.create(plan.encoder, "w")
    assert isinstance(context, av.VideoCodecContext)
    plan.configure(context)
    try:
        open_encoder(context)
    except (av.FFmpegError, ValueError) as error:
        if is_memory_short():
            raise MemoryError from error
        width, height = plan.size
        settings = " ".join(f"{name}={value}" for name, value in plan.options.items())
        reason = f"{plan.encoder} refuses {width}x{height} {plan.pix_fmt} {settings} ({error_reason(error)})"
        raise UsageError(target, reason, "choose another codec, size or setting") from error
    if plan.encoding.is_hdr:
        _check_stored_hdr(target, plan)


def _check_stored_hdr(target: str, plan: VideoPlan) -> None:
    """Raise UsageError if a decoder does not find the tags and the metadata in what the encoder writes."""
    context = av.CodecContext.create(plan.encoder, "w")
    assert isinstance(context, av.VideoCodecContext)
    plan.configure(context)
    if lost := missing_hdr(context, plan.tags, plan.hdr):
        reason = f"{plan.encoder} loses {lost} of HDR"
        raise UsageError(target, reason, "choose another codec, or --hdr map")


def _announce(target: str, info: VideoInfo, plan: VideoPlan) -> None:
    if plan.size != (info.width, info.height):
        wide, high = plan.size[0] - info.width, plan.size[1] - info.height
        log.warning(
            "%s: %dx%d is padded to %dx%d, because %s has subsampled chroma (repeating the last %s)",
            *(target, info.width, info.height, *plan.size, plan.pix_fmt),
            " and ".join(["column"] * bool(wide) + ["row"] * bool(high)),
        )
    if info.encoding.full_range and not plan.encoding.full_range and not info.is_rgb:
        log.warning("%s: full range becomes limited, because %s cannot signal it here", target, plan.codec)
    if info.alpha and not plan.layout.alpha:
        reason = f"{plan.pix_fmt} has no alpha channel"
        log.warning("%s: transparency is lost, because %s; see --matte", target, reason)
