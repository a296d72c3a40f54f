"""The memory of a renderer between two segments of a scene: compared by digests, stored in files."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np

from vidstyle.backend import Backend
from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.picture import Encoding
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.write.atomic import atomic_file
from vidstyle.media.write.segment_file import SegmentIndex, read_index
from vidstyle.pipeline.segment_plan import FilmSegment, SegmentPlan

MAX_MEMORY_BYTES = 2**32


class OtherFramesError(InputError):
    """The frames of a segment differ from the same frames of the whole film."""


class SceneMemory:
    """Gives a renderer the memory of the frames before its segment, and saves its memory at the end.

    If the previous segment is finished, its memory is reused. Otherwise the renderer restyles the frames
    before its segment, and the digests show later whether it then had the same memory.

    Args:
        renderer: without pictures so far.
        segment: the segment.
        before: file of the segment before it, if that is of the same scene.
        kept: file for the memory at the end, if the next segment is of the same scene.

    Attributes:
        begin_pts: of the first frame that `first_frame` needs.
    """

    def __init__(
        self, renderer: Backend, segment: FilmSegment, before: Path | None, kept: Path | None
    ) -> None:
        self._renderer, self._segment, self._kept = renderer, segment, kept
        self._given = None if before is None else read_memory(before, segment)
        self._digest = ""
        begin = segment.warm_up_pts if self._given is None else segment.before_pts
        self.begin_pts = segment.pts if begin is None else begin

    def first_frame(
        self, frames: Iterator[Frame], target: Encoding, rgb: bool, stop: threading.Event
    ) -> Iterator[Frame]:
        """Restyle the frames before the segment, and yield its first frame.

        Args:
            frames: of the film from `begin_pts` on.
            target, rgb: as for the frames of the segment; see `Backend.run`.

        Raises:
            OtherFramesError: the frames before the segment differ from the film.
            CancelledError: `stop` was set.
        """
        pts = None
        for frame in frames:
            if frame.pts >= self._segment.pts:
                break
            if stop.is_set():
                raise CancelledError
            self._renderer.run(frame.picture, float(frame.time), target, rgb)
            pts = frame.pts
        else:
            return
        if pts != self._segment.before_pts:
            raise OtherFramesError(self._segment.name, "is read differently")
        if pts is not None:
            self._digest = self._remembered(pts)
        yield frame

    def _remembered(self, pts: int) -> str:
        if self._given is not None:
            restore_memory(self._renderer, self._given)
        return memory_digest(memory_bytes(self._renderer), pts)

    def digests(self, pts: int) -> tuple[str, str]:
        """Save the memory after the last frame, which has these pts; return both digests."""
        if self._kept is None:
            return self._digest, ""
        memory = memory_bytes(self._renderer)
        with atomic_file(self._kept, overwrite=True) as write:
            write(memory)
        return self._digest, memory_digest(memory, pts)


def memory_path(segment: Path) -> Path:
    """Return the file with the memory at the end of a segment."""
    return segment.with_suffix(".memory")


def read_memory(before: Path, segment: FilmSegment) -> bytes | None:
    """Return the memory at the end of a finished segment, for the next one; None if there is none.

    Args:
        before: file of the finished segment.
    """
    assert segment.before_pts is not None
    try:
        memory = read_regular_file(memory_path(before), MAX_MEMORY_BYTES)
        digest = read_index(before).memory[1]
    except (InputError, OSError, ValueError):
        return None
    return memory if memory_digest(memory, segment.before_pts) == digest else None


def memory_bytes(renderer: Backend) -> bytes:
    """Return a renderer's memory of earlier pictures; all started pictures must be finished."""
    return b"".join(np.ascontiguousarray(each).tobytes() for each in renderer.memory())


def memory_digest(memory: bytes, pts: int) -> str:
    """Return the digest of a memory after the frame with these pts."""
    return hashlib.sha256(f"{pts} ".encode() + memory).hexdigest()


def restore_memory(renderer: Backend, memory: bytes) -> None:
    """Overwrite the memory of a renderer that has restyled the same last picture."""
    for array in renderer.memory():
        content, memory = memory[: array.nbytes], memory[array.nbytes :]
        array[...] = np.frombuffer(content, array.dtype).reshape(array.shape)


def unproved_segments(plan: SegmentPlan, indexes: Mapping[FilmSegment, SegmentIndex]) -> list[FilmSegment]:
    """Return the segments that began with another memory than the one at the end of the previous segment.

    Args:
        indexes: of the segments that are finished.
    """
    found = []
    for segment, index in indexes.items():
        before, _ = plan.neighbours(segment)
        if before is not None and before in indexes and indexes[before].memory[1] != index.memory[0]:
            found.append(segment)
    return found
