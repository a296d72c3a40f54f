"""Finds out what kind of target a word on the command line means."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from vidstyle.errors import UsageError
from vidstyle.live.options import TargetContext
from vidstyle.live.sinks import ConstantRateTarget, FileTarget, NullTarget, StreamSink
from vidstyle.live.target import LiveFrame, Target
from vidstyle.media.read.open import is_url, public_name
from vidstyle.media.write import stream as live_addresses
from vidstyle.media.write import virtual_camera
from vidstyle.media.write.atomic import is_plain_file
from vidstyle.media.write.containers import kind_of
from vidstyle.media.write.images import is_pattern
from vidstyle.media.write.stream import Stream, StreamOptions
from vidstyle.media.write.writer import WriteOptions

if TYPE_CHECKING:
    import av


@dataclass(frozen=True)
class TargetOptions:
    """How to write.

    Attributes:
        format: of standard output: "y4m", "nut" or "raw".
        pix_fmt: of a virtual camera or raw pictures.
        codec, bitrate: of a network stream, in bits a second.
        file: how files are written.
        port: of the page; 0 is a free one.
    """

    format: str | None = None
    pix_fmt: str | None = None
    codec: str | None = None
    bitrate: int | None = None
    file: WriteOptions = field(default_factory=WriteOptions)
    port: int = 0

    def stream(self, rate: Fraction, sound: bool) -> StreamOptions:
        """The same for a stream of this rate, with or without sound."""
        return StreamOptions(rate, self.format, self.pix_fmt, self.codec, self.bitrate, sound)


def target_maker(text: str, options: TargetOptions) -> Callable[[TargetContext], Target]:
    """What makes the target that a word means, as soon as the size of the pictures is known.

    Args:
        text: "page", "null", "-" for standard output, "/dev/videoN", a URL, a playlist.m3u8, or a file.

    Raises:
        UsageError: it means nothing, or lacks an option.
        DeviceError: there is no such virtual camera.
    """
    if text == "null":
        return lambda setting: NullTarget(setting.meter)
    if text == "page":
        return _page_maker(options.port)
    if text == "-":
        live_addresses.check_pipe(options.stream(Fraction(1), sound=False))
        return _stream_maker("standard output", options, live_addresses.open_pipe, reconnects=False)
    if text.startswith("/dev/video"):
        virtual_camera.check_virtual_camera(text)
        return _stream_maker(text, options, partial(virtual_camera.open_virtual_camera, text))
    if is_url(text) or text.endswith(".m3u8"):
        live_addresses.check_url(text)
        name = public_name(text) if is_url(text) else text
        return _stream_maker(name, options, partial(live_addresses.open_stream, text))
    return _file_maker(text, options)


def _stream_maker(
    name: str,
    options: TargetOptions,
    open_stream: Callable[[StreamOptions, av.VideoFrame], Stream],
    reconnects: bool = True,
) -> Callable[[TargetContext], Target]:
    def make(setting: TargetContext) -> Target:
        def open_sink(first: LiveFrame) -> StreamSink:
            return StreamSink(open_stream(options.stream(setting.rate, setting.sound), first.video))

        outlet = ConstantRateTarget(name, open_sink, setting.meter, setting.rate, reconnects)
        outlet.start(setting.first)
        return outlet

    return make


def _file_maker(text: str, options: TargetOptions) -> Callable[[TargetContext], Target]:
    kind_of(text, options.file.format, is_pattern(text))
    if os.path.lexists(text) and is_plain_file(Path(text)) and not options.file.overwrite:
        raise UsageError(text, "exists already", "add -y to overwrite it, or choose another name")

    def make(setting: TargetContext) -> Target:
        written = replace(options.file, new_sound=setting.sound)
        outlet = FileTarget(text, setting.meter, setting.rate, written)
        outlet.start(setting.first)
        return outlet

    return make


def _page_maker(port: int) -> Callable[[TargetContext], Target]:
    try:
        from vidstyle.live.page import PageTarget
    except ImportError as error:
        raise UsageError("page", f"cannot be shown: {error}", "give another target with --to") from error

    return lambda setting: PageTarget(setting.controls, port, setting.meter)
