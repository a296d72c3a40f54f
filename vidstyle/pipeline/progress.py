"""Progress and summary of a job."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

ProgressCallback = Callable[[str, float, float], None]
"""Called with the name of a step, how many of its parts are done, and of how many; 0: not known."""


def ignore_progress(step: str, done: float, total: float) -> None:
    """The `ProgressCallback` of a job without progress report."""


@dataclass(frozen=True)
class Progress:
    """Progress of a job.

    Attributes:
        frames: frames handed to the encoder so far.
        position: their duration in seconds.
        elapsed: seconds since the job began.
        total_frames, duration: frames and seconds according to the input's headers; None if unknown.
        since: the progress just before the first frame was made by this run; rates count from there.
        step: the name of the current step, in a job of several steps; `position` counts its parts, `duration`
            is their number.
    """

    frames: int
    position: float
    elapsed: float
    total_frames: int | None = None
    duration: float | None = None
    since: Progress | None = None
    step: str = ""

    @property
    def rate(self) -> float:
        """Frames per second of work, since the first."""
        return self._pace(self.frames, self.since.frames if self.since else 0)

    @property
    def speed(self) -> float:
        """Seconds of film per second of work: 1 is as fast as it plays."""
        return self._pace(self.position, self.since.position if self.since else 0)

    def _pace(self, now: float, before: float) -> float:
        elapsed = self.elapsed - (self.since.elapsed if self.since else 0)
        return (now - before) / elapsed if elapsed > 0 else 0.0

    @property
    def fraction(self) -> float | None:
        """The fraction that is done, 0..1, or None if the total is unknown.

        >>> Progress(frames=50, position=2.0, elapsed=1.0, duration=8.0).fraction
        0.25
        """
        if self.duration:
            return min(self.position / self.duration, 1.0)
        return min(self.frames / self.total_frames, 1.0) if self.total_frames else None

    @property
    def remaining(self) -> float | None:
        """Seconds that the rest will take at this rate, if the whole is known.

        >>> Progress(6, 3.0, 5.0, duration=4.0, since=Progress(4, 2.0, 1.0)).remaining
        4.0
        """
        if self.duration:
            left, pace = self.duration - self.position, self.speed
        elif self.total_frames:
            left, pace = self.total_frames - self.frames, self.rate
        else:
            return None
        return max(left, 0) / pace if pace > 0 else None

    @property
    def pace_text(self) -> str:
        """Step, or rate and speed, and the time left: "12 fps, 0.5 x, 0:10 left"."""
        pace = self.step or f"{self.rate:.3g} fps, {self.speed:.2f} x"
        return pace if self.remaining is None else f"{pace}, {clock(self.remaining)} left"

    def as_dict(self) -> dict[str, Any]:
        """Everything in plain values, for JSON."""
        told = {
            "frames": self.frames,
            "position": round(self.position, 3),
            "elapsed": round(self.elapsed, 3),
            "fps": round(self.rate, 2),
            "speed": round(self.speed, 3),
            "fraction": None if self.fraction is None else round(self.fraction, 4),
            "eta": None if self.remaining is None else round(self.remaining, 1),
        }
        parts = ("elapsed", "fraction", "eta")
        return {"step": self.step} | {name: told[name] for name in parts} if self.step else told


class StepProgress:
    """Makes progress of calls with a step's name, how many of its parts are done, and of how many."""

    def __init__(self, show: Callable[[Progress], None]) -> None:
        self._show, self._began = show, time.monotonic()
        self._since = Progress(0, 0.0, 0.0)

    def __call__(self, step: str, done: float, total: float) -> None:
        """`total`: 0 where it is not known."""
        elapsed = time.monotonic() - self._began
        now = Progress(0, done, elapsed, duration=total or None, step=step)
        if step != self._since.step or not 0 < self._since.position <= done:
            self._since = now  # the first part takes longer: its kernels may have to be compiled
        self._show(replace(now, since=self._since))


def clock(seconds: float) -> str:
    """Return a duration as [hours:]minutes:seconds.

    >>> clock(3725)
    '1:02:05'
    """
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


@dataclass(frozen=True)
class Summary:
    """Result of a job.

    Attributes:
        source, target: as they were given.
        frames: frames written, and how many of them an earlier run had written: `kept`.
        duration: length of the film written, in seconds.
        elapsed: seconds of work.
        damage: description of the damage of the input in one line, or empty.
        exit_code: 0, or 4 if the input was significantly damaged.
        stopped: whether the job was stopped before its end.
        partial: the file with the frames that a stopped job had written, or None.
    """

    source: str
    target: str
    frames: int
    duration: float
    elapsed: float
    damage: str = ""
    exit_code: int = 0
    stopped: bool = False
    partial: Path | None = None
    kept: int = 0

    @property
    def rate(self) -> float:
        """Frames made per second of work."""
        return (self.frames - self.kept) / self.elapsed if self.elapsed > 0 else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Everything in plain values, for JSON."""
        return {
            "source": self.source,
            "target": self.target,
            "frames": self.frames,
            "kept": self.kept,
            "duration": round(self.duration, 6),
            "elapsed": round(self.elapsed, 3),
            "fps": round(self.rate, 2),
            "damage": self.damage,
            "exit_code": self.exit_code,
            "stopped": self.stopped,
            "partial": None if self.partial is None else str(self.partial),
        }
