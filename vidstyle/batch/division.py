"""A long film of a batch: plan, segments and join, with scratch files in a folder next to the result."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

from vidstyle.batch.batch_film import BatchFilm
from vidstyle.batch.processes import Event, Outcome
from vidstyle.batch.scratch import LOCK_NAME, is_scratch, lock_scratch, remove_folder
from vidstyle.errors import InputError, UsageError
from vidstyle.media.write.segment_file import SegmentIndex, read_index
from vidstyle.media.write.temporary_files import FileLock
from vidstyle.pipeline.scene_memory import memory_path, read_memory, unproved_segments
from vidstyle.pipeline.segment_plan import FilmSegment, SegmentPlan
from vidstyle.pipeline.segments import PLAN_NAME, segment_path

SCRATCH_MARK = ".segments-"
"""Text before the digest in the name of a scratch folder."""
MAX_NAME_LETTERS = 150

RunProcess = Callable[[list[str], Callable[[Event], None]], Outcome]
"""Runs a process of vidstyle with these arguments when the limit of processes allows; see `Processes.run`."""


class Division:
    """A film that is rendered in segments.

    Args:
        film: the film.
        settings: everything that determines its segments; other settings have another folder.
        every: minimum length of a segment, as for --every.
        jobs: number of parallel processes.

    Attributes:
        scratch: the folder with plan and segments.
    """

    def __init__(self, film: BatchFilm, settings: Mapping[str, str], every: str, jobs: int) -> None:
        self._film, self._every, self._jobs = film, every, jobs
        digest = hashlib.sha256(repr(sorted({**settings, "every": every}.items())).encode()).hexdigest()
        assert isinstance(film.target, Path), "the command line refuses films in storage"
        self._target = film.target
        self.scratch = film.target.resolve().with_name(_front(film.target) + digest[:16])

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the film against other batches, and remove their scratch files with other settings.

        At the end the folder is removed if it has no plan.

        Raises:
            BlockingIOError: another batch is rendering it.
            OutputError: the folder cannot be created, or something else has its name.
        """
        lock = lock_scratch(self.scratch)
        try:
            remove_scratch(self._target, keep=self.scratch)
            yield
        finally:
            if not (self.scratch / PLAN_NAME).exists():
                self.remove()
            lock.release()

    def make(self, words: list[str], run: RunProcess) -> Outcome | None:
        """Render the film; return None if it cannot be divided.

        Args:
            words: command line options of all processes, with input and output.
        """
        outcome = self.prepare(words, run)
        if outcome.exit_code:
            return outcome
        plan = self._plan()
        if _is_whole(plan):
            return None
        outcome = self._make_segments(plan, words, run)
        return outcome if outcome.exit_code else run([*self._command(words), "--join"], lambda event: None)

    def prepare(self, words: list[str], run: RunProcess) -> Outcome:
        """Find the segments of the film, unless they are known; for the arguments see `make`."""
        with suppress(UsageError):  # there is no plan, or a damaged one
            self._plan()
            return Outcome(0, "", {})
        return run([*self._command(words), f"--every={self._every}"], lambda event: None)

    def missing_segments(self) -> list[FilmSegment]:
        """Return the unfinished segments; none if the film cannot be divided.

        A segment that does not continue the segment before it is removed, to be rendered again from the state
        of that segment.
        """
        plan = self._plan()
        if _is_whole(plan):
            return []
        finished = {each: index for each in plan.segments if (index := self._index(each))}
        for segment in self._check_borders(plan, finished):
            segment_path(self.scratch, segment).unlink()
            del finished[segment]
        return [each for each in plan.segments if each not in finished]

    def _check_borders(
        self, plan: SegmentPlan, finished: Mapping[FilmSegment, SegmentIndex]
    ) -> set[FilmSegment]:
        """Return the segments to make again, and remove the memory files that have served."""
        unproved, again = unproved_segments(plan, finished), set[FilmSegment]()
        for segment in finished:
            before, _ = plan.neighbours(segment)
            if before is None or before not in finished:
                continue
            earlier = segment_path(self.scratch, before)
            if segment not in unproved:
                memory_path(earlier).unlink(missing_ok=True)
            elif before not in unproved:  # otherwise its memory changes
                again.add(before if read_memory(earlier, segment) is None else segment)
        return again

    def segment_words(self, words: list[str], segment: FilmSegment) -> list[str]:
        """Return the command that renders a segment; `words`: as for `make`."""
        return [*self._command(words), f"--range={segment.name}"]

    def _command(self, words: list[str]) -> list[str]:
        return ["segment", *words, f"--scratch={self.scratch}"]

    def _plan(self) -> SegmentPlan:
        return SegmentPlan.read(self.scratch / PLAN_NAME)

    def remove(self) -> None:
        """Remove the scratch files."""
        remove_folder(self.scratch)

    def _make_segments(self, plan: SegmentPlan, words: list[str], run: RunProcess) -> Outcome:
        """Render all segments; return the outcome of the first one that failed."""
        progress = _SegmentProgress(self._film, plan)
        outcome = Outcome(0, "", {})
        while not outcome.exit_code:
            missing = self.missing_segments()
            for segment in plan.segments:
                progress.follow(segment, {"frames": 0 if segment in missing else segment.frames})
            if not missing:
                break
            outcome = self._make_missing(missing, progress, words, run)
        return outcome

    def _make_missing(
        self, missing: list[FilmSegment], progress: _SegmentProgress, words: list[str], run: RunProcess
    ) -> Outcome:
        """Make these segments, the longest first; the outcome is of the first that failed."""

        def make(segment: FilmSegment) -> Outcome:
            if failed:
                return failed[0]
            command = self.segment_words(words, segment)
            outcome = run(command, lambda event: progress.follow(segment, event))
            progress.follow(segment, {"fps": 0.0})
            if outcome.exit_code:
                failed.append(outcome)
            return outcome

        failed: list[Outcome] = []
        with ThreadPoolExecutor(self._jobs, "vidstyle batch segment") as pool:
            list(pool.map(make, sorted(missing, key=lambda each: -each.frames)))
        return failed[0] if failed else Outcome(0, "", {})

    def _index(self, segment: FilmSegment) -> SegmentIndex | None:
        """Return the index of a complete segment; remove a damaged one."""
        path = segment_path(self.scratch, segment)
        try:
            return read_index(path)
        except FileNotFoundError:
            return None
        except (InputError, OSError):
            path.unlink(missing_ok=True)
            return None


