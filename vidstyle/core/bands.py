"""Bands of rows that stay in a core's cache, on all cores."""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from vidstyle.core.machine.cores import available_cores

BAND_BYTES = 1 << 21
"""Approximate size of a band's largest value: fits a second-level cache; smaller ones mean more calls."""
LONE_BAND_FACTOR = 2
"""Bands of a picture with one thread are larger by this factor, if more than two threads have a picture each:
then they wait for Python's lock less often. With 8, four threads take 60 MB more at 1920x1080; `ink` and
`comic` are predicted as fast on four cores, and 3 % faster on six."""
MAX_SMALL_BAND_THREADS = 2
"""Number of threads up to which small bands are faster: `comic` takes 3 to 8 % and `paint` 3 to 12 % less
processor time on two cores."""
MAX_MEGAPIXEL_THREADS = 3
"""How many threads share a picture of a megapixel at most; the number grows with the square root of the size.
Each thread adds 2 to 3 ms to a picture, as all of them wait for Python's lock. On 16 cores, `ink`, `comic`
and `paint` are fastest with 3 to 6 threads at 1280x720 and 4 at 1920x1080; 16 threads take twice as long."""


@dataclass(frozen=True)
class BandWorkers:
    """Threads that compute the bands of a picture: the calling thread, and others of a pool.

    Attributes:
        pool: the other threads.
        count: number of threads, 1 or more.
        cancelled: if set, the calling thread computes no further band.
        seldom_waits: whether at most one other thread of the process restyles pictures.
    """

    pool: Executor
    count: int
    cancelled: threading.Event = field(default_factory=threading.Event)
    seldom_waits: bool = False


@cache
def shared_workers() -> BandWorkers:
    """Return the default workers, one thread per core, started on first use."""
    return BandWorkers(threads_for(available_cores() - 1, "vidstyle-bands"), available_cores())


@cache
def keep_freed_memory() -> None:
    """Have the C library keep the memory of planes and bands for the next frame.

    By default glibc returns most of it to the system after each frame, which then clears every page again: up
    to a tenth of a frame's time. All threads share one heap: with one each, a thread could not use what
    another has freed, and four threads take 85 MB more at 1920x1080. Other C libraries are not changed.
    """
    trim_threshold, top_pad, mmap_threshold, arena_max = -1, -2, -3, -8  # malloc.h
    with suppress(TypeError, AttributeError):
        set_option = ctypes.CDLL(None).mallopt
        set_option(mmap_threshold, 32 << 20)  # the most that it takes
        set_option(trim_threshold, 256 << 20)
        set_option(top_pad, 64 << 20)
        set_option(arena_max, 1)


class CallingThread(Executor):
    """An executor that runs each task immediately, in the calling thread."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """Run the function and return a completed future."""
        future: Future[Any] = Future()
        future.set_result(function(*arguments, **named))
        return future


def useful_threads(shape: tuple[int, int], threads: int) -> int:
    """Return how many of `threads` should share a picture of this height and width.

    >>> [useful_threads(shape, 16) for shape in ((90, 160), (720, 1280), (1080, 1920), (2160, 3840))]
    [1, 3, 5, 9]
    """
    megapixels = shape[0] * shape[1] / 1e6
    return max(1, min(threads, math.ceil(MAX_MEGAPIXEL_THREADS * math.sqrt(megapixels))))


ONE_THREAD = BandWorkers(CallingThread(), 1)
"""The calling thread."""


def threads_for(threads: int, name: str) -> Executor:
    """Return a pool of `threads` threads; for one, run tasks in the calling thread."""
    return ThreadPoolExecutor(threads, thread_name_prefix=name) if threads > 1 else CallingThread()


def band_rows(workers: BandWorkers, shape: tuple[int, int], radius: int, channels: int) -> int:
    """Return the rows of a band, a multiple of four; see `in_bands` for the arguments."""
    height, width = shape
    has_lone_bands = workers.count == 1 and not workers.seldom_waits
    most_bytes = BAND_BYTES * (LONE_BAND_FACTOR if has_lone_bands else 1)
    count = -(-height // max(most_bytes // (4 * channels * width), 8 * radius, 1))
    count = -(-count // workers.count) * workers.count  # the same number for each thread
    return -(-height // (4 * count)) * 4


def in_bands(
    workers: BandWorkers,
    shape: tuple[int, int],
    radius: int,
    run: Callable[[int, int], None],
    channels: int = 3,
) -> None:
    """Call `run(top, bottom)` for bands that cover all rows, in all threads of `workers`.

    Bands begin at multiples of four rows, which every chroma step divides.

    Args:
        radius: rows that are read around each band.
        channels: float32 numbers of a pixel in the largest value of a band.

    Raises:
        CancelledError: the workers were cancelled.
    """
    height, rows = shape[0], band_rows(workers, shape, radius, channels)
    tops = iter(range(0, height, rows))

    def work() -> None:
        # Each thread takes the next one: a task for each band would cost as much as some bands.
        for top in tops:
            if workers.cancelled.is_set():
                raise CancelledError
            run(top, min(top + rows, height))

    others = [workers.pool.submit(work) for _ in range(min(workers.count, -(-height // rows)) - 1)]
    try:
        work()
    finally:
        for other in others:
            if not other.cancel():  # it has begun
                other.result()
