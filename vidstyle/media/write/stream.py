"""Live output without delay: pipes, network streams, HLS and virtual cameras (v4l2loopback)."""

from __future__ import annotations

import math
import os
from collections import deque
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from av.bitstream import BitStreamFilterContext

from vidstyle.core.machine.cores import imposed_threads
from vidstyle.errors import DeviceError, OutputError, UsageError, VidstyleError, error_reason, log
from vidstyle.media.audio import AudioChunk, AudioEncoder
from vidstyle.media.codecs import find_encoder, open_encoder
from vidstyle.media.color_tags import ColorTags
from vidstyle.media.frame import frame_from_picture, picture_from_frame
from vidstyle.media.read.open import is_url, redact_url
from vidstyle.media.v4l2 import query_video_device
from vidstyle.media.write.base import StandardOutput

RAW_FORMATS = {"y4m": "yuv4mpegpipe", "nut": "nut", "raw": "rawvideo"}
"""Formats for pipes: names for `--format` and FFmpeg's muxers."""
JOINABLE_MUXERS = ("mpegts", "rtp_mpegts")
"""Muxers of streams that viewers can join at any time."""
MAX_SOUND_WAIT_SECONDS = 0.2
"""Maximum time that pictures wait for sound, which may have stopped."""
REPEAT_HEADERS_FILTER = "dump_extra=freq=all"
ZERO_LATENCY = {
    "libx264": {"preset": "veryfast", "tune": "zerolatency"},
    "libx265": {"preset": "superfast", "tune": "zerolatency", "x265-params": "log-level=error"},
}
"""Encoder options for output without delay and without log messages."""
KEY_FRAME_SECONDS = 1
"""Interval of key frames: the time that a new viewer waits for a picture."""
HLS_OPTIONS = {"hls_time": "2", "hls_list_size": "6", "hls_flags": "delete_segments+append_list"}


@dataclass(frozen=True)
class StreamOptions:
    """How to write a stream.

    Attributes:
        rate: frames per second, the unit of frame numbers.
        format: format of a pipe: "y4m", "nut" or "raw"; None: the first, which all players support.
        pix_fmt: pixel format of a virtual camera or a raw pipe; None: the default.
        codec: encoder of a network stream; None: H.264.
        bitrate: bit rate of a network stream in bits per second; None: constant quality.
        sound: whether a network stream has audio.
    """

    rate: Fraction = Fraction(30)
    format: str | None = None
    pix_fmt: str | None = None
    codec: str | None = None
    bitrate: int | None = None
    sound: bool = False


