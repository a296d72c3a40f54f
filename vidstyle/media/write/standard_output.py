"""Standard output as a file that FFmpeg writes to."""

from __future__ import annotations

import os
import sys


class StandardOutput:
    """Standard output without a buffer of Python's.

    What a buffer still held when the reader left would fail again at exit, and a thread that waits in one
    could not be abandoned.
    """

    name = "standard output"

    def __init__(self) -> None:
        self._descriptor = sys.stdout.fileno()

    def write(self, content: bytes) -> int:
        """Write all of it; waits for the reader."""
        rest = memoryview(content)
        while rest:
            rest = rest[os.write(self._descriptor, rest) :]
        return len(content)
