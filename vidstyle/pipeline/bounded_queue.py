"""A short queue between two threads; that it is short is the back-pressure."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class QueueClosedError(Exception):
    """Nobody takes items any more, so the giver can end."""


class BoundedQueue(Generic[T]):
    """Hands items over in order; the giver waits while `room` items lie there.

    >>> channel = Channel[int](room=2)
    >>> channel.put(1)
    >>> channel.close()
    >>> list(channel)
    [1]
    """

    def __init__(self, room: int) -> None:
        self._room = room
        self._items: deque[T] = deque()
        self._closed = False
        self._changed = threading.Condition()

    def put(self, item: T) -> None:
        """Add an item as soon as there is room.

        Raises:
            ChannelClosedError: the channel was closed, before or while waiting.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._closed or len(self._items) < self._room)
            if self._closed:
                raise QueueClosedError
            self._items.append(item)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[T]:
        """Take items as they come, until the channel is closed and empty."""
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
        """Take no more items; those that lie there are still handed out unless discarded."""
        with self._changed:
            self._closed = True
            if discard:
                self._items.clear()
            self._changed.notify_all()
