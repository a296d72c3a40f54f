"""Renders a film: source, style, target."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from vidstyle.core.convert import convert
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, ReadOptions, VideoInfo, open_reader
from vidstyle.media.write.writer import WriteOptions, Writer, open_writer
from vidstyle.pipeline.compare import Compare, compared, compared_info
from vidstyle.pipeline.progress import Progress, Summary
from vidstyle.pipeline.stages import Stages
from vidstyle.renderer import Backend, StyleLike, open_renderer

DAMAGED_EXIT_CODE = 4
"""Done, but the input was damaged (docs/rules.md, Exit codes)."""
INTERLEAVING_SECONDS = 1
"""How much later than its frame an audio packet may be stored."""


def render(
    source: str | Path,
    target: str | Path,
    style: StyleLike,
    *,
    read: ReadOptions | None = None,
    write: WriteOptions | None = None,
    device: str = "auto",
    frames: int | None = None,
    compare: Compare | None = None,
    on_progress: Callable[[Progress], None] | None = None,
    stop: threading.Event | None = None,
) -> Summary:
    """Restyle a film, a picture, an image sequence or a pipe.

    Args:
        source: a path, a pattern such as `%05d.png`, or "-" for standard input.
        target: the same, or "-" for standard output; its ending says what kind of file it becomes.
        style: a style, or what `load_style` takes.
        read, write: how to read and how to write; see their classes.
        device: "auto", "cpu", "gpu" or "gpu:N"; see `open_renderer`.
        frames: how many frames at most.
        compare: "side" or "split" to show the source beside the result.
        on_progress: called about ten times a second, in the calling thread.
        stop: set it, from anywhere, to end early: what is done is kept as a partial file, which plays.

    Raises:
        VidstyleError: of one of its kinds. A note names the partial file, if there is one.
    """
    began = time.monotonic()
    renderer = open_renderer(style, device)
    reader = open_reader(source, read or ReadOptions())
    stages: Stages | None = None
    try:
        info = compared_info(reader.info, compare)
        writer = open_writer(target, info, write or WriteOptions(), reader)
        items = first_frames(reader, frames) if frames else reader
        restyle = partial(_start_restyling, renderer, writer, compare)
        stages = Stages(items, restyle, writer, renderer.frames_in_flight)
        watch = _watcher(stages, reader.info, frames, began, on_progress)
        stages.run(stop or threading.Event(), watch)
        watch()
        return _summary(source, target, stages, reader, writer, time.monotonic() - began)
    finally:
        # A thread that still waits for data would read from freed memory.
        if stages is None or not stages.alive:
            reader.close()
            renderer.close()


def _start_restyling(
    renderer: Backend, writer: Writer, compare: Compare | None, frame: Frame
) -> Callable[[], Frame]:
    """Begin with a frame; what is returned waits for the result, in the writer's encoding.

    The result is the frame itself when nothing is to be changed.
    """
    wanted = writer.encoding, writer.wants_rgb
    pending = renderer.start(frame.picture, float(frame.time), *wanted)

    def result() -> Frame:
        picture = pending.result()
        if compare:
            picture = compared(convert(frame.picture, *wanted), picture, compare)
        return frame if picture is frame.picture else replace(frame, picture=picture, native=None)

    return result


def first_frames(items: Iterable[Any], count: int) -> Iterator[Any]:
    """The first `count` frames, and the packets until the last of them ends."""
    end = None
    for item in items:
        if isinstance(item, Frame):
            if count == 0 and end is not None and item.time > end + INTERLEAVING_SECONDS:
                return
            if count > 0:
                count -= 1
                end = item.time + (item.duration or 1) * item.time_base
                yield item
        elif count > 0 or end is None or item.pts is None or item.pts * item.time_base < end:
            yield item


def _watcher(
    stages: Stages,
    info: VideoInfo,
    frames: int | None,
    began: float,
    on_progress: Callable[[Progress], None] | None,
) -> Callable[[], None]:
    total = min((number for number in (frames, info.frames) if number), default=None)
    duration = None if frames or info.duration is None else float(info.duration)

    def watch() -> None:
        if on_progress is not None:
            elapsed = time.monotonic() - began
            on_progress(Progress(stages.frames, stages.end - stages.start, elapsed, total, duration))

    return watch


def _summary(
    source: str | Path, target: str | Path, stages: Stages, reader: Reader, writer: Writer, elapsed: float
) -> Summary:
    damage, loss = reader.damage, writer.loss
    found = damage.report()
    if loss:
        found = f"{found}, {loss}" if found else f"the input is damaged: {loss}"
    return Summary(
        source=str(source),
        target=str(target),
        frames=stages.frames,
        duration=stages.end - stages.start,
        elapsed=elapsed,
        damage=found,
        exit_code=DAMAGED_EXIT_CODE if damage.is_significant or loss else 0,
        stopped=not stages.finished,
        partial=stages.partial,
    )