class Stream:
    """One open stream; frames are encoded and written without delay.

    Attributes:
        needs_every: whether frames have no timestamps, so that no frame may be dropped.
    """

    def __init__(
        self, name: str, target: Any, muxer: str, options: StreamOptions, first: av.VideoFrame, pix_fmt: str
    ) -> None:
        """Open the stream and write its header.

        Args:
            name: name for messages.
            target: a URL or path for FFmpeg, or an open file.
            first: the first frame, for its size and tags.

        Raises:
            OutputError: the stream cannot be opened.
        """
        self.name, self._pix_fmt = name, pix_fmt
        self._first: int | None = None
        self.needs_every = muxer in ("yuv4mpegpipe", "rawvideo")
        any_size = muxer in RAW_FORMATS.values() and pix_fmt == "yuv420p"
        self._size = (first.width, first.height) if any_size else _even_size(first)
        self._playlist = Path(target) if muxer == "hls" and not is_url(target) else None
        self._joined = muxer in JOINABLE_MUXERS
        self._ordered = muxer == "rtp_mpegts"
        self._sound: deque[av.Packet] = deque()
        self._time = 0.0
        raw = muxer in (*RAW_FORMATS.values(), "v4l2")
        try:
            settings = {
                "flush_packets": "1",
                "max_interleave_delta": str(round(MAX_SOUND_WAIT_SECONDS * 1e6)),
            }
            settings |= HLS_OPTIONS if muxer == "hls" else {}
            self._container = av.open(target, "w", muxer, container_options=settings)
            self._stream = self._add_stream("rawvideo" if raw else options.codec or "libx264", options, first)
            self._audio = AudioEncoder(self._container, "aac") if options.sound and not raw else None
            self._container.start_encoding()
            # A viewer who joins needs the parameter sets, or the first frames seem damaged.
            self._repeat = (
                BitStreamFilterContext(REPEAT_HEADERS_FILTER, self._stream) if self._joined else None
            )
        except (av.FFmpegError, OSError, ValueError) as error:
            raise self._failure("cannot be opened", error) from error

    def _add_stream(self, encoder: str, options: StreamOptions, first: av.VideoFrame) -> av.VideoStream:
        settings = {"chroma_sample_location": "left"} if self._pix_fmt == "yuv420p" else {}
        settings |= ZERO_LATENCY.get(encoder, {})
        stream = self._container.add_stream(encoder, rate=options.rate, options=settings)
        assert isinstance(stream, av.VideoStream)
        context = stream.codec_context
        context.width, context.height = self._size
        context.pix_fmt = self._pix_fmt
        context.time_base = 1 / options.rate
        context.thread_count = imposed_threads()
        context.gop_size = max(1, round(options.rate * KEY_FRAME_SECONDS))
        context.max_b_frames = 0
        if self._joined:
            context.flags |= av.codec.context.Flags.global_header
        if options.bitrate:
            context.bit_rate = options.bitrate
        ColorTags.of(first).put_on(context)
        open_encoder(context)
        return stream

    def write(self, frame: av.VideoFrame, number: int) -> float:
        """Write a frame with an increasing number; return its presentation time in seconds.

        Raises:
            OutputError: the connection is lost.
        """
        width, height = self._size
        own = frame.reformat(width, height, self._pix_fmt)
        if own is frame:  # shared with other targets, so its number must not be set
            own = frame_from_picture(picture_from_frame(frame))
        ColorTags.of(frame).put_on(own)
        self._first = number if self._first is None else self._first
        own.pts, own.time_base, own.pict_type = number - self._first, self._stream.codec_context.time_base, 0
        try:
            self._mux(own)
        except (av.FFmpegError, OSError) as error:
            raise self._failure("was lost", error) from error
        return float(own.pts * self._stream.codec_context.time_base)

    def _mux(self, frame: av.VideoFrame | None) -> None:
        """Encode and write a frame, or the last frames, after the sound that is due before them."""
        for packet in self._stream.encode(frame):
            self._time = _time(packet)
            self._mux_sound(self._time)
            self._container.mux(packet if self._repeat is None else self._repeat.filter(packet))

    def _mux_sound(self, end: float) -> None:
        """Write the sound up to a time, never ahead of the pictures, which RTP would refuse then.

        RTP also refuses sound that arrives after its pictures.
        """
        while self._sound and (time := _time(self._sound[0])) <= end:
            packet = self._sound.popleft()
            if not self._ordered or time >= self._time - MAX_SOUND_WAIT_SECONDS:
                self._container.mux(packet)
            else:
                log.warning("%s: sound that arrives too late is dropped", self.name, extra={"once": True})

    def push_audio(self, chunk: AudioChunk, seconds: float) -> None:
        """Write audio that starts `seconds` after the first frame, if the stream has audio.

        Raises:
            OutputError: the stream is lost.
        """
        if self._audio is None:
            return
        try:
            self._sound += self._audio.packets(chunk.samples, seconds)
            self._mux_sound(self._time)
        except (av.FFmpegError, OSError) as error:
            raise self._failure("was lost", error) from error

    def close(self) -> None:
        """Flush and close the stream.

        Raises:
            OutputError: the end could not be written.
        """
        try:
            self._mux(None)
            if self._audio is not None:
                self._sound += self._audio.flush()
                self._mux_sound(math.inf)
            self._container.close()
        except (av.FFmpegError, OSError) as error:
            raise self._failure("was lost", error) from error
        # The muxer does not report that it could not write the playlist.
        if self._playlist is not None and not self._playlist.exists():
            raise OutputError(self.name, "was lost: the playlist does not exist")

    def _failure(self, words: str, error: Exception) -> VidstyleError:
        if isinstance(error, BrokenPipeError) and self.name == "standard output":
            return OutputError(self.name, "was closed by its reader")
        if isinstance(error, av.ProtocolNotFoundError):
            return UsageError(
                self.name, "FFmpeg in this build does not support this protocol", "use RTMP or RTSP"
            )
        return OutputError(self.name, f"{words}: {error_reason(error)}")


def _time(packet: av.Packet) -> float:
    """Return the decoding time of an encoded packet, in seconds."""
    assert packet.dts is not None
    return float(packet.dts * packet.time_base)


