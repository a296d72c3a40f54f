"""Opens media safely: only the file that was named, only formats that read no other file."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any, BinaryIO

import av
from av.codec.hwaccel import HWAccel

from vidstyle.errors import InputError, UsageError, error_reason, log
from vidstyle.media.read.headers import HEADER_BYTES, has_no_index, is_jpeg, is_named_as_picture, picture_size
from vidstyle.media.read.mp4_tables import CorrectedFile, cut_counts
from vidstyle.media.read.transport_stream import FilePart

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
"""Allowed only so that sound and subtitles are told from rubbish."""
NETWORK_FORMATS = "rtsp,rtp,sdp,mpjpeg,mpegtsraw"
FORMATS = f"{FILM_FORMATS},{PICTURE_FORMATS},{OTHER_FORMATS}"
"""The demuxers that read one file and open no other. Playlists (hls, dash, concat) and file name patterns
(image2) are not among them, and stay out: FFmpeg's protocol_whitelist does not stop those."""

PLAYLISTS = (b"ffconcat", b"#EXTM3U", b"<MPD", b"[playlist]")
MAX_PIXELS = 64 * 2**20
"""Default limit on the pixels of a picture: 8192 x 8192."""
NETWORK_SECONDS = 10
URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")
LENIENT: dict[str, Any] = {} if int(av.__version__.split(".")[0]) >= 19 else {"metadata_errors": "replace"}
"""Tags that are not UTF-8 do not keep a film shut. From version 19 on PyAV never lets them."""


def open_media(
    source: str | os.PathLike[str] | BinaryIO | FilePart,
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
        max_pixels: larger pictures are refused before they are decoded.
        hwaccel: the kind of device to decode on; if it cannot, that is said and the CPU does it.
        format: the demuxer's name, where the content does not tell (raw video).
        options: for the demuxer.
        seconds: how long a connection may say nothing; None: NETWORK_SECONDS.

    Raises:
        InputError: nothing there, not readable, not a video; the reason is named.
        UsageError: a URL, and they are not allowed.
    """
    if isinstance(source, str | os.PathLike) and str(source) != "-" and not is_url(source):
        head = _checked_head(Path(source))
        check_size(source, picture_size(head), max_pixels)
        # FFmpeg would go by a picture's name, and take it for a sequence.
        if is_jpeg(head) and is_named_as_picture(Path(source)):
            format = format or "jpeg_pipe"
    if format is not None and format not in av.formats_available:
        raise UsageError("--input-format", f"{format!r} cannot be read here", "use raw or y4m")
    options = {"max_pixels": str(max_pixels)} | (options or {})
    options["format_whitelist"] = f"{FORMATS},{NETWORK_FORMATS}" if allow_url else FORMATS
    target = _target(source, allow_url)
    try:
        waits = NETWORK_SECONDS if seconds is None else seconds
        container = _open(target, format, options, hwaccel, waits)
    except (av.FFmpegError, OSError, ValueError) as error:
        raise _input_error(source, error) from error
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
    return bool(URL.match(text)) and not os.path.lexists(text)


def public_name(url: str) -> str:
    """The URL without credentials: passwords, queries, and the key of an RTMP stream.

    >>> public_name("rtsp://me:secret@camera/1?token=5"), public_name("rtmp://host:1935/live/key-123")
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


def _target(source: Any, allow_url: bool) -> Any:
    """What FFmpeg is given: it would take many a file name for a URL or for a pattern of names."""
    if hasattr(source, "read"):
        return source
    if str(source) == "-":
        return sys.stdin.buffer
    if is_url(source):
        if allow_url:
            return str(source)
        raise UsageError(source, "is a URL", "allow it with --allow-url")
    path = Path(source)
    if corrections := cut_counts(path):
        return CorrectedFile(path, corrections)
    # As a file object, for FFmpeg sees a pattern in a name with "%".
    return _Nameless(path) if "%" in str(path) else "file:" + os.path.abspath(path)


class _Nameless:
    """A file that does not tell FFmpeg its name; closed when the container lets go of it."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("rb")
        self.read, self.seek, self.tell = self._file.read, self._file.seek, self._file.tell
        self.seekable = self._file.seekable

    def __del__(self) -> None:
        self._file.close()


def _checked_head(path: Path) -> bytes:
    """The first bytes of a file; one plain reason for what FFmpeg would say in many ways."""
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
        any(start.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(mark) for mark in PLAYLISTS)
        or b"<MPD" in start[:4096]
    ):
        raise InputError(path, "playlist formats are not accepted", "give the film itself")
    return start


def _open(
    target: Any, format: str | None, options: dict[str, str], hwaccel: str | None, seconds: float
) -> av.container.InputContainer:
    timeout = seconds if isinstance(target, str) and URL.match(target) else None
    if hwaccel:
        try:
            accelerator = HWAccel(hwaccel, allow_software_fallback=True)
            container = av.open(target, "r", format, options, timeout=timeout, hwaccel=accelerator, **LENIENT)
            if not any(stream.codec_context.is_hwaccel for stream in container.streams.video):
                log.warning("%s cannot decode this codec: the CPU does it", hwaccel)
            return container
        except (av.FFmpegError, ValueError, RuntimeError, NotImplementedError, OSError) as error:
            log.warning("%s cannot decode here (%s): the CPU does it", hwaccel, error_reason(error))
            if hasattr(target, "seek"):
                target.seek(0)
    return av.open(target, "r", format, options, timeout=timeout, **LENIENT)


def check_size(source: Any, size: tuple[int, int] | None, max_pixels: int) -> None:
    """Raise InputError if a picture of this width and height is larger than allowed; None: not known."""
    if size is not None and size[0] * size[1] > max_pixels:
        limit = f"the limit of {max_pixels / 2**20:g} MP"
        raise InputError(source, f"{size[0]}x{size[1]} is larger than {limit}")


def _input_error(source: Any, error: Exception) -> InputError:
    name = "standard input" if hasattr(source, "read") or str(source) == "-" else source
    if is_url(source):
        return InputError(name, f"cannot be opened: {error_reason(error)}")
    if isinstance(error, av.InvalidDataError | ValueError | EOFError):
        if isinstance(name, str | os.PathLike) and Path(name).is_file() and has_no_index(Path(name)):
            return InputError(name, "the recording was not finished (no index)")
        remedy = "raw video needs --input-size" if name == "standard input" else ""
        return InputError(name, "not a readable video", remedy)
    return InputError(name, f"not a readable video: {error_reason(error)}")
