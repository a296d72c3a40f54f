"""Bands of rows that stay in a core's cache, on all cores."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from typing import Any

from vidstyle.core.cores import available_cores

BAND_BYTES = 1 << 21
"""Approximate size of a band's largest value: fits a second-level cache; smaller ones mean more calls."""


@cache
def shared_pool() -> Executor:
    """Return the default pool, one thread per core, started on first use."""
    return threads_for(available_cores() - 1, "vidstyle-bands")


@cache
def keep_freed_memory() -> None:
    """Have the C library keep the memory of planes and bands for the next frame.

    By default glibc returns most of it to the system after each frame, which then clears every page again: up
    to a tenth of a frame's time. Other C libraries are not changed.
    """
    trim_threshold, top_pad, mmap_threshold = -1, -2, -3  # malloc.h
    with suppress(TypeError, AttributeError):
        set_option = ctypes.CDLL(None).mallopt
        set_option(mmap_threshold, 32 << 20)  # the most that it takes
        set_option(trim_threshold, 256 << 20)
        set_option(top_pad, 64 << 20)  # the size of a thread's heap: smaller values return empty heaps


class CallingThread(Executor):
    """An executor that runs each task immediately, in the calling thread."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Run the function and return a completed future."""
        future: Future[Any] = Future()
        future.set_result(function(*arguments, **named))
        return future


def threads_for(threads: int, name: str) -> Executor:
    """Return a pool of `threads` threads; for one, run tasks in the calling thread."""
    return ThreadPoolExecutor(threads, thread_name_prefix=name) if threads > 1 else CallingThread()


def in_bands(
    pool: Executor, shape: tuple[int, int], radius: int, run: Callable[[int, int], None], channels: int = 3
) -> None:
    """Call `run(top, bottom)` for bands that cover all rows, on all cores.

    Bands begin at multiples of four rows, which every chroma step divides.

    Args:
        radius: rows that are read around each band.
        channels: float32 numbers of a pixel in the largest value of a band.
    """
    (height, width), cores = shape, available_cores()
    count = -(-height // max(BAND_BYTES // (4 * channels * width), 8 * radius, 1))
    count = -(-count // cores) * cores  # the same number for each core
    rows = -(-height // (4 * count)) * 4
    tops = iter(range(0, height, rows))

    def work() -> None:
        # Each thread takes the next one: a task for each band would cost as much as some bands.
        for top in tops:
            run(top, min(top + rows, height))

    others = [pool.submit(work) for _ in range(min(cores, -(-height // rows)) - 1)]
    try:
        work()
    finally:
        for other in others:
            if not other.cancel():  # it has begun
                other.result()
