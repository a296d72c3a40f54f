"""Opens media safely: only the named file, and only formats that open no other file."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any, BinaryIO

import av
from av.codec.hwaccel import HWAccel

from vidstyle.errors import InputError, UsageError, error_reason, is_memory_short, log
from vidstyle.media.read.file_structure.headers import (
    HEADER_BYTES,
    has_no_index,
    is_jpeg,
    is_named_as_picture,
    picture_size,
)
from vidstyle.media.read.file_structure.mp4_tables import CorrectedFile, find_corrections
from vidstyle.media.read.file_structure.transport_stream import FilePart, RecordingStream, ReplayedStream

FILM_FORMATS = (
    "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,flv,live_flv,mpegts,mpeg,mpegvideo,m4v,h261,h263,h264,hevc,vvc,"
    "av1,obu,ivf,ogg,asf,gif,apng,yuv4mpegpipe,nut,mjpeg,mjpeg_2000,smjpeg,dv,mxf,gxf,rm,nsv,wtv,dnxhd,vc1,"
    "vc1test,cavsvideo,dirac,evc,rawvideo,avs2,avs3,bink,smk,flic,roq,ea,mtv,nuv,pva,film_cpk"
)
PICTURE_FORMATS = (
    "png_pipe,jpeg_pipe,jpegls_pipe,jpegxl_pipe,jpegxl_anim,webp_pipe,tiff_pipe,bmp_pipe,ppm_pipe,pgm_pipe,"
    "pbm_pipe,pam_pipe,pgmyuv_pipe,qoi_pipe,j2k_pipe,dpx_pipe,exr_pipe,sgi_pipe,sunrast_pipe,psd_pipe,pcx_pipe"
)
OTHER_FORMATS = "mp3,wav,aac,ac3,eac3,flac,opus,aiff,amr,caf,w64,dts,truehd,srt,ass,webvtt"
"""Allowed only to distinguish sound and subtitles from random data in error messages."""
NETWORK_FORMATS = "rtsp,rtp,sdp,mpjpeg,mpegtsraw"
FILE_FORMATS = f"{FILM_FORMATS},{PICTURE_FORMATS},{OTHER_FORMATS}"
"""The demuxers that open no other file. Playlists (hls, dash, concat) and file name patterns (image2) must
stay excluded, as FFmpeg's protocol_whitelist does not stop them."""

PLAYLIST_STARTS = (b"ffconcat", b"#EXTM3U", b"<MPD", b"[playlist]")
MAX_PIXELS = 64 * 2**20
"""Default maximum number of pixels of a picture: 8192 x 8192."""
NETWORK_TIMEOUT_SECONDS = 10
URL_PATTERN = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")
LENIENT_OPTIONS: dict[str, Any] = (
    {} if int(av.__version__.split(".")[0]) >= 19 else {"metadata_errors": "replace"}
)
"""Options to open films whose tags are not UTF-8; PyAV 19 and newer need none."""


def open_media(
    source: str | os.PathLike[str] | BinaryIO | FilePart | RecordingStream | ReplayedStream,
    *,
    allow_url: bool = False,
    max_pixels: int = MAX_PIXELS,
    hwaccel: str | None = None,
    format: str | None = None,
    options: dict[str, str] | None = None,
    seconds: float | None = None,
) -> av.container.InputContainer:
    """Open a film, a picture or a stream for reading.

    Args:
        source: a path, an open binary file, "-" for standard input, or, if allowed, a URL.
        max_pixels: larger pictures are rejected before they are decoded.
        hwaccel: the device type to decode on; if it is not available, a notice is logged and the CPU decodes.
        format: the demuxer's name if it cannot be detected (raw video).
        options: options for the demuxer.
        seconds: timeout of a connection without data; None: NETWORK_TIMEOUT_SECONDS.

    Raises:
        InputError: the source is missing, not readable or not a video.
        UsageError: the source is a URL, and URLs are not allowed.
    """
    if isinstance(source, str | os.PathLike) and str(source) != "-" and not is_url(source):
        head = _read_head(Path(source))
        check_size(source, picture_size(head), max_pixels)
        # By the name of a picture, FFmpeg would open it as a sequence.
        if is_jpeg(head) and is_named_as_picture(Path(source)):
            format = format or "jpeg_pipe"
    if format is not None and format not in av.formats_available:
        raise UsageError("--input-format", f"{format!r} is not supported by this build", "use raw or y4m")
    options = {"max_pixels": str(max_pixels)} | (options or {})
    options["format_whitelist"] = f"{FILE_FORMATS},{NETWORK_FORMATS}" if allow_url else FILE_FORMATS
    target = _ffmpeg_input(source, allow_url)
    try:
        waits = NETWORK_TIMEOUT_SECONDS if seconds is None else seconds
        container = _open(target, format, options, hwaccel, waits)
    except InputError:
        raise
    except (av.FFmpegError, OSError, ValueError) as error:
        if not isinstance(error, MemoryError):
            raise _input_error(source, error) from error
        if is_memory_short():
            raise
        # A damaged count of entries or bytes, which exceeds any memory.
        raise InputError(_source_name(source), "not a readable video: its header is damaged") from None
    try:
        for stream in container.streams.video:
            if stream.codec_context is not None:
                check_size(source, (stream.width, stream.height), max_pixels)
    except InputError:
        container.close()
        raise
    return container


