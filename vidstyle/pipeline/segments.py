"""Renders the segments of a film separately, and joins them."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.backend import Backend
from vidstyle.core.picture import Picture
from vidstyle.cues.cue_list import CueList
from vidstyle.cues.rotation import StyleChoice, StyleRotation, Turn
from vidstyle.errors import InputError, OutputError, UsageError, log
from vidstyle.media.frame import Frame
from vidstyle.media.options import ReadOptions, VideoInfo, WriteOptions
from vidstyle.media.read.reader import Reader, open_reader
from vidstyle.media.write.atomic import resolve_path
from vidstyle.media.write.containers import find_kind
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.media.write.segment_file import JoinedSegments, SegmentWriter
from vidstyle.media.write.temporary_files import TEMPORARY_MARK, TOKEN_BYTES, partial_path, rename_to_new
from vidstyle.media.write.writer import open_writer
from vidstyle.pipeline.compare import Compare, compare_info
from vidstyle.pipeline.film_renderer import film_renderer
from vidstyle.pipeline.progress import Progress, Summary
from vidstyle.pipeline.render import start_restyling, summarize
from vidstyle.pipeline.scene_memory import OtherFramesError, SceneMemory, memory_path, unproved_segments
from vidstyle.pipeline.segment_borders import plan_segments
from vidstyle.pipeline.segment_plan import FilmSegment, FrameDigest, SegmentPlan
from vidstyle.pipeline.stages import Stages
from vidstyle.regions.face_tracks import FacelessStart
from vidstyle.renderer import follow_faces, open_renderer
from vidstyle.style import Style

PLAN_NAME = "plan.json"
"""Name of the plan in the folder of a film's segments."""
MARGIN_SECONDS = Fraction(1)
"""Time before its first frame at which reading a segment starts: deinterlacing and frame rates look back."""


@dataclass(frozen=True)
class SegmentedFilm:
    """A film that is restyled in segments.

    Attributes:
        source, target: of the whole film.
        folder: for the plan and the segments.
        style: the style, or the styles over time.
        read, write, device, compare: as for `render`.
        parts: all settings, for comparison with the plan's.
    """

    source: Path
    target: Path
    folder: Path
    style: StyleChoice
    read: ReadOptions
    write: WriteOptions
    device: str
    compare: Compare | None
    parts: Mapping[str, str]

    def plan(
        self,
        seconds: Fraction,
        show: Callable[[Progress], None],
        stop: threading.Event,
        turns: Sequence[Turn] = (),
    ) -> SegmentPlan:
        """Read the film once, and write the plan of its segments.

        Args:
            seconds: minimum length of a segment.
            turns: turns of a `StyleRotation`, which the plan keeps for all segments.
        """
        style = self._style(turns)
        # Faces are expensive to track, and few films have a scene for which they matter.
        plan = self._planned(style, seconds, False, show, stop) or self._planned(
            style, seconds, True, show, stop
        )
        assert plan is not None
        plan = replace(plan, turns=[(str(start), number) for start, number in turns])
        plan.write(self.folder / PLAN_NAME)
        return plan

    def _style(self, turns: Iterable[Turn]) -> Style | CueList:
        """Return the style, or the styles at the times of the reader's frames."""
        look = self.style.cue_list(turns) if isinstance(self.style, StyleRotation) else self.style
        return look.moved(-(self.read.start or Fraction(0))) if isinstance(look, CueList) else look

    def _planned(
        self,
        style: Style | CueList,
        seconds: Fraction,
        follows_faces: bool,
        show: Callable[[Progress], None],
        stop: threading.Event,
    ) -> SegmentPlan | None:
        """Read the film once; see `plan_segments`."""
        path, began = self.folder / PLAN_NAME, time.monotonic()
        with open_reader(self.source, self.read) as reader:

            def follow(number: int) -> None:
                show(Progress(number, 0.0, time.monotonic() - began, reader.info.frames))
                if stop.is_set():
                    raise OutputError(path, "was not written: stopped")

            is_film = find_kind(str(self.target), None, False).way == "film"
            undivided = "" if is_film else "is written as a picture or a GIF"
            return plan_segments(
                reader, style, self.device, seconds, self.parts, undivided, follows_faces, follow
            )

    def render(self, name: str, show: Callable[[Progress], None], stop: threading.Event) -> Summary:
        """Restyle the segment with this name into a separate file."""
        plan = self._checked_plan()
        segment = plan.segment(name)
        try:
            return self._render(plan, segment, segment.first > 0, show, stop)
        except OtherFramesError:
            if not segment.first:
                raise
            log.info("%s: segment %s is decoded from the start of the film", self.source, name)
            return self._render(plan, segment, False, show, stop)

    def join(self, overwrite: bool, stop: threading.Event) -> Summary:
        """Join all segments with the sound and the other streams of the source, and rename the film.

        Args:
            overwrite: whether the target may exist.
        """
        plan = self._checked_plan()
        segments = JoinedSegments([segment_path(self.folder, each) for each in plan.segments])
        for segment in unproved_segments(plan, dict(zip(plan.segments, segments.indexes, strict=True))):
            path = segment_path(self.folder, segment)
            remedy = f"render it again: --range {segment.name}"
            raise InputError(path, "does not continue the segment before it", remedy)
        joined = partial_path(
            self.folder / self.target.name, mark=TEMPORARY_MARK + secrets.token_hex(TOKEN_BYTES)
        )
        began = time.monotonic()
        with open_reader(self.source, self.read) as reader:
            info = compare_info(reader.info, self.compare)
            reader.skip_pictures()
            writer = open_writer(joined, info, replace(self.write, overwrite=True), reader)
            assert isinstance(writer, FilmWriter)
            try:
                writer.use_segments(segments)
            except OutputError:
                writer.abandon()
                raise
            merged = _merged(reader, segments)
            stages = Stages(merged, lambda frame: lambda: frame, writer, lambda: 0, lambda: None)
            stages.run(stop, lambda: None)
            summary = summarize(self.source, self.target, stages, reader, writer, time.monotonic() - began)
        if stages.finished:
            put_in_place(joined, resolve_path(self.target), overwrite)
        return summary

    def _checked_plan(self) -> SegmentPlan:
        path = self.folder / PLAN_NAME
        plan = SegmentPlan.read(path)
        plan.check(path, self.parts)
        if plan.undivided:
            raise UsageError(self.source, f"has no segments: it {plan.undivided}", "use 'vidstyle render'")
        return plan

    def _renderer(self, plan: SegmentPlan, segment: FilmSegment, info: VideoInfo) -> Backend:
        """Open a renderer for a segment; only plans for the CPU have segments that share a scene."""
        device = "cpu" if any(plan.neighbours(segment)) else self.device
        style = self._style((Fraction(start), number) for start, number in plan.turns)
        cuts, faces = plan.known_cuts, None
        if segment.search_time is not None and isinstance(style, Style):
            start_time = float(segment.pts * Fraction(plan.time_base))
            faceless = FacelessStart(start_time, segment.search_time, segment.face_detail)
            faces = follow_faces(style, cuts, faceless)
        renderer = open_renderer(style, device, announce=False, cuts=cuts, faces=faces)
        open_another = partial(open_renderer, device=device, announce=False)
        return film_renderer(renderer, style, info, self.write.alpha, open_another)

    def _render(
        self,
        plan: SegmentPlan,
        segment: FilmSegment,
        seeks: bool,
        show: Callable[[Progress], None],
        stop: threading.Event,
    ) -> Summary:
        began = time.monotonic()
        path, (before, after) = segment_path(self.folder, segment), plan.neighbours(segment)
        reader, stages = open_reader(self.source, self.read), None
        renderer: Backend | None = None
        try:
            renderer = self._renderer(plan, segment, reader.info)
            info = compare_info(reader.info, self.compare)
            kind = find_kind(str(self.target), None, False)
            before_path = None if before is None else segment_path(self.folder, before)
            memory = SceneMemory(renderer, segment, before_path, None if after is None else memory_path(path))
            film = _frames_from(reader, memory.begin_pts, seeks)
            writer = SegmentWriter(path, kind, info, self.write, reader, None)
            writer.memory = lambda: memory.digests(0 if after is None else after.before_pts or 0)
            first = memory.first_frame(film, writer.encoding, writer.wants_rgb, stop)
            restyle: Any = partial(start_restyling, renderer, writer, self.compare)
            frames = _checked(chain(first, film), segment, reader.name)
            stages = Stages(frames, restyle, writer, lambda: renderer.frames_in_flight, renderer.cancel)

            def watch() -> None:
                show(Progress(stages.frames, 0.0, time.monotonic() - began, segment.frames))

            stages.run(stop, watch)
            watch()
            return summarize(self.source, path, stages, reader, writer, time.monotonic() - began)
        finally:
            if stages is None or not stages.alive:
                reader.close()
                if renderer is not None:
                    renderer.close()


