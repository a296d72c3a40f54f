"""The targets of a session, opened by name, and their group."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path

from vidstyle.core.convert import convert
from vidstyle.core.picture import Picture
from vidstyle.errors import UsageError
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame, Target, TargetContext
from vidstyle.live.target_thread import FINISH_SECONDS, ConstantRateTarget, TargetThread
from vidstyle.media.audio import AudioChunk
from vidstyle.media.color_tags import default_tags
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo
from vidstyle.media.read.open import is_url, redact_url
from vidstyle.media.write import stream
from vidstyle.media.write.atomic import check_folder, is_regular_file
from vidstyle.media.write.containers import find_kind
from vidstyle.media.write.images import is_numbered
from vidstyle.media.write.writer import WriteOptions, open_writer

TIME_BASE_SECONDS = Fraction(1, 90000)
FILE_QUEUE_FRAMES = 8
"""Number of frames that may wait for a slow disk or encoder."""

TargetMaker = Callable[[TargetContext], Target]


@dataclass(frozen=True)
class TargetOptions(stream.StreamOptions):
    """Options of all targets. The session sets rate and sound of streams.

    Attributes:
        file: options of files.
        port, host, browse: of the page, see `PageTarget`.
    """

    file: WriteOptions = WriteOptions()
    port: int = 0
    host: str | None = None
    browse: Callable[[str], None] | None = None


def target_maker(text: str, options: TargetOptions) -> TargetMaker:
    """A function that opens the target of this name once the first frame is known.

    Args:
        text: "page", "null", "-" for standard output, "/dev/videoN", a URL, a playlist.m3u8, or a file.

    Raises:
        UsageError: no such kind of target, or a required option is missing.
        OutputError: its folder is missing or cannot be written to.
        DeviceError: there is no such virtual camera.
    """
    if text == "null":
        return lambda context: NullTarget(context.meter)
    if text == "page":
        return _page_maker(options)
    if text == "-":
        stream.check_pipe(options)
        return _stream_maker("standard output", options, stream.open_pipe, reconnects=False)
    if text.startswith("/dev/video"):
        stream.check_virtual_camera(text)
        return _stream_maker(text, options, partial(stream.open_virtual_camera, text))
    if is_url(text) or text.endswith(".m3u8"):
        stream.check_url(text)
        if not is_url(text):
            check_folder(Path(text))
            _refuse_existing([Path(text), *_pieces(Path(text))], options.file.overwrite)
        name = redact_url(text) if is_url(text) else text
        return _stream_maker(name, options, partial(stream.open_stream, text), reconnects=is_url(text))
    check_folder(Path(text))
    find_kind(text, options.file.format, is_numbered(text))
    if is_regular_file(Path(text)):
        _refuse_existing([Path(text)], options.file.overwrite)
    return lambda context: file_target(text, context, options.file)


def _refuse_existing(paths: Sequence[Path], overwrite: bool) -> None:
    existing = next((path for path in paths if os.path.lexists(path)), None)
    if existing is not None and not overwrite:
        raise UsageError(existing, "already exists", "add -y to overwrite it, or choose another name")


def _pieces(playlist: Path) -> list[Path]:
    """The existing files that have names of the playlist's pieces: live0.ts of live.m3u8."""
    name = re.compile(re.escape(playlist.stem) + r"\d+\.ts")
    return [path for path in playlist.parent.iterdir() if name.fullmatch(path.name)]


def file_target(path: str | Path, context: TargetContext, options: WriteOptions) -> TargetThread:
    """A video file, in which every frame has the time of its capture; raises as `FileSink`."""
    options = replace(options, new_sound=context.sound)
    return TargetThread(
        str(path),
        lambda: FileSink(path, context, options),
        context,
        capacity=FILE_QUEUE_FRAMES,
        finish_seconds=FINISH_SECONDS,
    )


def _stream_maker(
    name: str, options: TargetOptions, open_stream: Callable[..., stream.Stream], reconnects: bool = True
) -> TargetMaker:
    def make(context: TargetContext) -> Target:
        own = replace(options, rate=context.rate, sound=context.sound)
        return ConstantRateTarget(
            name, lambda: StreamSink(open_stream(own, context.first.video)), context, reconnects
        )

    return make


def _page_maker(options: TargetOptions) -> TargetMaker:
    from vidstyle.live.page import PageTarget

    port, host, browse = options.port, options.host, options.browse
    return lambda context: PageTarget(context.controls, port, context.meter, host, browse)


