"""Other commands of the program, each in a separate process."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import IO

from vidstyle.core.closing import Closing
from vidstyle.errors import UsageError

_ADDRESS = re.compile(r"http://[\d.]+:\d+/\?token=\S+")
_PROGRESS = re.compile(r"vidstyle: (?P<percent>\d+)%, (?P<step>[^,]+)(?P<left>, \S+ left)?$")
"""A line of plain progress of a command of several steps."""
_TERMINATED_CODES = (143, -15)
"""Exit codes of a process that was asked to end: of this program, and before it handles the signal."""
CLOSE_SECONDS = 5.0
"""Time limit for a process to end after it was asked to."""


class ChildPages(Closing):
    """Starts commands, most of which serve a page, and ends them with this program."""

    def __init__(self) -> None:
        self._processes: list[subprocess.Popen[str]] = []
        self._runs: list[subprocess.Popen[str]] = []

    def open(self, arguments: Sequence[str]) -> str:
        """Start a command; return the address of its page.

        Raises:
            UsageError: the command ended without a page; the message is its last line.
        """
        _, errors = self._start([*arguments, "--no-open"])
        lines: deque[str] = deque(maxlen=1)
        for line in errors:
            lines.append(line)
            if found := _ADDRESS.search(line):
                threading.Thread(target=_drain, args=(errors,), daemon=True).start()
                return found[0]
        raise _failure(arguments, lines)

    def run(self, arguments: Sequence[str], report: Callable[[str], None]) -> None:
        """Run a command to its end.

        Args:
            arguments: of the command.
            report: called with the progress in words, such as "Drawing: 33 %, 0:04 left".

        Raises:
            UsageError: the command failed, and the message is its last line; or it was cancelled.
        """
        process, errors = self._start(arguments)
        self._runs.append(process)
        lines = deque(report_progress(errors, report), maxlen=1)
        code = process.wait()
        self._runs.remove(process)
        if code in _TERMINATED_CODES:
            raise UsageError(f"vidstyle {arguments[0]}", "cancelled")
        if code:
            raise _failure(arguments, lines)

    def cancel(self) -> None:
        """End the commands of `run`."""
        for process in list(self._runs):
            process.terminate()

    def _start(self, arguments: Sequence[str]) -> tuple[subprocess.Popen[str], IO[str]]:
        command = [sys.executable, "-m", "vidstyle", *arguments]
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        self._processes.append(process)
        assert process.stderr is not None
        return process, process.stderr

    def close(self) -> None:
        """End all processes."""
        for process in self._processes:
            process.terminate()
        for process in self._processes:
            try:
                process.wait(CLOSE_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
            if process.stderr is not None:
                process.stderr.close()


def report_progress(lines: Iterable[str], report: Callable[[str], None]) -> Iterator[str]:
    """Yield the lines of a command; report the lines of progress."""
    for line in lines:
        if found := _PROGRESS.match(line):
            report(f"{found['step'].capitalize()}: {found['percent']} %{found['left'] or ''}")
        yield line


def _failure(arguments: Sequence[str], lines: Sequence[str]) -> UsageError:
    reason = lines[-1].strip().removeprefix("vidstyle: ") if lines else "ended without a result"
    return UsageError(f"vidstyle {arguments[0]}", reason)


def _drain(stream: IO[str]) -> None:
    """Read a stream to its end, so that its writer never waits."""
    try:
        for _ in stream:
            pass
    except ValueError:  # closed
        return
