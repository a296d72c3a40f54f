"""A queue between two threads that keeps the newest items."""

from __future__ import annotations

import threading
from collections import deque
from typing import Generic, TypeVar

from vidstyle.media.capture.monotonic import MONOTONIC, Clock

T = TypeVar("T")


class DropOldestQueue(Generic[T]):
    """A bounded queue; when it is full, the oldest item is dropped for a new one.

    Attributes:
        dropped: number of items that were dropped.

    >>> queue = DropOldestQueue[int]()
    >>> queue.put(1), queue.put(2)
    (None, None)
    >>> queue.get(), queue.dropped
    (2, 1)
    """

    def __init__(self, capacity: int = 1, clock: Clock = MONOTONIC) -> None:
        """`capacity`: number of items that may wait; 1 gives the least latency."""
        self._items: deque[T] = deque(maxlen=capacity)
        self._clock = clock
        self._closed = False
        self._changed = threading.Condition()
        self.dropped = 0

    def put(self, item: T) -> None:
        """Add an item; does nothing after `close`."""
        with self._changed:
            if self._closed:
                return
            self.dropped += len(self._items) == self._items.maxlen
            self._items.append(item)
            self._changed.notify()

    def get(self, timeout: float | None = None) -> T | None:
        """Remove and return the oldest item; None after `timeout` seconds, or when the queue is exhausted."""
        with self._changed:
            self._clock.wait_for(self._changed, lambda: self._closed or bool(self._items), timeout)
            return self._items.popleft() if self._items else None

    def close(self) -> None:
        """Accept no more items; those that wait can still be fetched."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def exhausted(self) -> bool:
        """Whether the queue is closed and empty."""
        with self._changed:
            return self._closed and not self._items
