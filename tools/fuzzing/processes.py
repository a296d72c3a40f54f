"""Run the program in a separate process or in this one, and check its time, memory and end."""

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

MAX_PROCESSOR_SECONDS = 20.0
"""Processor time of a case; longer ones count as hangs."""
CLOCK_RATIO = 10
"""Limit of wall-clock time relative to processor time, per process that shares a core."""
MAX_MEMORY_BYTES = 2**30
"""RAM that a case may use in addition to the previous use of its process."""


class BrokenPromiseError(Exception):
    """The program violated a promise of docs/rules.md or docs/reliability.md."""


class Ended(NamedTuple):
    """A finished run: exit code, lines on standard error, and standard output."""

    exit_code: int
    lines: list[str]
    output: str


def wait_for_answer(
    process: psutil.Process, has_answered: Callable[[float], bool], seconds: float = MAX_PROCESSOR_SECONDS
) -> bool:
    """Wait until a process has answered, and return whether it did.

    Args:
        process: the process whose processor time is limited.
        has_answered: waits up to a number of seconds, and returns whether the answer has arrived.
        seconds: limit of processor time; wall-clock time may be `CLOCK_RATIO` times as long, longer on a busy
            machine.
    """
    begin, limit = time.monotonic(), seconds + sum(process.cpu_times()[:2])
    while time.monotonic() < begin + _clock_limit(seconds) and sum(process.cpu_times()[:2]) < limit:
        if has_answered(0.5):
            return True
    return False


def _clock_limit(seconds: float) -> float:
    """Return the wall-clock time in which a process surely gets a number of seconds of processor time."""
    return CLOCK_RATIO * seconds * max(1.0, psutil.getloadavg()[0] / available_cores())


def memory_bytes(field: str, process: int | str = "self") -> int:
    """Return a field of the status of a process, such as "VmRSS", in bytes; 0 after its end."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next((int(line.split()[1]) << 10 for line in lines if line.startswith(field)), 0)


def run_apart(arguments: Sequence[str | Path], **variables: str) -> Ended:
    """Run Python with these arguments and environment variables in a separate process.

    Raises:
        BrokenPromiseError: the process is ended by a signal, hangs or uses too much memory.
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
            highest = max(highest, memory_bytes("VmHWM", process.pid))
            try:
                said[:] = process.communicate(timeout=min(seconds, 0.1))
            except subprocess.TimeoutExpired:
                return False
            return True

        if not wait_for_answer(process, has_ended, MAX_PROCESSOR_SECONDS / 2):
            for each in [*process.children(recursive=True), process]:
                each.kill()
            raise BrokenPromiseError("hang")
    if process.returncode < 0:
        raise BrokenPromiseError(f"signal {-process.returncode}")
    if highest > memory_bytes("VmRSS") + MAX_MEMORY_BYTES:
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