def _even_size(frame: av.VideoFrame) -> tuple[int, int]:
    """Return the size without an odd last column and row, which subsampled chroma does not allow."""
    return max(2, frame.width // 2 * 2), max(2, frame.height // 2 * 2)


DEFAULT_FORMAT = "y4m"
STREAM_FORMATS = {
    **{"rtmp": "flv", "rtmps": "flv", "srt": "mpegts", "udp": "mpegts", "tcp": "mpegts"},
    **{"rtp": "rtp_mpegts", "rtsp": "rtsp", "http": "mpegts", "https": "mpegts"},
}
"""Muxer for each URL scheme."""


def open_pipe(options: StreamOptions, first: av.VideoFrame) -> Stream:
    """Open standard output; raise UsageError like `check_pipe`."""
    muxer = check_pipe(options)
    pix_fmt = options.pix_fmt if muxer != "yuv4mpegpipe" and options.pix_fmt else "yuv420p"
    return Stream("standard output", StandardOutput(), muxer, options, first, pix_fmt)


def check_pipe(options: StreamOptions) -> str:
    """Return the muxer for standard output.

    Raises:
        UsageError: the format is not supported for live pipes.
    """
    name = options.format or DEFAULT_FORMAT
    muxer = RAW_FORMATS.get(name, name)
    if muxer not in RAW_FORMATS.values():
        raise UsageError(
            "--format", f"{name} is not supported for live pipes", f"use {', '.join(RAW_FORMATS)}"
        )
    return muxer


def open_stream(url: str, options: StreamOptions, first: av.VideoFrame) -> Stream:
    """Open a network stream, or an HLS playlist with its segments next to it.

    Raises:
        UsageError: see `check_url`; or there is no such encoder.
        OutputError: the connection is refused.
    """
    muxer = check_url(url)
    if options.codec:
        options = replace(options, codec=find_encoder(options.codec)[0])
    return Stream(redact_url(url), url, muxer, options, first, "yuv420p")


def check_url(url: str) -> str:
    """Return the muxer for a URL or a playlist.

    Raises:
        UsageError: the scheme is not supported.
    """
    scheme = url.partition(":")[0].lower()
    muxer = "hls" if url.endswith(".m3u8") else STREAM_FORMATS.get(scheme)
    if muxer is None:
        remedy = f"use {', '.join(STREAM_FORMATS)}"
        raise UsageError(redact_url(url), "is not a supported kind of stream", remedy)
    return muxer


CAMERA_FORMATS = {"yuyv422": "yuyv422", "nv12": "nv12", "yuv420p": "yuv420p", "i420": "yuv420p"}
"""Pixel formats that readers of virtual cameras support; browsers and video calls need the first."""


def open_virtual_camera(path: str, options: StreamOptions, first: av.VideoFrame) -> Stream:
    """Open a virtual camera for writing.

    Raises:
        UsageError: virtual cameras do not support the pixel format.
        DeviceError: the device does not exist, or is not a virtual camera.
    """
    pix_fmt = CAMERA_FORMATS.get(options.pix_fmt or "yuyv422")
    if pix_fmt is None:
        known = ", ".join(CAMERA_FORMATS)
        raise UsageError("--pix-fmt", f"virtual cameras do not support {options.pix_fmt}", f"use {known}")
    check_virtual_camera(path)
    try:
        return Stream(path, path, "v4l2", options, first, pix_fmt)
    except OutputError as error:
        raise DeviceError(path, error.reason) from error


def check_virtual_camera(path: str) -> None:
    """Raise DeviceError if the device is not writable; the message shows how to create a virtual camera."""
    device = query_video_device(path)
    if device is not None and device.can_output:
        return
    number = "".join(character for character in path if character.isdigit()) or "9"
    make = f"sudo modprobe v4l2loopback video_nr={number} card_label=vidstyle exclusive_caps=1"
    if device is not None:
        raise DeviceError(
            path, f"is the camera {device.name}, which accepts no pictures", f"create another device: {make}"
        )
    if Path(path).exists() and not os.access(path, os.R_OK | os.W_OK):
        raise DeviceError(path, "no permission to open it", "join the group that owns it, usually video")
    if Path(path).exists():
        raise DeviceError(path, "is not a virtual camera")
    raise DeviceError(path, "there is no such virtual camera", f"create one: {make}")
