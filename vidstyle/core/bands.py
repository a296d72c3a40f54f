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
    """The threads of everybody who has no pool of their own, one for each core; started when first used."""
    return threads_for(available_cores() - 1, "vidstyle-bands")


@cache
def keep_freed_memory() -> None:
    """Have the C library keep the memory of planes and bands for the next frame.

    By default glibc gives the larger part back to the system after each frame, which then clears every page
    of it anew: up to a tenth of a frame's time. Other C libraries are left as they are.
    """
    trim_threshold, top_pad, mmap_threshold = -1, -2, -3  # malloc.h
    with suppress(TypeError, AttributeError):
        set_option = ctypes.CDLL(None).mallopt
        set_option(mmap_threshold, 32 << 20)  # the most that it takes
        set_option(trim_threshold, 256 << 20)
        set_option(top_pad, 64 << 20)  # as much as a thread's heap has: else empty ones are given back


class CallingThread(Executor):
    """Runs what it is given at once, in the thread that gives it."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """A future that is done."""
        future: Future[Any] = Future()
        future.set_result(function(*arguments, **named))
        return future


def threads_for(threads: int, name: str) -> Executor:
    """So many threads, or just the calling one."""
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
    count = -(-count // cores) * cores  # as many for each core
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
