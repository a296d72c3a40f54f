"""A bounded queue between two threads, which gives back-pressure."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class QueueClosedError(Exception):
    """The queue was closed; the producer can end."""


class BoundedQueue(Generic[T]):
    """A first-in, first-out queue; `put` waits while it holds `capacity` items.

    >>> queue = BoundedQueue[int](capacity=2)
    >>> queue.put(1)
    >>> queue.close()
    >>> list(queue)
    [1]
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._items: deque[T] = deque()
        self._closed = False
        self._changed = threading.Condition()

    def put(self, item: T) -> None:
        """Add an item; waits while the queue is full.

        Raises:
            QueueClosedError: the queue was closed, before or while waiting.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._closed or len(self._items) < self._capacity)
            if self._closed:
                raise QueueClosedError
            self._items.append(item)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[T]:
        """Take items as they come, until the queue is closed and empty."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or bool(self._items))
                if not self._items:
                    return
                item = self._items.popleft()
                self._changed.notify_all()
            yield item
            # A picture would otherwise stay in memory for as long as the next one takes to come.
            del item

    def close(self, discard: bool = False) -> None:
        """Accept no more items; those in the queue are still delivered unless `discard` is set."""
        with self._changed:
            self._closed = True
            if discard:
                self._items.clear()
            self._changed.notify_all()