class _SegmentProgress:
    """The progress of a film, computed from the progress of its segments."""

    def __init__(self, film: BatchFilm, plan: SegmentPlan) -> None:
        self._film, self._total = film, plan.segments[-1].end
        self._events: dict[FilmSegment, dict[str, float]] = {}
        self._lock = threading.Lock()

    def follow(self, segment: FilmSegment, event: Mapping[str, float]) -> None:
        """Update the progress from an event of a segment's process."""
        with self._lock:
            known = self._events.setdefault(segment, {"frames": 0, "fps": 0.0})
            known |= {name: event[name] for name in known if name in event}
            frames, fps = (sum(each[name] for each in self._events.values()) for name in ("frames", "fps"))
            left = (self._total - frames) / fps if fps else None
            done = {"frames": int(frames), "fps": fps, "fraction": frames / self._total, "eta": left}
            self._film.follow(done)


def _is_whole(plan: SegmentPlan) -> bool:
    """Whether the film is rendered without segments."""
    return bool(plan.undivided) or len(plan.segments) == 1


def is_taken(target: Path) -> bool:
    """Whether another batch renders the segments of this target."""
    for folder in _scratch_folders(target):
        try:
            FileLock(folder / LOCK_NAME).release()
        except BlockingIOError:
            return True
        except OSError:
            continue
    return False


def remove_scratch(target: Path, keep: Path | None = None) -> None:
    """Remove the scratch files of a target that no batch uses, except the folder `keep`."""
    for folder in _scratch_folders(target):
        if folder != keep:
            with suppress(OSError):
                lock = FileLock(folder / LOCK_NAME)
                remove_folder(folder)
                lock.release()


def check_options(options: Mapping[str, object]) -> None:
    """Raise UsageError for a length of 0, and for options that segments do not support."""
    if not options["segment"]:
        raise UsageError("--segment", "0 is not a length", "give seconds, such as 30")
    if options["frames"] is not None:
        raise UsageError("--frames", "cannot be used with --segment", "use --end")


def _scratch_folders(target: Path) -> Iterator[Path]:
    return filter(is_scratch, target.resolve().parent.glob(f"{_escaped(_front(target))}*"))


def _front(target: Path) -> str:
    """Return the prefix of the names of a target's scratch folders."""
    return f".{target.resolve().name[:MAX_NAME_LETTERS]}{SCRATCH_MARK}"


def _escaped(name: str) -> str:
    """Escape a name as a pattern that only this name matches."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in name)
