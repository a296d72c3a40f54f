"""The order of pictures that are restyled concurrently."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Condition
from typing import Self


class FrameOrder:
    """The place of one picture in the order in which pictures use state of earlier pictures.

    Leaving its context ends it.

    Args:
        before: the place of the previous picture.
    """

    def __init__(self, before: FrameOrder | None = None) -> None:
        self._before = before
        self._changed = Condition()
        self._used: list[object] = []
        self._has_ended = before is None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()
        self._before = None  # otherwise the objects of all frames would stay alive

    @contextmanager
    def at(self, memory: object) -> Iterator[None]:
        """Use `memory` after the previous picture has used it or has ended."""
        if self._before is not None:
            self._before._wait_for(memory)
        yield
        with self._changed:
            self._used.append(memory)
            self._changed.notify_all()

    def _wait_for(self, memory: object) -> None:
        with self._changed:
            self._changed.wait_for(lambda: self._has_ended or any(memory is each for each in self._used))
