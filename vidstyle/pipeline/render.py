"""Renders a film: source, style, target."""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial
from heapq import heappop, heappush
from pathlib import Path
from typing import Any

from vidstyle.backend import Backend, FrameRequest
from vidstyle.core.convert import convert
from vidstyle.cues.cue_list import CueList
from vidstyle.errors import log
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, ReadOptions, VideoInfo, open_reader
from vidstyle.media.write.writer import WriteOptions, Writer, file_in_folder, is_finished, open_writer
from vidstyle.pipeline.compare import Compare, compare_info, compare_pictures
from vidstyle.pipeline.film_renderer import film_renderer
from vidstyle.pipeline.progress import Progress, Summary
from vidstyle.pipeline.resume import check_resumable, render_fingerprint, warm_up_frames
from vidstyle.pipeline.stages import Stages
from vidstyle.renderer import StyleLike, announce_device, open_renderer
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
    style: StyleLike | CueList,
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
        style: a style, what `load_style` takes, or styles over time.
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
    read, write = read or ReadOptions(), write or WriteOptions()
    style = style.moved(-(read.start or Fraction(0))) if isinstance(style, CueList) else load_style(style)
    target = file_in_folder(target, source)
    if resume:
        check_resumable(source, target, write)
        if is_finished(target):
            log.info("%s is already finished", target)
            return Summary(str(source), str(target), 0, 0.0, 0.0)
    renderer = open_renderer(style, device, announce=False)
    reader = open_reader(source, read)
    stages: Stages | None = None
    try:
        open_another = partial(open_renderer, device=device, announce=False)
        renderer = film_renderer(renderer, style, reader.info, write.alpha, open_another)
        info = compare_info(reader.info, compare)
        if frames and info.frames:
            info = replace(info, frames=min(frames, info.frames))
        more = {"frames": frames, "compare": compare, "device": renderer.device_kind}
        fingerprint = render_fingerprint(source, target, style, read, write, resume, **more)
        writer = open_writer(target, info, write, reader, fingerprint)
        announce_device(style, device)
        items = first_frames(reader, frames, bool(reader.copied_streams)) if frames else reader
        restyle: Restyle = partial(
            start_restyling, renderer, writer, compare, is_still=reader.info.frames == 1
        )
        if writer.kept:
            first = writer.kept - warm_up_frames(style, float(info.rate or 25))
            restyle = _starting_at(first, restyle, partial(_skip, renderer, writer))
        stages = Stages(items, restyle, writer, lambda: renderer.frames_in_flight, renderer.cancel)
        watch = _watcher(stages, reader.info, frames, writer.kept, began, on_progress)
        stages.run(stop or threading.Event(), watch)
        watch()
        return summarize(source, target, stages, reader, writer, time.monotonic() - began)
    finally:
        # A thread that still waits for data would read from freed memory.
        if stages is None or not stages.alive:
            reader.close()
            renderer.close()


def start_restyling(
    renderer: Backend, writer: Writer, compare: Compare | None, frame: Frame, is_still: bool = False
) -> Callable[[], Frame]:
    """Begin a frame; the returned function waits for the result, in the writer's encoding.

    If the style does not change it, the result is the same frame.

    Args:
        is_still: whether the frame is a single picture, not part of a film.
    """
    wanted = writer.encoding, writer.wants_rgb
    time = None if is_still else float(frame.time)
    pending = renderer.begin(FrameRequest(frame.picture, time, *wanted))

    def result() -> Frame:
        picture = pending.result()
        if compare:
            picture = compare_pictures(convert(frame.picture, *wanted), picture, compare)
        return frame if picture is frame.picture else replace(frame, picture=picture, native=None)

    return result


def _skip(renderer: Backend, writer: Writer, frame: Frame) -> Callable[[], Frame]:
    """Take note of a frame whose picture is not used."""
    renderer.skip(FrameRequest(frame.picture, float(frame.time), writer.encoding, writer.wants_rgb))
    return lambda: frame


def _starting_at(first: int, restyle: Restyle, skip: Restyle) -> Restyle:
    """`restyle` from the frame with this number on, and `skip` before."""
    numbers = itertools.count()
    return lambda frame: restyle(frame) if next(numbers) >= first else skip(frame)


def first_frames(items: Iterable[Any], count: int, packets: bool) -> Iterator[Any]:
    """Yield the first `count` frames, and any `packets` until the end of the last frame.

    A decoder with several threads reads far ahead, so packets wait for the frames at their time.
    """
    end: Fraction | None = None
    early, numbers = list[tuple[Fraction, int, Any]](), itertools.count()
    for item in items:
        if isinstance(item, Frame):
            if end is not None and count == 0 and item.time > end + INTERLEAVING_SECONDS:
                return
            if count > 0:
                count -= 1
                end = item.time + (item.duration or 1) * item.time_base
                yield item
                yield from _begun(early, end)
            if count == 0 and not packets:
                return
        else:
            begin = None if item.pts is None else item.pts * item.time_base
            if begin is None or (end is not None and begin < end):
                yield item
            elif count > 0:
                heappush(early, (begin, next(numbers), item))
    if count > 0:
        yield from _begun(early)


def _begun(early: list[tuple[Fraction, int, Any]], end: Fraction | float = math.inf) -> list[Any]:
    """Take the packets that begin before `end` from a heap; return them in the order of their numbers."""
    begun = list[tuple[Fraction, int, Any]]()
    while early and early[0][0] < end:
        begun.append(heappop(early))
    return [packet for _, _, packet in sorted(begun, key=lambda each: each[1])]


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


def summarize(
    source: str | Path, target: str | Path, stages: Stages, reader: Reader, writer: Writer, elapsed: float
) -> Summary:
    """Return the result of a job that has ended."""
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
