"""Pipes that are read as their content comes, and given up when nobody wants it any more."""

from __future__ import annotations

import os
import select
import threading

WAKE_SECONDS = 0.2
"""How often a wait for data looks whether it is still wanted."""


class Pipe:
    """A file descriptor to read from that gives what is there, rather than waiting to fill a block."""

    def __init__(self, descriptor: int, stopping: threading.Event) -> None:
        self._descriptor, self._stopping = descriptor, stopping

    def read(self, size: int) -> bytes:
        """Up to so many bytes; none at the end, or when it is time to stop."""
        while os.name == "posix" and not select.select([self._descriptor], [], [], WAKE_SECONDS)[0]:
            if self._stopping.is_set():
                return b""
        return os.read(self._descriptor, size)


class NamedPipe(Pipe):
    """A pipe with a place in a folder; the descriptor is its own."""

    def __init__(self, path: str, stopping: threading.Event) -> None:
        # Opened so, it does not wait for a writer where nobody could wake it.
        super().__init__(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), stopping)

    def __del__(self) -> None:
        os.close(self._descriptor)
