"""Checks files from untrusted sources before and while they are read."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """The content of a file; pipes and devices, which may never end, are refused.

    Raises:
        ValueError: it is no regular file, or larger than `max_bytes`.
        OSError: it cannot be read.
    """
    with open(path, "rb", opener=_open_without_waiting) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise ValueError("is not a file")
        content = file.read(max_bytes + 1)
    if len(content) > max_bytes:
        raise ValueError(f"is larger than {max_bytes >> 10} KiB")
    return content


def _open_without_waiting(path: str, flags: int) -> int:
    """A pipe would otherwise be opened once somebody writes to it."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
