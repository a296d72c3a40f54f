"""Three threads from a source to a target: one reads, one restyles, one writes.

All three release Python's lock in their heavy work, so they run side by side. The calling thread only
monitors them, which keeps it free for signals and progress.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from typing import Any

from vidstyle.errors import OutputError
from vidstyle.media.frame import Frame
from vidstyle.media.write.base import Writer
from vidstyle.pipeline.bounded_queue import BoundedQueue, QueueClosedError

MAX_QUEUED_BATCHES = 3
"""Batches in the queue between two stages: enough that no stage starves, few enough to bound memory."""
MAX_BATCH_ITEMS = 32
"""Items in a batch at most. A batch ends with its frame, so that a run of packets does not fill a queue."""
WATCH_SECONDS = 0.1
"""Interval at which the calling thread reports progress."""
END_SECONDS = 2.0
"""Timeout for the threads to end after cancellation (docs/rules.md, Exit codes)."""

Batch = list[Any]
"""Frames and packets in the order of the source."""


class Stages:
    """One render job; `run` runs it to its end.

    Args:
        items: frames and packets in the order of the source.
        restyle: starts to restyle a frame; the function that it returns waits for the result.
        writer: receives all results and packets.
        frames_in_flight: returns the number of frames to start before waiting for the first result.
        cancel: called at an early end; pending results then raise CancelledError.

    Attributes:
        frames: number of frames passed to the writer.
        start, end: when the first of them begins and the last of them ends, in seconds of the source.
        finished: whether the target was written to its end.
        partial: the file that an unfinished job leaves, or None.
    """

    def __init__(
        self,
        items: Iterable[Any],
        restyle: Callable[[Frame], Callable[[], Frame]],
        writer: Writer,
        frames_in_flight: Callable[[], int],
        cancel: Callable[[], None],
    ) -> None:
        self._items = items
        self._restyle = restyle
        self._frames_in_flight, self._cancel = frames_in_flight, cancel
        self._writer = writer
        self._source: BoundedQueue[Batch] = BoundedQueue(MAX_QUEUED_BATCHES)
        self._result: BoundedQueue[Batch] = BoundedQueue(MAX_QUEUED_BATCHES)
        self._halted = threading.Event()
        self._over = threading.Event()
        self._error: BaseException | None = None
        self._threads = [
            # Daemons, so that a read that never returns cannot keep the program alive.
            threading.Thread(target=self._guard, args=(stage,), name=f"vidstyle {name}", daemon=True)
            for name, stage in (("read", self._read), ("style", self._style), ("write", self._write))
        ]
        self.frames = 0
        self.start = self.end = 0.0
        self.finished = False
        self.partial = writer.partial

    @property
    def alive(self) -> list[str]:
        """The names of the threads that have not ended; their data must not be released."""
        return [thread.name for thread in self._threads if thread.is_alive()]

    def run(self, stop: threading.Event, watch: Callable[[], None]) -> None:
        """Run until everything is written, a stage fails, or `stop` is set.

        An early end keeps what the encoder has, closes the target and waits for the threads, 2 s at most.

        Args:
            watch: called about ten times a second from this thread.

        Raises:
            what a stage raised, with a note that names the partial file.
        """
        for thread in self._threads:
            thread.start()
        try:
            while not self._over.wait(WATCH_SECONDS) and not stop.is_set():
                watch()
        except BaseException as error:  # any exception in the caller's loop, also Ctrl-C, ends the threads
            self._fail(error)
        self._end()
        if self._error is not None:
            raise self._error

    def _end(self) -> None:
        if not self._over.is_set():
            self._halt()
        deadline = time.monotonic() + END_SECONDS
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))
        if self._error is not None and self.partial is not None and not isinstance(self._error, OutputError):
            # Errors of the writer already name it.
            self._error.add_note(f"{self.partial} keeps the finished part")

    def _guard(self, stage: Callable[[], None]) -> None:
        try:
            stage()
        except (QueueClosedError, CancelledError):
            pass
        except BaseException as error:  # a thread's error is raised again in the calling thread
            self._fail(error)

    def _fail(self, error: BaseException) -> None:
        if self._error is None:
            self._error = error
        self._halt()
        self._over.set()

    def _halt(self) -> None:
        """Pass no more frames to the encoder: closing the file in time is worth more than a few frames."""
        self._halted.set()
        self._source.close(discard=True)
        self._result.close(discard=True)
        self._cancel()

    def _read(self) -> None:
        for batch in batches(self._items):
            self._source.put(batch)
        self._source.close()

    def _style(self) -> None:
        waiting: deque[Batch] = deque()
        for batch in self._source:
            waiting.append([self._restyle(item) if isinstance(item, Frame) else item for item in batch])
            while sum(_is_pending(each) for each in waiting) > self._frames_in_flight():
                self._finish(waiting.popleft())
        for batch in waiting:
            self._finish(batch)
        self._result.close()

    def _finish(self, batch: Batch) -> None:
        """Wait until the frame of the batch is restyled, and pass the batch on."""
        self._result.put([*batch[:-1], batch[-1]()] if _is_pending(batch) else batch)

    def _write(self) -> None:
        try:
            for batch in self._result:
                for item in batch:
                    self._writer.write(item)
                    if isinstance(item, Frame):
                        self._count(item)
            if not self._halted.is_set():
                self._writer.finish()
                self.finished, self.partial = True, None
        finally:
            if not self.finished:
                self._halt()
                self.partial = self._writer.abandon()
            self._over.set()

    def _count(self, frame: Frame) -> None:
        begin = float(frame.time)
        self.start = begin if self.frames == 0 else self.start
        self.end = begin + float((frame.duration or 0) * frame.time_base)
        self.frames += 1


def _is_pending(batch: Batch) -> bool:
    return callable(batch[-1])


def batches(items: Iterable[Any]) -> Iterator[Batch]:
    """Yield the items in batches that end with a frame, or are full.

    >>> [len(batch) for batch in batches(range(40))]
    [32, 8]
    """
    batch: Batch = []
    for item in items:
        batch.append(item)
        if isinstance(item, Frame) or len(batch) == MAX_BATCH_ITEMS:
            yield batch
            batch = []
    if batch:
        yield batch