def is_url(source: object) -> bool:
    """Whether the text is a URL: it has a scheme, and no file has this name."""
    text = str(source)
    return bool(URL_PATTERN.match(text)) and not os.path.lexists(text)


def redact_url(url: str) -> str:
    """Remove credentials from a URL: passwords, queries, and the key of an RTMP stream.

    >>> redact_url("rtsp://me:secret@camera/1?token=5"), redact_url("rtmp://host:1935/live/key-123")
    ('rtsp://camera/1', 'rtmp://host:1935/live/...')
    """
    scheme, colon, rest = url.partition("?")[0].partition("://")
    if not colon:
        return url
    host, slash, path = rest.partition("/")
    application, key, _ = path.partition("/")
    if scheme.lower().startswith("rtmp") and key:
        path = f"{application}/..."
    return f"{scheme}://{host.rpartition('@')[2]}{slash}{path}"


def _ffmpeg_input(source: Any, allow_url: bool) -> Any:
    """Return the input for FFmpeg, which would open some file names as URLs or as patterns of names."""
    if hasattr(source, "read"):
        return source
    if str(source) == "-":
        return sys.stdin.buffer
    if is_url(source):
        if allow_url:
            return str(source)
        raise UsageError(source, "is a URL", "allow it with --allow-url")
    path = Path(source)
    if corrected := find_corrections(path):
        return CorrectedFile(path, corrected)
    # As a file object, because FFmpeg finds a pattern in a name with "%".
    return _UnnamedFile(path) if "%" in str(path) else "file:" + os.path.abspath(path)


class _UnnamedFile:
    """A file without a name for FFmpeg; closed when the container releases it."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("rb")
        self.read, self.seek, self.tell = self._file.read, self._file.seek, self._file.tell
        self.seekable = self._file.seekable

    def __del__(self) -> None:
        self._file.close()


def _read_head(path: Path) -> bytes:
    """Read the first bytes of a file; raise one clear error for each failure."""
    try:
        with path.open("rb") as file:
            start = file.read(HEADER_BYTES)
    except IsADirectoryError:
        remedy = f"name a file in it, or a pattern such as '{path / '*.png'}'"
        raise InputError(path, "is a folder", remedy) from None
    except FileNotFoundError:
        raise InputError(path, "no such file") from None
    except PermissionError:
        raise InputError(path, "permission denied") from None
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be opened: {error_reason(error)}") from None
    if not start and path.is_file():
        raise InputError(path, "not a readable video: the file is empty")
    if (
        any(start.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(mark) for mark in PLAYLIST_STARTS)
        or b"<MPD" in start[:4096]
    ):
        raise InputError(path, "playlist formats are not accepted", "use the film itself")
    return start


def _open(
    target: Any, format: str | None, options: dict[str, str], hwaccel: str | None, seconds: float
) -> av.container.InputContainer:
    timeout = seconds if isinstance(target, str) and URL_PATTERN.match(target) else None
    if hwaccel:
        try:
            accelerator = HWAccel(hwaccel, allow_software_fallback=True)
            container = av.open(
                target, "r", format, options, timeout=timeout, hwaccel=accelerator, **LENIENT_OPTIONS
            )
            if not any(stream.codec_context.is_hwaccel for stream in container.streams.video):
                log.warning("%s cannot decode this codec; the CPU decodes", hwaccel)
            return container
        except (av.FFmpegError, ValueError, RuntimeError, NotImplementedError, OSError) as error:
            reason = f"{hwaccel} cannot decode here ({error_reason(error)})"
            if hasattr(target, "read") and not (hasattr(target, "seekable") and target.seekable()):
                remedy = "leave out --hwaccel: a stream cannot be read twice"
                raise InputError(_source_name(target), reason, remedy) from error
            log.warning("%s; the CPU decodes", reason)
            if hasattr(target, "seek"):
                target.seek(0)
    return av.open(target, "r", format, options, timeout=timeout, **LENIENT_OPTIONS)


def check_size(source: Any, size: tuple[int, int] | None, max_pixels: int) -> None:
    """Raise InputError if a picture of this width and height is larger than allowed; None: unknown."""
    if size is not None and size[0] * size[1] > max_pixels:
        limit = f"the limit of {max_pixels / 2**20:g} MP"
        raise InputError(source, f"{size[0]}x{size[1]} is larger than {limit}")


def _source_name(source: Any) -> Any:
    return "standard input" if hasattr(source, "read") or str(source) == "-" else source


def _input_error(source: Any, error: Exception) -> InputError:
    name = _source_name(source)
    if is_url(source):
        return InputError(name, f"cannot be opened: {error_reason(error)}")
    if isinstance(error, av.InvalidDataError | ValueError | EOFError):
        if isinstance(name, str | os.PathLike) and Path(name).is_file() and has_no_index(Path(name)):
            return InputError(name, "the recording was not finished (no index)")
        remedy = "raw video needs --input-size" if name == "standard input" else ""
        return InputError(name, "not a readable video", remedy)
    return InputError(name, f"not a readable video: {error_reason(error)}")
