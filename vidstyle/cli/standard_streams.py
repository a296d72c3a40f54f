"""Standard input, output and error, made safe: closed, full or abandoned by their reader."""

from __future__ import annotations

import errno
import os
import sys
from typing import TextIO

from vidstyle.errors import OutputError, output_error


def open_missing() -> None:
    """Open the streams that the caller closed (`>&-`).

    Otherwise the next file to be opened would get a standard descriptor, and FFmpeg's messages would end up
    in a film. Reading gives nothing, writing standard output is an error, and messages are lost.
    """
    for number, (name, mode, flags) in enumerate(
        [("stdin", "r", os.O_RDONLY), ("stdout", "w", os.O_RDONLY), ("stderr", "w", os.O_WRONLY)]
    ):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))


def flush_output(abandoned: bool = False) -> OutputError | None:
    """Write what is left of standard output; the error if that fails.

    Python would do it after `main` has returned, and turn any failure into exit code 120.

    Args:
        abandoned: whether its reader is known to have gone.
    """
    try:
        if abandoned:
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))
        sys.stdout.flush()
    except OSError as error:
        _discard(sys.stdout)
        return output_error("standard output", error)
    return None


def print_error(line: str) -> None:
    """Print a line on standard error; if that fails, there is nobody to tell.

    `sys.stderr` is looked up each time: a progress bar replaces it.
    """
    try:
        print(line, file=sys.stderr, flush=True)
    except OSError:
        _discard(sys.stderr)


def _discard(stream: TextIO) -> None:
    """Let what the stream still holds, and all that follows, go nowhere."""
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), stream.fileno())
    stream.flush()
