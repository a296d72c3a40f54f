"""Options by which encoders store HDR metadata, and a check that it comes back."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

import av

from vidstyle.core.picture import Encoding, Transfer
from vidstyle.errors import log
from vidstyle.media.codecs import DOCTOR_ENCODERS, encoder_options, open_encoder
from vidstyle.media.color_tags import ColorTags, default_tags
from vidstyle.media.hdr_metadata import (
    HdrMetadata,
    MasteringDisplay,
    read_metadata,
)

MIN_HDR_DEPTH = 10
"""Bits of a sample below which the steps of PQ and HLG are visible (ITU-R BT.2100)."""
HDR_PIX_FMTS = ("yuv420p10le", "p010le")
X265_STEPS = 50_000, 10_000
"""Units per 1 of chromaticity and per 1 cd/m2 (H.265, D.3.28)."""
HDR_DECODERS = {"hevc": "hevc", "av1": "libdav1d"}
"""Decoders in software, by the codecs that keep HDR."""
CHECK_SIZE_PX = 256
"""Width and height of the picture that is encoded and decoded to check the metadata."""


def hdr_options(encoder: str, metadata: HdrMetadata) -> dict[str, str]:
    """Return the encoder's options for static metadata, which FFmpeg's own way does not reach from here.

    Metadata that the encoder cannot store is reported.
    """
    if metadata == HdrMetadata():
        return {}
    if not stores_metadata(encoder):
        log.warning("the static HDR metadata is dropped: %s cannot store it", encoder)
        return {}
    name, write = _PARAMETERS[encoder]
    return {name: ":".join(write(metadata))}


def with_parameters(options: dict[str, str], more: dict[str, str]) -> dict[str, str]:
    """Return encoder options with more of them; lists of parameters are joined.

    >>> with_parameters({"x265-params": "log-level=none"}, {"x265-params": "hdr10=1"})
    {'x265-params': 'log-level=none:hdr10=1'}
    """
    joined = {name: f"{options[name]}:{text}" for name, text in more.items() if name in options}
    return options | more | joined


def _x265_parameters(metadata: HdrMetadata) -> Iterable[str]:
    # Repeated at key frames, so that they survive a cut of the film.
    yield "hdr10=1:repeat-headers=1"
    if metadata.mastering:
        yield f"master-display={_display_text(metadata.mastering, *X265_STEPS)}"
    if metadata.content_light:
        yield "max-cll={},{}".format(*metadata.content_light)


def _svt_parameters(metadata: HdrMetadata) -> Iterable[str]:
    if metadata.mastering:
        yield f"mastering-display={_display_text(metadata.mastering, 1, 1)}"
    if metadata.content_light:
        yield "content-light={},{}".format(*metadata.content_light)


def _display_text(display: MasteringDisplay, chromaticity_step: int, luminance_step: int) -> str:
    def text(pair: tuple[float, float], step: int) -> str:
        return "({},{})".format(*(f"{round(each * step, 5):.10g}" for each in pair))

    places = {"G": display.green, "B": display.blue, "R": display.red, "WP": display.white}
    written = "".join(name + text(place, chromaticity_step) for name, place in places.items())
    return written + "L" + text((display.max_nits, display.min_nits), luminance_step)


def stores_metadata(encoder: str) -> bool:
    """Whether `hdr_options` knows how an encoder stores static metadata."""
    return encoder in _PARAMETERS


_PARAMETERS: dict[str, tuple[str, Callable[[HdrMetadata], Iterable[str]]]] = {
    "libx265": ("x265-params", _x265_parameters),
    "libsvtav1": ("svtav1-params", _svt_parameters),
}
"""By encoder: its option for parameters, and the function that writes them."""


def missing_hdr(context: av.VideoCodecContext, tags: ColorTags, metadata: HdrMetadata) -> str:
    """Encode a gray frame and decode it; return the name of the first lost property, or an empty text.

    Args:
        context: an encoder that is set up and not open.
        tags, metadata: what the stream should have.

    Raises:
        FFmpegError, ValueError: the encoder refuses its settings.
    """
    context.width = context.height = CHECK_SIZE_PX
    assert context.pix_fmt is not None
    frame = av.VideoFrame(CHECK_SIZE_PX, CHECK_SIZE_PX, context.pix_fmt)
    frame.pts, frame.time_base = 0, context.time_base
    open_encoder(context)
    packets = context.encode(frame) + context.encode(None)
    decoder = av.CodecContext.create(HDR_DECODERS[context.codec.canonical_name], "r")
    assert isinstance(decoder, av.VideoCodecContext)
    for packet in (*packets, None):
        for decoded in decoder.decode(packet):
            return _lost(ColorTags.of(decoded), read_metadata(decoded), tags, metadata)
    return "its frames"


def _lost(tags: ColorTags, metadata: HdrMetadata, wanted: ColorTags, declared: HdrMetadata) -> str:
    if tags != wanted:
        return "its colour tags"
    if declared.content_light not in (None, metadata.content_light):
        return "its content light levels"
    if declared.mastering and not (metadata.mastering and metadata.mastering.is_close(declared.mastering)):
        return "its mastering display"
    return ""


CHECKED_METADATA = HdrMetadata(
    MasteringDisplay((0.68, 0.32), (0.265, 0.69), (0.15, 0.06), (0.3127, 0.329), 1000, 0.005), (1000, 200)
)
"""Metadata of a usual HDR10 film: a display with DCI-P3 primaries."""


def try_hdr_encoders() -> dict[str, str]:
    """Return which HDR the encoders of `DOCTOR_ENCODERS` store on this machine, by name."""
    found = {name: describe_hdr(name) for name in DOCTOR_ENCODERS if name in av.codecs_available}
    return {name: text for name, text in found.items() if text}


def describe_hdr(encoder: str) -> str:
    """Return which HDR an encoder stores when it is tried, such as "HDR10, HLG"; empty: none."""
    codec = av.Codec(encoder, "w")
    names = [each.name for each in codec.video_formats or ()] if codec.canonical_name in HDR_DECODERS else []
    pix_fmt = next((name for name in HDR_PIX_FMTS if name in names), None)
    wanted: dict[str, tuple[Transfer, HdrMetadata]] = {
        "HDR10": ("pq", CHECKED_METADATA),
        "PQ": ("pq", HdrMetadata()),
        "HLG": ("hlg", HdrMetadata()),
    }
    stored = [name for name, each in wanted.items() if pix_fmt and _stores(encoder, pix_fmt, *each)]
    return ", ".join(name for name in stored if name != "PQ" or "HDR10" not in stored)


def _stores(encoder: str, pix_fmt: str, transfer: Transfer, metadata: HdrMetadata) -> bool:
    if metadata != HdrMetadata() and not stores_metadata(encoder):
        return False
    context = av.CodecContext.create(encoder, "w")
    assert isinstance(context, av.VideoCodecContext)
    context.pix_fmt, context.framerate, context.time_base = pix_fmt, Fraction(25), Fraction(1, 25)
    tags = default_tags(Encoding("bt2020", transfer=transfer))
    tags.put_on(context)
    context.options = with_parameters(encoder_options(encoder, None, None), hdr_options(encoder, metadata))
    try:
        return not missing_hdr(context, tags, metadata)
    except (av.FFmpegError, ValueError):
        return False
