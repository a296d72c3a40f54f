"""A film of a batch: its source, target and progress."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vidstyle.batch.inputs import Source
    from vidstyle.batch.journal import Journal
    from vidstyle.batch.stored_path import FilmPath


class State(StrEnum):
    """The state of a film."""

    WAITING = "waiting"
    READING = "reading"
    RUNNING = "running"
    ELSEWHERE = "elsewhere"
    DONE = "done"
    SKIPPED = "skipped"
    FAILED = "failed"
    STOPPED = "stopped"


ENDED = frozenset({State.DONE, State.SKIPPED, State.FAILED, State.STOPPED})


@dataclass
class BatchFilm:
    """A film to render, and its progress, which other threads may read.

    Attributes:
        source: the film to restyle.
        style: name of a style, a style file, several with commas, or a cue file; the value of `option`.
        target: the result.
        settings: everything that determines the result, except the source; see `setting_parts`.
        journal: journal of the target's folder.
        state: its state; `running` while a process renders it, `elsewhere` while another batch does.
        reason: reason why it failed or is skipped, or the damage of its source.
        exit_code: exit code of its last process; 0 before that.
        frames, fps, fraction, remaining: its progress; the last two may be unknown.
        seconds: time for which its processes have run.
        attempts: number of attempts.
        option: option of `render` that takes `style`.
    """

    source: Source
    style: str
    target: FilmPath
    settings: Mapping[str, str]
    journal: Journal
    state: State = State.WAITING
    reason: str = ""
    exit_code: int = 0
    frames: int = 0
    fps: float = 0.0
    fraction: float | None = None
    remaining: float | None = None
    seconds: float = 0.0
    attempts: int = 0
    option: str = "--style"
    _began: float = field(default=0.0, repr=False)

    @property
    def has_ended(self) -> bool:
        """Whether the state is final."""
        return self.state in ENDED

    @cached_property
    def source_bytes(self) -> int:
        """Size of the source; 0 if it cannot be read or is in storage, as each film would need a request."""
        try:
            return self.source.path.stat().st_size if isinstance(self.source.path, Path) else 0
        except OSError:
            return 0

    def begin(self) -> None:
        """Start the time of an attempt."""
        self.state, self.reason, self.exit_code = State.RUNNING, "", 0
        self.attempts += 1
        self._began = time.monotonic()

    def follow(self, event: Mapping[str, Any]) -> None:
        """Update the progress from an event of a process."""
        self.frames, self.fps = event.get("frames", self.frames), event.get("fps", self.fps)
        self.fraction, self.remaining = event.get("fraction"), event.get("eta")

    def end(self, state: State, reason: str = "", exit_code: int = 0) -> None:
        """Record the outcome of an attempt."""
        if self._began:
            self.seconds += time.monotonic() - self._began
        self.fps = self.fps or (self.frames / self.seconds if self.seconds else 0.0)
        self._began, self.fraction, self.remaining = 0.0, None, None
        self.state, self.reason, self.exit_code = state, reason, exit_code

    def as_dict(self) -> dict[str, Any]:
        """Return all values for JSON and CSV."""
        return {
            "source": str(self.source.path),
            "style": self.style,
            "target": str(self.target),
            "state": str(self.state),
            "frames": self.frames,
            "fps": round(self.fps, 2),
            "seconds": round(self.seconds, 3),
            "attempts": self.attempts,
            "exit_code": self.exit_code,
            "reason": self.reason,
        }
