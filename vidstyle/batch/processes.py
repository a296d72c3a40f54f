"""Starts the processes of a batch, and reads their events."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Protocol

from vidstyle.batch.resources import Room, local_room

END_SECONDS = 10.0
"""Time limit for a process to end before it is killed."""

Event = Mapping[str, Any]


@dataclass(frozen=True)
class Outcome:
    """The outcome of a process.

    Attributes:
        exit_code: as in a shell: 128 plus the signal number if a signal ended it.
        error: its error message, in one line.
        summary: its summary event.
    """

    exit_code: int
    error: str
    summary: Event


class Executor(Protocol):
    """Runs processes of `vidstyle`, here or on other machines.

    Attributes:
        room: what the processes share.
        is_stopped: whether it starts no more.
    """

    room: Room
    is_stopped: bool

    def run(self, words: Sequence[str], on_event: Callable[[Event], None], cores: int = 1) -> Outcome:
        """Run `vidstyle` with these arguments to its end; may be called from several threads.

        Args:
            words: a command and its options, without --progress.
            on_event: called with each event of --progress json.
            cores: number of cores that the process takes.
        """

    def stop(self) -> None:
        """Tell all processes to close their files and end, and start no more."""


class Processes:
    """Processes on this machine, which end when this process ends; see `Executor`."""

    def __init__(self, folder: str | None = None) -> None:
        """Start none; `folder`: where the processes run, this one's by default."""
        self._lock, self._folder = threading.Lock(), folder
        self._running: set[subprocess.Popen[str]] = set()
        self.room, self.is_stopped = local_room(), False

    def run(self, words: Sequence[str], on_event: Callable[[Event], None], cores: int = 1) -> Outcome:
        """See Executor."""
        with self._lock:
            if self.is_stopped:
                return Outcome(128 + signal.SIGTERM, "stopped", {})
            process = _start([*words, "--progress=json"], self._folder)
            self._running.add(process)
        try:
            return self._follow(process, on_event)
        finally:
            with self._lock:
                self._running.discard(process)

    def stop(self) -> None:
        """See Executor."""
        with self._lock:
            self.is_stopped = True
            running = list(self._running)
        for process in running:
            assert process.stdin is not None
            with suppress(OSError):
                process.stdin.close()
        for process in running:
            with suppress(subprocess.TimeoutExpired):
                process.wait(END_SECONDS)
            process.kill()

    def _follow(self, process: subprocess.Popen[str], on_event: Callable[[Event], None]) -> Outcome:
        assert process.stderr is not None and process.stdin is not None
        error, summary = "", {}
        for line in process.stderr:
            event = _parsed(line)
            on_event(event)
            if event["event"] == "error":
                error = event["text"]
            elif event["event"] == "summary":
                summary = dict(event)
        code = process.wait()
        process.stderr.close()
        with suppress(OSError):
            process.stdin.close()
        if code < 0:
            error, code = f"its process was ended by {signal.Signals(-code).name}", 128 - code
        return Outcome(code, error, summary)


def _start(words: Sequence[str], folder: str | None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "vidstyle.batch.worker", "--config=none", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        cwd=folder,
        # Ctrl-C in the terminal is sent only to the batch, which then ends its processes.
        start_new_session=True,
    )


def _parsed(line: str) -> Event:
    """Parse the event in a line; other text, such as output of a library, becomes a notice."""
    try:
        event = json.loads(line)
    except ValueError:
        event = None
    return (
        event if isinstance(event, dict) and "event" in event else {"event": "output", "text": line.strip()}
    )
