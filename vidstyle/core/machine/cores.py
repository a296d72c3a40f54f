"""The number of threads to compute with: processor cores that this process may use."""

from __future__ import annotations

import math
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from vidstyle.core.machine.control_groups import group_folders, read_text
from vidstyle.errors import UsageError

THREADS_VARIABLE = "VIDSTYLE_THREADS"
"""The environment variable that overrides the number."""
MAX_THREADS = 1024


@dataclass(frozen=True)
class CoreCount:
    """A number of cores and the reason for it; the text is as in "4 of 64: CPU affinity".

    Attributes:
        number: of threads to use, 1 or more.
        reason: what decides it.
        machine: cores of the machine.
    """

    number: int
    reason: str
    machine: int

    def __str__(self) -> str:
        of_machine = f" of {self.machine}" if self.number < self.machine else ""
        return f"{self.number}{of_machine}: {self.reason}"


_from_option: int | None = None


def available_cores() -> int:
    """Return the number of threads to use, 1 or more. Read it when you need it: --threads changes it.

    Raises:
        UsageError: VIDSTYLE_THREADS is not a number of threads.
    """
    return core_count().number


def core_count() -> CoreCount:
    """Return the number of threads: --threads, else VIDSTYLE_THREADS, else the cores of this process.

    Raises:
        UsageError: VIDSTYLE_THREADS is not a number of threads.
    """
    found = process_cores()
    if _from_option is not None:
        return CoreCount(_from_option, "--threads", found.machine)
    if text := os.environ.get(THREADS_VARIABLE):
        return CoreCount(_parse_threads(text), THREADS_VARIABLE, found.machine)
    return found


def imposed_threads() -> int:
    """Threads for libraries that respect CPU affinity themselves, such as FFmpeg and OpenCV.

    Returns 0, which lets them choose, unless a quota or the user sets another number than affinity.
    """
    number = available_cores()
    return 0 if number == _affinity() else number


@contextmanager
def use_threads(number: int) -> Iterator[None]:
    """Use this number of threads within the block, as --threads asks for; child processes inherit it."""
    global _from_option
    before, _from_option = _from_option, number
    try:
        with _environment(THREADS_VARIABLE, str(number)):
            yield
    finally:
        _from_option = before


@contextmanager
def limit_opencv() -> Iterator[None]:
    """Have OpenCV, which knows neither --threads nor VIDSTYLE_THREADS, use `imposed_threads`."""
    number, cv2 = imposed_threads(), sys.modules.get("cv2")
    if not number:
        yield
    elif cv2 is None:  # it reads the variable when it is imported; child processes inherit it
        with _environment("OPENCV_FOR_THREADS_NUM", str(number)):
            yield
    else:
        before = cv2.getNumThreads()
        cv2.setNumThreads(number)
        try:
            yield
        finally:
            cv2.setNumThreads(before)


_opencv_lock = threading.Lock()
_opencv_blocks = 0
_opencv_before = 0


@contextmanager
def single_threaded_opencv() -> Iterator[None]:
    """Have OpenCV use only the calling thread, until the last of concurrent blocks ends.

    Its pool keeps cores busy while it waits, which delays threads that each compute a frame.
    """
    global _opencv_blocks, _opencv_before
    import cv2

    with _opencv_lock:
        if not _opencv_blocks:
            _opencv_before = cv2.getNumThreads()
            cv2.setNumThreads(1)
        _opencv_blocks += 1
    try:
        yield
    finally:
        with _opencv_lock:
            _opencv_blocks -= 1
            if not _opencv_blocks:
                cv2.setNumThreads(_opencv_before)


@cache
def process_cores() -> CoreCount:
    """Return the cores that the system lets this process use: CPU affinity, limited by the cgroup's quota."""
    return limited_cores(os.cpu_count() or 1, _affinity(), cgroup_quota())


def limited_cores(machine: int, affinity: int, quota: float | None) -> CoreCount:
    """Return the smallest of the three; a quota is in cores, rounded up, and None if there is none."""
    if quota is not None and math.ceil(quota) < affinity:
        return CoreCount(max(1, math.ceil(quota)), "cgroup quota", machine)
    return CoreCount(affinity, "CPU affinity" if affinity < machine else "all cores", machine)


def cgroup_quota(root: Path = Path("/")) -> float | None:
    """Return the CPU time per second, in cores, that the control groups allow (cgroup v1 and v2).

    Each group from the one of the process up to the root may set a limit; the lowest one counts. Missing
    or malformed files set none.

    Args:
        root: folder with `proc` and `sys`.
    """
    limits = [_limit(folder) for folder in group_folders(root, "cpu")]
    return min((limit for limit in limits if limit is not None), default=None)


@cache
def _affinity() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        del os.environ[name]
        if before is not None:
            os.environ[name] = before


def _parse_threads(text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if not 1 <= number <= MAX_THREADS:
        reason = f"{text!r} is not a number of threads from 1 to {MAX_THREADS}"
        raise UsageError(THREADS_VARIABLE, reason, "correct it, or unset it to use all available cores")
    return number


def _limit(folder: Path) -> float | None:
    """Return the quota of one control group, in cores."""
    words = read_text(folder / "cpu.max").split()
    words = words or [read_text(folder / f"cpu.cfs_{name}_us").strip() for name in ("quota", "period")]
    try:
        quota, period = (int(word) for word in words)
    except ValueError:  # "max", or no such file
        return None
    return quota / period if quota > 0 and period > 0 else None
