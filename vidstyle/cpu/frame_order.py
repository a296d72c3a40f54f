"""The order of pictures that are restyled side by side."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Condition
from typing import Self


class Turn:
    """The turn of one picture at each thing that remembers earlier pictures. Leaving its context ends it.

    Args:
        before: the turn of the picture before.
    """

    def __init__(self, before: Turn | None = None) -> None:
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
        self._before = None  # else all turns of a film would be kept

    @contextmanager
    def at(self, memory: object) -> Iterator[None]:
        """Use `memory` after the picture before has used it, or has ended."""
        if self._before is not None:
            self._before._wait_for(memory)
        yield
        with self._changed:
            self._used.append(memory)
            self._changed.notify_all()

    def _wait_for(self, memory: object) -> None:
        with self._changed:
            self._changed.wait_for(lambda: self._has_ended or any(memory is each for each in self._used))
