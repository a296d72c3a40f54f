"""Render a film on some cores in a separate process, and measure the film or its tasks.

The functions start `python -m tools.replay.film_job JSON`.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tools.replay.record import Recording, recording

WARM_UP_FRAMES = 6
SHORT_RATIO = 0.25
"""Frames of the short film whose times are subtracted, relative to the frames of the film."""


@dataclass(frozen=True)
class FilmJob:
    """A render of at most the first `frames` of a clip on given cores, at `size` if given.

    Attributes:
        records: whether to record the tasks of the frames.
        large_bands: whether to use the bands of more than `MAX_SMALL_BAND_THREADS` threads.
    """

    clip: str
    style: str
    frames: int
    cores: Sequence[int]
    size: tuple[int, int] | None = None
    records: bool = False
    large_bands: bool = False


@dataclass(frozen=True)
class FilmTimes:
    """Times of the frames of a film in seconds.

    Attributes:
        frames: number of frames.
        processor: processor time of all threads and processes.
        busy: busy time of each core, other programs included.
        voluntary, involuntary: numbers of context switches.
    """

    frames: int
    seconds: float
    processor: float
    busy: tuple[float, ...]
    voluntary: int
    involuntary: int

    @property
    def others(self) -> float:
        """Cores that other programs used at the same time."""
        return max(0.0, (sum(self.busy) - self.processor) / self.seconds)

    def __sub__(self, shorter: FilmTimes) -> FilmTimes:
        """Return the times of the additional frames; opening and closing cancel out."""
        pairs = zip(self.busy, shorter.busy, strict=True)
        return FilmTimes(
            self.frames - shorter.frames,
            self.seconds - shorter.seconds,
            self.processor - shorter.processor,
            tuple(one - other for one, other in pairs),
            self.voluntary - shorter.voluntary,
            self.involuntary - shorter.involuntary,
        )


def short_frames(frames: int) -> int:
    """Return the number of frames of the short film whose times are subtracted."""
    return int(SHORT_RATIO * frames)


def measure_film(job: FilmJob) -> FilmTimes:
    """Return the times of a film after a warm-up, without the times of opening and closing."""
    return FilmTimes(**_run_job(job))


def record_film(job: FilmJob, rounds: int) -> Recording:
    """Return the tasks of a film on the first of some cores: of several recordings, the fastest one."""
    on_one = replace(job, cores=job.cores[:1], records=True)
    return min((Recording(**_run_job(on_one)) for _ in range(rounds)), key=lambda each: each.seconds)


def _run_job(job: FilmJob) -> dict[str, Any]:
    command = [sys.executable, "-m", "tools.replay.film_job", json.dumps(asdict(job))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])  # type: ignore[no-any-return]


def _run(job: FilmJob) -> dict[str, Any]:
    os.sched_setaffinity(0, job.cores)  # before the program counts them
    from vidstyle.media.options import ReadOptions, WriteOptions
    from vidstyle.pipeline.render import render

    read = ReadOptions(size=None if job.size is None else (job.size[0], job.size[1]))
    with tempfile.TemporaryDirectory() as folder:

        def run(frames: int) -> int:
            write = WriteOptions(preset="veryfast", crf=20, overwrite=True)
            target = f"{folder}/out.mp4"
            done = render(job.clip, target, job.style, read=read, write=write, device="cpu", frames=frames)
            return done.frames

        if job.records:
            with recording(job.large_bands) as made:
                run(WARM_UP_FRAMES)
                made.clear()
                run(job.frames)
            return vars(made)
        run(WARM_UP_FRAMES)
        film = _timed(run, job.frames, job.cores)
        return asdict(film - _timed(run, short_frames(film.frames), job.cores))


def _timed(run: Callable[[int], int], frames: int, cores: Sequence[int]) -> FilmTimes:
    """Return the times of a film of at most this number of frames."""
    before, processor = resource.getrusage(resource.RUSAGE_SELF), _processor_seconds()
    idle, began = _idle_seconds(cores), time.perf_counter()
    rendered = run(frames)
    seconds, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_SELF)
    return FilmTimes(
        rendered,
        seconds,
        _processor_seconds() - processor,
        tuple(seconds - new + old for new, old in zip(_idle_seconds(cores), idle, strict=True)),
        after.ru_nvcsw - before.ru_nvcsw,
        after.ru_nivcsw - before.ru_nivcsw,
    )


def _processor_seconds() -> float:
    """Return the processor time of this process and of its ended processes."""
    own, ended = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + ended.ru_utime + ended.ru_stime


def _idle_seconds(cores: Sequence[int]) -> list[float]:
    """Return the idle time of each core since the start of the machine."""
    lines = (line.split() for line in Path("/proc/stat").read_text(encoding="ascii").splitlines())
    times = {line[0]: [*map(int, line[4:6])] for line in lines if line and line[0].startswith("cpu")}
    return [sum(times[f"cpu{core}"]) / os.sysconf("SC_CLK_TCK") for core in cores]


if __name__ == "__main__":
    print(json.dumps(_run(FilmJob(**json.loads(sys.argv[1])))))
