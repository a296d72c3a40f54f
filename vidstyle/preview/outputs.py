"""What pages write: files under plain names in one folder, one long job at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from vidstyle.errors import UsageError
from vidstyle.export.export_targets import EXPORT_TARGETS
from vidstyle.preview.clip import Clip
from vidstyle.preview.places import check_path, refuse_existing
from vidstyle.web.messages import one_of

ExportKind = Annotated[str, one_of(EXPORT_TARGETS)]
"""A field of messages: an export target."""


def output_path(folder: Path, name: str, suffix: str = "", overwrite: bool = False) -> Path:
    """Return the path of a file to write, see `check_path`.

    Raises:
        UsageError: the name is invalid, or the file exists.
    """
    path = check_path(folder, name, suffix)
    refuse_existing(path, overwrite)
    return path


def file_of(clip: Clip) -> str:
    """Return the file to render for a clip.

    Raises:
        UsageError: the clip comes from a camera.
    """
    source = clip.file()
    if source is None:
        raise UsageError(clip.name, "is a camera", "record it with vidstyle live")
    return source


class JobSlot:
    """Runs one long job at a time."""

    def __init__(self) -> None:
        self._stop: threading.Event | None = None

    def cancel(self) -> None:
        """Cancel the current job, if any."""
        if self._stop is not None:
            self._stop.set()

    @contextmanager
    def begin(self) -> Iterator[threading.Event]:
        """Occupy the slot within the block; yield the event that `cancel` sets.

        Raises:
            UsageError: another job is running.
        """
        if self._stop is not None:
            raise UsageError("the page", "is busy with another job", "wait, or cancel it")
        self._stop = threading.Event()
        try:
            yield self._stop
        finally:
            self._stop = None
