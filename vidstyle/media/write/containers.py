"""The table of containers: muxers, codecs and options of every output format."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any, Literal

from vidstyle.errors import UsageError
from vidstyle.media.options import PIPE_FORMATS

WriteMethod = Literal["film", "gif", "picture"]
"""How a file is written: packet by packet; at the end, with one palette; one file per picture."""

PCM_CODECS = "pcm_s16le pcm_s16be pcm_s24le pcm_s24be pcm_s32le pcm_s32be pcm_u8 pcm_f32le"
LITTLE_ENDIAN_PCM_CODECS = "pcm_s16le pcm_s24le pcm_s32le pcm_u8 pcm_f32le pcm_f64le"


@dataclass(frozen=True)
class ContainerKind:
    """A container format.

    Attributes:
        muxer: FFmpeg's name of the muxer.
        endings: its file name extensions, the usual one first.
        codec, pix_fmt: default encoder and pixel format; "": depends on the source.
        video: canonical names of the video codecs that players accept in it; empty: any.
        way: how it is written.
        alpha: the encoder and pixel format for pictures with alpha, "": depends on the source; None: not
            supported.
        raw_formats: pixel formats of raw video in it.
        hdr: canonical names of the codecs that keep HDR in it, the usual one first; empty: none does.
        codec_tags: codes of codecs that players expect, where FFmpeg's usual ones differ.
        audio: canonical names of audio codecs that players accept in it.
        untimed: audio codecs without timestamps in it, so that their sound always starts at 0.
        new_audio: the encoder for transcoded audio; "": it supports no audio.
        subtitles: canonical names of supported subtitle codecs; text is converted to the first one.
        data: canonical names of supported data codecs.
        attachments: whether it supports fonts and other attachments.
        covers, chapters: whether it supports a cover picture, and chapters.
        strict_rate: whether it has a constant frame rate and no timestamps.
        max_time_base: maximum denominator of the time base; None: any.
        max_rate: maximum frame rate; None: any.
        max_gap_frames: maximum gap between two frames, in frames; None: any.
        indexed: whether its index is moved to the front (faststart).
        resumable: whether `--resume` can continue it.
        ranged: whether it signals full range, for all codecs.
        untagged: whether viewers assume sRGB; with the colour tags of a film, pictures would look different.
        framed_aac: whether AAC keeps its ADTS headers in it.
        bibliographic: whether it uses bibliographic language codes: "ger" for "deu".
        options: muxer options; `piped_options` for outputs without seeking.
        late_options: changed options if a stream starts long after the pictures, for a muxer that otherwise
            buffers everything until each stream has started.
        piped: whether it can be written to a pipe.
    """

    muxer: str
    endings: tuple[str, ...]
    codec: str
    video: tuple[str, ...] = ()
    pix_fmt: str = ""
    way: WriteMethod = "film"
    alpha: tuple[str, str] | None = None
    raw_formats: tuple[str, ...] = ()
    hdr: tuple[str, ...] = ()
    codec_tags: dict[str, str] = field(default_factory=dict)
    audio: tuple[str, ...] = ()
    untimed: tuple[str, ...] = ()
    new_audio: str = ""
    subtitles: tuple[str, ...] = ()
    data: tuple[str, ...] = ()
    attachments: bool = False
    covers: bool = False
    chapters: bool = False
    strict_rate: bool = False
    max_time_base: int | None = None
    max_rate: int | None = None
    max_gap_frames: int | None = None
    indexed: bool = False
    resumable: bool = False
    ranged: bool = False
    untagged: bool = False
    framed_aac: bool = False
    bibliographic: bool = False
    options: dict[str, str] = field(default_factory=dict)
    piped_options: dict[str, str] = field(default_factory=dict)
    late_options: dict[str, str] = field(default_factory=dict)
    piped: bool = False


# Without delay_moov, fragments have no edit list, and times shift by the delay of B-frames.
_HYBRID_OPTIONS = {
    "movflags": "+hybrid_fragmented+delay_moov",
    "frag_duration": "400000",
    "movie_timescale": "90000",
}
# An index before the first packets. Then the pictures of a partial file are late by the delay of B-frames.
_LATE_OPTIONS = {"movflags": "+hybrid_fragmented+empty_moov+frag_discont", "use_editlist": "1"}
_FRAGMENTED_OPTIONS = {"movflags": "+frag_keyframe+empty_moov+default_base_moof"}
# Sound may start a little before the pictures; without this option, all times would be shifted.
_UNSHIFTED_OPTIONS = {"avoid_negative_ts": "disabled"}
MAX_INDEXED_TIME_BASE = 240_000
"""MP4 and MOV store the time between two packets in 31 bits: this allows a gap of an hour, which B-frames
double, and is a multiple of the usual frame rates."""
_CLUSTER_OPTIONS = {"cluster_time_limit": "400"} | _UNSHIFTED_OPTIONS


def _kind(muxer: str, endings: str, codec: str, *, flags: str = "", **fields: Any) -> ContainerKind:
    """A row of the table: names are separated by spaces, `flags` are the fields that are true."""
    fields |= dict.fromkeys(flags.split(), True)
    for name in ("video", "hdr", "raw_formats", "audio", "untimed", "subtitles", "data"):
        fields[name] = tuple(fields.get(name, "").split())
    return ContainerKind(muxer, tuple(endings.split()), codec, **fields)


_MP4_FIELDS: dict[str, Any] = {
    "new_audio": "aac", "subtitles": "mov_text", "data": "bin_data", "max_time_base": MAX_INDEXED_TIME_BASE,
    "options": _HYBRID_OPTIONS, "piped_options": _FRAGMENTED_OPTIONS, "late_options": _LATE_OPTIONS,
    "codec_tags": {"hevc": "hvc1"},  # Apple's players refuse hev1
}  # fmt: skip
_RAW_FORMATS = "yuv420p yuv420p10le yuv420p12le"
"""4:2:0, which all programs read."""
# fmt: off
CONTAINER_KINDS: tuple[ContainerKind, ...] = (
    # MP4 has codes for Vorbis and raw PCM, but hardly any player supports them.
    _kind("mp4", ".mp4 .m4v", "libx264", flags="covers chapters piped indexed resumable ranged",
          **_MP4_FIELDS, hdr="hevc av1",
          video="h264 hevc av1 vp9 mpeg4 mpeg2video mpeg1video mjpeg vvc png jpeg2000",
          audio="aac mp3 mp2 ac3 eac3 opus flac alac dts truehd"),
    _kind("mov", ".mov", "libx264", flags="chapters piped indexed resumable ranged bibliographic",
          alpha=("prores_ks", "yuva444p10le"), hdr="hevc", **_MP4_FIELDS,
          audio=f"aac mp3 ac3 eac3 alac {PCM_CODECS}"),
    _kind("matroska", ".mkv", "libx264", flags="attachments covers chapters piped resumable ranged",
          options=_CLUSTER_OPTIONS, alpha=("ffv1", ""), hdr="hevc av1", new_audio="flac",
          audio="aac mp3 mp2 ac3 eac3 opus vorbis flac alac dts truehd mlp "
                f"tta wavpack wmav2 adpcm_ms adpcm_ima_wav {LITTLE_ENDIAN_PCM_CODECS}",
          subtitles="subrip ass webvtt hdmv_pgs_subtitle dvd_subtitle dvb_subtitle"),
    _kind("webm", ".webm", "libvpx-vp9", flags="chapters piped resumable ranged", options=_CLUSTER_OPTIONS,
          video="vp8 vp9 av1", alpha=("libvpx-vp9", "yuva420p"), hdr="av1",
          audio="opus vorbis", new_audio="libopus",
          subtitles="webvtt"),
    # The muxer reduces higher rates, and fills a gap with at most 60,000 empty packets.
    _kind("avi", ".avi", "mpeg4", flags="strict_rate", max_rate=600, max_gap_frames=50_000,
          options=_UNSHIFTED_OPTIONS, audio=f"mp3 mp2 ac3 {LITTLE_ENDIAN_PCM_CODECS}",
          untimed=f"mp3 mp2 ac3 {LITTLE_ENDIAN_PCM_CODECS}", new_audio="libmp3lame"),
    # The muxer refuses two frames in one unit of its time base.
    _kind("mpegts", ".ts .mts .m2ts .m2t", "libx264", flags="piped framed_aac", max_time_base=90_000,
          video="h264 hevc mpeg2video mpeg1video mpeg4", hdr="hevc",
          audio="aac mp3 mp2 ac3 eac3 opus dts", new_audio="aac", subtitles="dvb_subtitle dvb_teletext"),
    _kind("ogv", ".ogv .ogg", "libvpx", flags="piped", video="vp8 theora",
          audio="vorbis opus flac", untimed="flac", new_audio="libopus"),
    _kind("flv", ".flv", "libx264", flags="piped", video="h264 flv1 hevc av1 vp9",
          audio="aac mp3", new_audio="aac"),
    _kind("asf", ".wmv .asf", "wmv2", options=_UNSHIFTED_OPTIONS, audio="wmav1 wmav2 mp3", new_audio="wmav2"),
    _kind("nut", ".nut", "rawvideo", flags="piped", alpha=("rawvideo", ""),
          raw_formats=f"{_RAW_FORMATS} yuva420p yuva420p10le",
          audio=f"aac mp3 mp2 ac3 opus vorbis flac {LITTLE_ENDIAN_PCM_CODECS}", new_audio="pcm_s16le"),
    _kind("yuv4mpegpipe", ".y4m", "rawvideo", flags="strict_rate piped ranged", video="rawvideo",
          raw_formats=_RAW_FORMATS, options={"strict": "-1"}),
    _kind("rawvideo", ".yuv .rgb", "rawvideo", flags="strict_rate piped", video="rawvideo"),
    # WebP gets RGB, because it has only one YUV matrix.
    _kind("webp", ".webp", "libwebp_anim", flags="untagged", video="webp", pix_fmt="bgra",
          options={"loop": "0"}),
    _kind("apng", ".apng", "apng", flags="untagged", video="apng", options={"plays": "0"}),
    # A GIF is stored without loss until its palette is known.
    _kind("matroska", ".gif", "ffv1", flags="ranged", video="ffv1", pix_fmt="bgr0", way="gif",
          alpha=("ffv1", "bgra"), options=_CLUSTER_OPTIONS),
    _kind("image2", ".png", "png", flags="resumable untagged", video="png", way="picture"),
    _kind("image2", ".jpg .jpeg", "mjpeg", flags="resumable", video="mjpeg", pix_fmt="yuv444p",
          way="picture"),
    _kind("image2", ".tif .tiff", "tiff", flags="resumable untagged", video="tiff", way="picture"),
    _kind("image2", ".bmp", "bmp", flags="resumable untagged", video="bmp", way="picture"),
)
# fmt: on
RESUMABLE_ENDINGS = tuple(
    kind.endings[0] for kind in CONTAINER_KINDS if kind.resumable and kind.way == "film"
)
"""The extensions of films that `--resume` can continue."""
STILL_WEBP = _kind(
    "image2", ".webp", "libwebp", flags="untagged", video="webp", pix_fmt="bgra", way="picture"
)


def hdr_endings() -> list[str]:
    """Return the usual extensions of the containers that keep HDR."""
    return [kind.endings[0] for kind in CONTAINER_KINDS if kind.hdr]


def find_kind(target: str, format_name: str | None, still: bool) -> ContainerKind:
    """Return the container for the target's extension, or for `format_name`.

    Args:
        target: a path, or "-" for standard output, which needs a `format_name`.
        still: whether each picture is written to a separate file.

    Raises:
        UsageError: an unknown extension or format; the message suggests similar ones.
    """
    if format_name is not None:
        return _kind_by_format(format_name, target)
    if target == "-":
        raise UsageError("standard output", "needs a format", "add --format nut or y4m")
    ending = PurePath(target).suffix.lower()
    if ending == ".webp" and still:
        return STILL_WEBP
    for kind in CONTAINER_KINDS:
        if ending in kind.endings:
            return kind
    endings = [known for kind in CONTAINER_KINDS for known in kind.endings]
    reason = f"unknown extension {ending!r}" if ending else "its name has no extension"
    raise UsageError(target, reason, _suggestion(ending, endings, ".mp4"))


def _kind_by_format(format_name: str, target: str) -> ContainerKind:
    muxer = PIPE_FORMATS.get(format_name, format_name)
    for kind in CONTAINER_KINDS:
        if kind.muxer == muxer and kind.way == "film":
            if target == "-" and not kind.piped:
                raise UsageError("--format", f"{format_name} cannot be written to a pipe", "use nut or mkv")
            return kind
    known = [kind.muxer for kind in CONTAINER_KINDS if kind.way == "film"] + list(PIPE_FORMATS)
    raise UsageError("--format", f"unknown format {format_name!r}", _suggestion(format_name, known, "nut"))


def _suggestion(name: str, known: list[str], usual: str) -> str:
    near = difflib.get_close_matches(name, known, 3, 0.5)
    return "did you mean " + " or ".join(near) + "?" if near else f"use {usual}, or one of {', '.join(known)}"
