"""Watches a folder for films that are complete."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

from vidstyle.batch.inputs import Source, folder_sources

SETTLE_SECONDS = 5.0
"""Time without changes after which a file is complete: copies over a network pause for seconds."""
LOOK_SECONDS = 1.0
"""Interval at which the folder is scanned."""

FileSignature = tuple[int, int]


class WatchedFolder:
    """A folder whose films are returned when they are complete, and again after a change.

    Args:
        clock: returns the time in seconds.
    """

    def __init__(self, folder: Path, clock: Callable[[], float] = time.monotonic) -> None:
        self._folder, self._clock = folder, clock
        self._looked = -LOOK_SECONDS
        self._seen: dict[Path, tuple[FileSignature, float]] = {}
        self._taken: dict[Path, FileSignature] = {}

    def complete_sources(self) -> list[Source]:
        """Return the films that became complete since the last call.

        Raises:
            InputError: the folder cannot be read.
        """
        now = self._clock()
        if now - self._looked < LOOK_SECONDS:
            return []
        self._looked = now
        return [
            source
            for source in folder_sources(self._folder)
            if isinstance(source.path, Path) and self._is_due(source.path, now)
        ]

    def _is_due(self, path: Path, now: float) -> bool:
        """Whether a file is complete and was not yet returned in this state; record it as returned."""
        try:
            status = os.stat(path)
        except OSError:
            return False
        signature = status.st_size, status.st_mtime_ns
        if self._taken.get(path) == signature:
            return False
        earlier, since = self._seen.get(path, (None, now))
        self._seen[path] = signature, since if earlier == signature else now
        if not signature[0] or now - self._seen[path][1] < SETTLE_SECONDS:
            return False
        self._taken[path] = signature
        return True
