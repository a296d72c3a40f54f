"""Where streams go: standard output, addresses on the network and playlists, and what each is given."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from vidstyle.errors import UsageError
from vidstyle.media.codecs import find_encoder
from vidstyle.media.live_output import RAW_FORMATS, Stream, StreamOptions
from vidstyle.media.open import public_name

if TYPE_CHECKING:
    import av

USUAL_FORMAT = "y4m"
STREAM_FORMATS = {
    "rtmp": "flv",
    "rtmps": "flv",
    "srt": "mpegts",
    "udp": "mpegts",
    "tcp": "mpegts",
    "rtp": "rtp_mpegts",
    "rtsp": "rtsp",
    "http": "mpegts",
    "https": "mpegts",
}
"""What a URL of each scheme is given: the muxer."""


def open_pipe(options: StreamOptions, first: av.VideoFrame) -> Stream:
    """Standard output; raises UsageError as `check_pipe` does."""
    muxer = check_pipe(options)
    pix_fmt = options.pix_fmt if muxer != "yuv4mpegpipe" and options.pix_fmt else "yuv420p"
    return Stream("standard output", _StandardOutput(), muxer, options, first, pix_fmt)


def check_pipe(options: StreamOptions) -> str:
    """The muxer for standard output.

    Raises:
        UsageError: a format that is not for live pipes.
    """
    name = options.format or USUAL_FORMAT
    muxer = RAW_FORMATS.get(name, name)
    if muxer not in RAW_FORMATS.values():
        raise UsageError("--format", f"{name} is not for live pipes", f"use {', '.join(RAW_FORMATS)}")
    return muxer


def open_stream(url: str, options: StreamOptions, first: av.VideoFrame) -> Stream:
    """A stream over the network, or an HLS playlist with its pieces beside it.

    Raises:
        UsageError: as `check_url`, or there is no such encoder.
        OutputError: nobody is there.
    """
    muxer = check_url(url)
    if options.codec:
        options = replace(options, codec=find_encoder(options.codec)[0])
    return Stream(public_name(url), url, muxer, options, first, "yuv420p")


def check_url(url: str) -> str:
    """The muxer for a URL or a playlist.

    Raises:
        UsageError: a scheme that we do not write.
    """
    scheme = url.partition(":")[0].lower()
    muxer = "hls" if url.endswith(".m3u8") else STREAM_FORMATS.get(scheme)
    if muxer is None:
        raise UsageError(
            public_name(url), "is no kind of stream that we write", "use " + ", ".join(STREAM_FORMATS)
        )
    return muxer


class _StandardOutput:
    """Standard output without a buffer: a thread that waits in one could not be left behind at the end."""

    name = "standard output"

    def __init__(self) -> None:
        self._descriptor = sys.stdout.fileno()

    def write(self, content: bytes) -> int:
        """Write all of it; waits for the reader."""
        rest = memoryview(content)
        while rest:
            rest = rest[os.write(self._descriptor, rest) :]
        return len(content)
