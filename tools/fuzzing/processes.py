"""Runs the program in a process of its own, or in this one, and watches what it takes and how it ends."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

import psutil

from tools.fuzzing import ROOT
from vidstyle import cli
from vidstyle.core.machine.cores import available_cores

SECONDS = 20.0
"""Of a processor: a case that takes longer is considered a hang."""
CLOCK_RATIO = 10
"""A case may take this many times as long by the clock, times the number of processes that share a core."""
MAX_MEMORY = 2**30
"""Bytes of RAM that a case may take in addition to what its process had before."""


class BrokenPromiseError(Exception):
    """What a run did that it must not do."""


class Ended(NamedTuple):
    """How a run ended."""

    exit_code: int
    lines: list[str]
    output: str


def answers(process: psutil.Process, has_answered: Callable[[float], bool], seconds: float = SECONDS) -> bool:
    """Wait until a process has answered, for at most so many seconds of a processor.

    Args:
        process: which counts.
        has_answered: waits up to a number of seconds, and returns whether the answer is there.
        seconds: of a processor; by the clock it may be `CLOCK_RATIO` times as many, more on a busy machine.
    """
    begin, limit = time.monotonic(), seconds + sum(process.cpu_times()[:2])
    while time.monotonic() < begin + _patience(seconds) and sum(process.cpu_times()[:2]) < limit:
        if has_answered(0.5):
            return True
    return False


def _patience(seconds: float) -> float:
    """Return the time by the clock in which a process gets so many seconds of a processor, at least."""
    return CLOCK_RATIO * seconds * max(1.0, psutil.getloadavg()[0] / available_cores())


def memory(field: str, process: int | str = "self") -> int:
    """A line of the status of a process, such as "VmRSS", in bytes; 0 once it has ended."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next((int(line.split()[1]) << 10 for line in lines if line.startswith(field)), 0)


def run_apart(arguments: Sequence[str | Path], **variables: str) -> Ended:
    """Run Python with these arguments and environment variables in a process of its own.

    Raises:
        BrokenPromiseError: a signal ended it, it hangs or takes too much memory.
    """
    with psutil.Popen(
        [sys.executable, *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | variables,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        said: list[bytes] = []
        highest = 0

        def has_ended(seconds: float) -> bool:
            nonlocal highest
            highest = max(highest, memory("VmHWM", process.pid))
            try:
                said[:] = process.communicate(timeout=min(seconds, 0.1))
            except subprocess.TimeoutExpired:
                return False
            return True

        if not answers(process, has_ended, SECONDS / 2):
            for each in [*process.children(recursive=True), process]:
                each.kill()
            raise BrokenPromiseError("hang")
    if process.returncode < 0:
        raise BrokenPromiseError(f"signal {-process.returncode}")
    if highest > memory("VmRSS") + MAX_MEMORY:
        raise BrokenPromiseError(f"memory: {highest >> 20} MiB")
    output, errors = (text.decode(errors="replace") for text in said)
    return Ended(process.returncode, errors.splitlines(), output)


def run_here(arguments: Sequence[str | Path]) -> Ended:
    """Run the program in this process."""
    streams = [io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2)]
    with redirect_stderr(streams[0]), redirect_stdout(streams[1]):
        exit_code = cli.main([str(each) for each in arguments])
    errors, output = (stream.buffer.getvalue().decode() for stream in streams)
    return Ended(exit_code, errors.splitlines(), output)