class StreamSink:
    """Writes to an open stream."""

    def __init__(self, opened: stream.Stream) -> None:
        self._stream = opened
        self._offset = 0.0
        self._last: LiveFrame | None = None
        self.needs_every = opened.needs_every

    def write(self, frame: LiveFrame, number: int) -> None:
        """See Sink."""
        time = self._stream.write(frame.video, number)
        if frame is not self._last:  # time and sound advance while a frame is repeated
            self._last, self._offset = frame, time - frame.captured

    def push_audio(self, chunk: AudioChunk) -> None:
        """See Sink; sound is aligned with the frame captured at the same time."""
        self._stream.push_audio(chunk, chunk.time + self._offset)

    def close(self) -> None:
        """See Sink."""
        self._stream.close()


class FileSink:
    """Writes a file of any container that `vidstyle render` writes."""

    needs_every = False

    def __init__(
        self, target: str | Path, context: TargetContext, options: WriteOptions, still: bool = False
    ) -> None:
        """Raises VidstyleError if the file exists, or cannot be written."""
        (height, width), encoding = context.first.picture.shape, context.first.picture.encoding
        tags = default_tags(encoding, height)
        info = VideoInfo(width, height, encoding, tags, TIME_BASE_SECONDS, context.rate, still=still)
        self._writer = open_writer(target, info, options)
        self._start: float | None = None
        self._duration = round(1 / (context.rate * TIME_BASE_SECONDS))
        self._convert(context.first)  # compile and allocate now, so that frames do not wait

    def write(self, frame: LiveFrame, number: int) -> None:
        """See Sink; use the capture time instead of the number."""
        self._start = frame.captured if self._start is None else self._start
        pts = round((frame.captured - self._start) / TIME_BASE_SECONDS)
        self._writer.write(Frame(self._convert(frame), pts, TIME_BASE_SECONDS, self._duration))

    def push_audio(self, chunk: AudioChunk) -> None:
        """See Sink; discard sound before the first frame."""
        if self._start is not None:
            self._writer.push_audio(chunk, chunk.time - self._start)

    def close(self) -> None:
        """See Sink."""
        self._writer.finish()

    def _convert(self, frame: LiveFrame) -> Picture:
        return convert(frame.picture, self._writer.encoding, self._writer.wants_rgb)


class NullTarget:
    """Discards every frame, for measurements."""

    name = "null"
    state = "running"
    dropped = repeated = 0

    def __init__(self, meter: LatencyMeter) -> None:
        self._meter = meter
        self.delivered = 0

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self.delivered += 1
        self._meter.record(frame.captured)

    def close(self) -> None:
        """See Target."""


@dataclass(frozen=True)
class Delivery:
    """What one target received: numbers of frames delivered, repeated and dropped."""

    name: str
    state: str
    delivered: int
    repeated: int
    dropped: int

    def __str__(self) -> str:
        counts = f"{self.delivered} delivered, {self.repeated} repeated, {self.dropped} dropped"
        return f"{self.name}: {self.state}, {counts}"


class TargetGroup:
    """Distributes frames and sound to all targets; no target delays another."""

    def __init__(self, makers: Sequence[Callable[[TargetContext], Target]]) -> None:
        """`makers`: each makes a target once the first frame is known."""
        self._makers = makers
        self._targets: list[Target] = []

    def open(self, context: TargetContext) -> None:
        """Make all targets.

        Raises:
            VidstyleError: one cannot be opened; `close` closes those before it.
        """
        for make in self._makers:
            self._targets.append(make(context))

    def offer(self, frame: LiveFrame) -> None:
        """Offer a frame to each target.

        Raises:
            VidstyleError: all of them have failed.
        """
        for target in self._targets:
            target.offer(frame)
        errors = self._errors()
        if errors and len(errors) == len(self._targets):
            raise errors[0]

    def push_audio(self, chunk: AudioChunk) -> None:
        """Queue sound at the targets that take any; thread-safe."""
        for target in self._targets.copy():
            if isinstance(target, TargetThread):
                target.push_audio(chunk)

    def close(self) -> BaseException | None:
        """Close all targets; returns the first error of any of them."""
        for target in self._targets:
            target.close()
        return next(iter(self._errors()), None)

    @property
    def states(self) -> tuple[tuple[str, str], ...]:
        """Name and state of each target."""
        return tuple((target.name, target.state) for target in self._targets)

    @property
    def deliveries(self) -> tuple[Delivery, ...]:
        counts = ("delivered", "repeated", "dropped")
        return tuple(
            Delivery(target.name, target.state, *(getattr(target, name, 0) for name in counts))
            for target in self._targets
        )

    def _errors(self) -> list[BaseException]:
        return [error for target in self._targets if (error := getattr(target, "error", None)) is not None]