def segment_path(folder: Path, segment: FilmSegment) -> Path:
    """Return the file of a segment."""
    return folder / f"{segment.first}-{segment.end}.segment"


def put_in_place(path: Path, target: Path, overwrite: bool) -> None:
    """Rename a finished film to its target.

    Raises:
        OutputError: the target exists and must not be overwritten, or the rename failed.
    """
    try:
        path.replace(target) if overwrite else rename_to_new(path, target)
    except FileExistsError:
        raise OutputError(target, "appeared during the run and is not overwritten") from None
    except OSError as error:
        raise OutputError(target, f"cannot be written ({error.strerror})") from error


def _frames_from(reader: Reader, pts: int, seeks: bool) -> Iterator[Frame]:
    """Yield the frames of a film from these pts on; `seeks`: seek to a position shortly before them."""
    if seeks:
        reader.seek(max(Fraction(0), pts * reader.info.time_base - MARGIN_SECONDS))
    return (frame for frame in reader if isinstance(frame, Frame) and frame.pts >= pts)


def _checked(frames: Iterator[Frame], segment: FilmSegment, name: str) -> Iterator[Frame]:
    """Yield the frames of a segment; raises OtherFramesError after them if they differ from the film."""
    digest = FrameDigest()
    for frame in islice(frames, segment.frames):
        digest.add(frame)
        yield frame
    if digest.text != segment.digest:
        raise OtherFramesError(name, f"was changed, or is decoded differently, in frames {segment.name}")


def _merged(reader: Reader, segments: JoinedSegments) -> Iterator[Any]:
    """Yield the times of all frames, as frames without pictures, and the packets of other streams."""
    blank = Picture.from_array(np.zeros((1, 1), np.uint8))
    frames = (Frame(blank, pts, base, duration or None) for pts, duration, base in segments.frames())
    frame = next(frames, None)
    for packet in reader:
        if isinstance(packet, Frame):  # decoded before pictures were skipped
            continue
        time = packet.pts * packet.time_base if packet.pts is not None and packet.time_base else None
        while frame is not None and time is not None and frame.time <= time:
            yield frame
            frame = next(frames, None)
        yield packet
    while frame is not None:
        yield frame
        frame = next(frames, None)
