"""Renders a film: source, style, target."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from vidstyle.core.convert import convert
from vidstyle.errors import log
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, ReadOptions, VideoInfo, open_reader
from vidstyle.media.write.writer import WriteOptions, Writer, file_in_folder, is_finished, open_writer
from vidstyle.pipeline.compare import Compare, compared, compared_info
from vidstyle.pipeline.progress import Progress, Summary
from vidstyle.pipeline.resume import check_resumable, render_fingerprint, warm_up_frames
from vidstyle.pipeline.stages import Stages
from vidstyle.renderer import Backend, StyleLike, announce_device, open_renderer
from vidstyle.style import load_style

Restyle = Callable[[Frame], Callable[[], Frame]]
"""Begins with a frame and returns what waits for the result."""


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
    resume: bool = False,
    on_progress: Callable[[Progress], None] | None = None,
    stop: threading.Event | None = None,
) -> Summary:
    """Restyle a film, a picture, an image sequence or a pipe.

    Args:
        source: a path, a pattern such as `%05d.png` or `*.png`, or "-" for standard input.
        target: the same, or "-" for standard output; its ending says what kind of file it becomes. A folder
            takes a file of the source's name.
        style: a style, or what `load_style` takes.
        read, write: how to read and how to write; see their classes.
        device: "auto", "cpu", "gpu" or "gpu:N"; see `open_renderer`.
        frames: how many frames at most.
        compare: "side" or "split" to show the source next to the result.
        resume: continue an interrupted run with the same settings at its last complete group of pictures.
            Without an interrupted run, begin at the start; if the target is finished, do nothing.
        on_progress: called about ten times a second, in the calling thread.
        stop: set it from any thread to end early; the finished frames are kept as a playable partial file.

    Raises:
        VidstyleError: of one of its kinds. A note names the partial file, if there is one.
    """
    began = time.monotonic()
    style, read, write = load_style(style), read or ReadOptions(), write or WriteOptions()
    target = file_in_folder(target, source)
    if resume:
        check_resumable(source, target, write)
        if is_finished(target):
            log.info("%s is finished: nothing is left to do", target)
            return Summary(str(source), str(target), 0, 0.0, 0.0)
    renderer = open_renderer(style, device, announce=False)
    reader = open_reader(source, read)
    stages: Stages | None = None
    try:
        info = compared_info(reader.info, compare)
        if frames and info.frames:
            info = replace(info, frames=min(frames, info.frames))
        device_kind = type(renderer).__module__.split(".")[1]  # the package cpu or gpu
        more = {"frames": frames, "compare": compare, "device": device_kind}
        fingerprint = render_fingerprint(source, target, style, read, write, resume, **more)
        writer = open_writer(target, info, write, reader, fingerprint)
        announce_device(style, device)
        items = first_frames(reader, frames, bool(reader.copied_streams)) if frames else reader
        restyle: Restyle = partial(_start_restyling, renderer, writer, compare)
        if writer.kept:
            restyle = _starting_at(writer.kept - warm_up_frames(style, float(info.rate or 25)), restyle)
        stages = Stages(items, restyle, writer, renderer.frames_in_flight)
        watch = _watcher(stages, reader.info, frames, writer.kept, began, on_progress)
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
    """Begin a frame; the returned function waits for the result, in the writer's encoding.

    If the style does not change it, the result is the same frame.
    """
    wanted = writer.encoding, writer.wants_rgb
    pending = renderer.start(frame.picture, float(frame.time), *wanted)

    def result() -> Frame:
        picture = pending.result()
        if compare:
            picture = compared(convert(frame.picture, *wanted), picture, compare)
        return frame if picture is frame.picture else replace(frame, picture=picture, native=None)

    return result


def _starting_at(first: int, restyle: Restyle) -> Restyle:
    """`restyle` from the frame with this number on; the pictures of those before are not used."""
    numbers = itertools.count()
    return lambda frame: restyle(frame) if next(numbers) >= first else lambda: frame


def first_frames(items: Iterable[Any], count: int, packets: bool) -> Iterator[Any]:
    """Yield the first `count` frames, and any `packets` until the end of the last frame."""
    end = None
    for item in items:
        if isinstance(item, Frame):
            if count == 0 and end is not None and item.time > end + INTERLEAVING_SECONDS:
                return
            if count > 0:
                count -= 1
                end = item.time + (item.duration or 1) * item.time_base
                yield item
            if count == 0 and not packets:
                return
        elif count > 0 or end is None or item.pts is None or item.pts * item.time_base < end:
            yield item


def _watcher(
    stages: Stages,
    info: VideoInfo,
    frames: int | None,
    kept: int,
    began: float,
    on_progress: Callable[[Progress], None] | None,
) -> Callable[[], None]:
    total = min((number for number in (frames, info.frames) if number), default=None)
    duration = None if frames or info.duration is None else float(info.duration)
    since: Progress | None = None

    def watch() -> None:
        nonlocal since
        elapsed = time.monotonic() - began
        progress = Progress(stages.frames, stages.end - stages.start, elapsed, total, duration)
        if progress.frames <= kept:
            since = progress
        if on_progress is not None:
            on_progress(replace(progress, since=since))

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
        kept=writer.kept,
        duration=stages.end - stages.start,
        elapsed=elapsed,
        damage=found,
        exit_code=DAMAGED_EXIT_CODE if damage.is_significant or loss else 0,
        stopped=not stages.finished,
        partial=stages.partial,
    )
