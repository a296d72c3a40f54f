"""The segments of a film, and the file that lists them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np

from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.sampling import sample_plane
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.errors import UsageError, error_reason
from vidstyle.media.frame import Frame
from vidstyle.media.write.atomic import atomic_file

MAX_PLAN_BYTES = 2**28


@dataclass(frozen=True)
class FilmSegment:
    """A part of a film.

    Attributes:
        first, end: numbers of its first frame, and of the first one after it.
        pts: pts of the first frame.
        digest: digest of its frames before they are restyled; see `FrameDigest`.
        before_pts: pts of the frame before it, if that belongs to the same scene.
        warm_up_pts: in that case, pts of the frame at which its warm-up starts.
        search_time: in that case, time of the last search for faces before it.
        face_detail: in that case, see `FaceFollower`.
    """

    first: int
    end: int
    pts: int
    digest: str
    before_pts: int | None = None
    warm_up_pts: int | None = None
    search_time: float | None = None
    face_detail: float = 1.0

    @property
    def name(self) -> str:
        """The range of frames, as for --range."""
        return f"{self.first}:{self.end}"

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.end - self.first


@dataclass(frozen=True)
class SegmentPlan:
    """The segments of a film, and their common settings.

    Attributes:
        parts: settings that all segments must share; see `setting_parts`.
        time_base: time base of all times, in seconds.
        cuts: pts of the first frame of each scene, for the processes of all segments.
        segments: in the order of the film.
        undivided: reason why the film cannot be divided, or an empty string.
        turns: turns of a `StyleRotation`, with the seconds as text.
    """

    parts: Mapping[str, str]
    time_base: str
    cuts: list[int]
    segments: list[FilmSegment]
    undivided: str = ""
    turns: list[tuple[str, int]] = field(default_factory=list)

    @property
    def known_cuts(self) -> KnownCuts:
        """The scene cuts, for a renderer."""
        return KnownCuts(float(pts * Fraction(self.time_base)) for pts in self.cuts)

    def neighbours(self, segment: FilmSegment) -> tuple[FilmSegment | None, FilmSegment | None]:
        """Return the segments before and after one, if they are of the same scene there."""
        place = self.segments.index(segment)
        before = None if segment.before_pts is None else self.segments[place - 1]
        after = next(iter(self.segments[place + 1 : place + 2]), None)
        return before, None if after is None or after.before_pts is None else after

    def segment(self, name: str) -> FilmSegment:
        """Return the segment of this range, "first:end"; raises UsageError."""
        for segment in self.segments:
            if segment.name == name:
                return segment
        names = ", ".join(segment.name for segment in self.segments)
        raise UsageError("--range", f"{name} is not a segment of this film", f"the segments are {names}")

    def check(self, path: Path, parts: Mapping[str, str]) -> None:
        """Raise UsageError if the plan was made with other settings; `path`: of the plan."""
        names = [name for name in {**parts, **self.parts} if parts.get(name) != self.parts.get(name)]
        if names:
            raise UsageError(path, f"was made with another {', '.join(names)}", "use the same, or --every")

    def write(self, path: Path) -> None:
        """Write the plan to a file, replacing it; raise OutputError if that fails."""
        with atomic_file(path, overwrite=True) as write:
            write(json.dumps(asdict(self)).encode())

    @classmethod
    def read(cls, path: Path) -> SegmentPlan:
        """Read the plan from a file; raise UsageError if that fails."""
        try:
            content = json.loads(read_regular_file(path, MAX_PLAN_BYTES))
            content["segments"] = [FilmSegment(**each) for each in content["segments"]]
            return cls(**content)
        except FileNotFoundError:
            raise UsageError(path, "does not exist", "run the command with --every first") from None
        except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
            raise UsageError(path, f"is not a plan ({error_reason(error)})", "run --every again") from error


class FrameDigest:
    """A digest of frames: their times, and a grid of pixels that no error of a decoder misses."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()

    def add(self, frame: Frame) -> None:
        """Add the next frame."""
        self._digest.update(f"{frame.pts} {frame.duration}".encode())
        picture = frame.picture
        for plane in (picture.luma, *(picture.chroma or ()), picture.color, picture.alpha):
            if plane is not None:
                self._digest.update(np.ascontiguousarray(sample_plane(plane)).data)

    @property
    def text(self) -> str:
        """In hexadecimal digits."""
        return self._digest.hexdigest()
