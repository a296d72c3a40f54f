"""Opens a target by its name on the command line."""

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
from vidstyle.media.write.atomic import is_regular_file
from vidstyle.media.write.containers import kind_of
from vidstyle.media.write.images import is_pattern
from vidstyle.media.write.stream import Stream, StreamOptions
from vidstyle.media.write.writer import WriteOptions

if TYPE_CHECKING:
    import av


TargetMaker = Callable[[TargetContext], Target]


@dataclass(frozen=True)
class TargetOptions:
    """Options of targets.

    Attributes:
        format: of standard output: "y4m", "nut" or "raw".
        pix_fmt: of a virtual camera or raw pictures.
        codec, bitrate: of a network stream, in bits a second.
        file: options of files.
        port: of the page; 0 chooses a free one.
    """

    format: str | None = None
    pix_fmt: str | None = None
    codec: str | None = None
    bitrate: int | None = None
    file: WriteOptions = field(default_factory=WriteOptions)
    port: int = 0

    def stream(self, rate: Fraction, sound: bool) -> StreamOptions:
        """The options of a stream at this rate, with or without sound."""
        return StreamOptions(rate, self.format, self.pix_fmt, self.codec, self.bitrate, sound)


def target_maker(text: str, options: TargetOptions) -> TargetMaker:
    """A function that opens the target of this name once the first frame is known.

    Args:
        text: "page", "null", "-" for standard output, "/dev/videoN", a URL, a playlist.m3u8, or a file.

    Raises:
        UsageError: no such kind of target, or a required option is missing.
        DeviceError: there is no such virtual camera.
    """
    if text == "null":
        return lambda context: NullTarget(context.meter)
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
) -> TargetMaker:
    def make(context: TargetContext) -> Target:
        def open_sink(first: LiveFrame) -> StreamSink:
            return StreamSink(open_stream(options.stream(context.rate, context.sound), first.video))

        target = ConstantRateTarget(name, open_sink, context.meter, context.rate, reconnects, context.clock)
        target.start(context.first)
        return target

    return make


def _file_maker(text: str, options: TargetOptions) -> TargetMaker:
    kind_of(text, options.file.format, is_pattern(text))
    if os.path.lexists(text) and is_regular_file(Path(text)) and not options.file.overwrite:
        raise UsageError(text, "exists already", "add -y to overwrite it, or choose another name")

    def make(context: TargetContext) -> Target:
        file_options = replace(options.file, new_sound=context.sound)
        target = FileTarget(text, context.meter, context.rate, file_options, context.clock)
        target.start(context.first)
        return target

    return make


def _page_maker(port: int) -> TargetMaker:
    try:
        from vidstyle.live.page import PageTarget
    except ImportError as error:
        raise UsageError("page", f"cannot be shown: {error}", "give another target with --to") from error

    return lambda context: PageTarget(context.controls, port, context.meter)
