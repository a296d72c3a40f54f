"""Hands the newest things from one thread to another; what is not fetched in time is thrown away."""

from __future__ import annotations

import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class DropOldestQueue(Generic[T]):
    """A place for the newest things.

    Attributes:
        dropped: how many were thrown away because newer ones came.

    >>> place = Newest[int]()
    >>> place.put(1), place.put(2)
    (None, None)
    >>> place.take(), place.dropped
    (2, 1)
    """

    def __init__(self, room: int = 1) -> None:
        """`room`: how many may wait; 1 is the least delay."""
        self._items: deque[T] = deque(maxlen=room)
        self._closed = False
        self._changed = threading.Condition()
        self.dropped = 0

    def put(self, item: T) -> None:
        """Give a new one; the oldest that waits makes room for it."""
        with self._changed:
            if self._closed:
                return
            self.dropped += len(self._items) == self._items.maxlen
            self._items.append(item)
            self._changed.notify()

    def take(self, seconds: float | None = None) -> T | None:
        """The oldest that waits, or None if none has come in this time, or none will come any more."""
        with self._changed:
            self._changed.wait_for(lambda: self._closed or bool(self._items), seconds)
            return self._items.popleft() if self._items else None

    def close(self) -> None:
        """Take no more; what waits can still be fetched."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def over(self) -> bool:
        """Whether nothing is there and nothing will come."""
        with self._changed:
            return self._closed and not self._items
