"""The threads that restyle pictures on the CPU."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import ExitStack

from vidstyle.core.bands import MAX_SMALL_BAND_THREADS, BandWorkers, threads_for, useful_threads
from vidstyle.core.machine.cores import single_threaded_opencv
from vidstyle.core.picture import Picture


class FrameThreads:
    """A number of threads, each with another picture, or several with one picture, in bands.

    Args:
        count: number of threads.

    Attributes:
        count: see Args.
        side_by_side: number of pictures that are restyled at the same time.
        cancelled: if set, pictures end after their current bands.
    """

    def __init__(self, count: int) -> None:
        self.count = self.side_by_side = count
        self.cancelled = threading.Event()
        self._pool = self._frame_pool = threads_for(count, "vidstyle-cpu")
        self._settings = ExitStack()
        self._started: list[Future[Picture]] = []

    def share(self, pictures: int) -> None:
        """Restyle this number of pictures at the same time from now on."""
        self.side_by_side = pictures
        self._settings.close()
        self._frame_pool = self._pool
        if pictures < self.count:
            # A separate pool of few threads, as the C library keeps the memory of a frame for each thread.
            self._frame_pool = ThreadPoolExecutor(pictures, "vidstyle-frame")
            self._settings.enter_context(self._frame_pool)
        if pictures > 1:
            self._settings.enter_context(single_threaded_opencv())

    def workers(self, pictures: int, picture: Picture) -> BandWorkers:
        """Return the threads of a picture, one of some that are restyled at the same time."""
        threads = useful_threads(picture.shape, -(-self.count // pictures))
        return BandWorkers(self._pool, threads, self.cancelled, self.count <= MAX_SMALL_BAND_THREADS)

    def submit(self, restyle: Callable[[], Picture]) -> Future[Picture]:
        """Start to restyle a picture."""
        pending = self._frame_pool.submit(restyle)
        self._started = [*(each for each in self._started if not each.done()), pending]
        return pending

    def settle(self) -> None:
        """Wait for the started pictures, whose bands need threads."""
        wait(self._started)

    def close(self) -> None:
        """End the threads."""
        self._settings.close()
        self._pool.shutdown()
