"""Locks on files that end with the process, however it ends."""

from __future__ import annotations

import itertools
import os
import stat
import sys
import time
import weakref
from pathlib import Path

from vidstyle.errors import OutputError, UsageError, log, output_error

if sys.platform != "win32":  # Windows itself lets nobody remove or rename a file that is being written
    import fcntl

ATTEMPTS, ATTEMPT_SECONDS = 50, 0.02
"""How often, and how many seconds apart, a locked file is tried whose owner is about to let it go."""


class FileLock:
    """A file, made if it is not there, that is locked until `release` or the end of the process.

    The lock is advisory and belongs to the open file (flock): other descriptors on it may come and go.
    Network folders may have no locks; then only `is_at` tells of another run.

    Attributes:
        is_empty: whether it held nothing when it was locked.
    """

    def __init__(self, path: Path) -> None:
        """Lock a file that is no link.

        Raises:
            BlockingIOError: another run has locked it.
            OSError: it cannot be made or written to.
        """
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        descriptor = os.open(path, flags, 0o666)
        self._close = weakref.finalize(self, os.close, descriptor)
        status = os.fstat(descriptor)
        self._identity = status.st_dev, status.st_ino
        self.is_empty = status.st_size == 0
        if sys.platform == "win32":
            self.release()
            return
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.release()
            raise
        except OSError as error:
            log.debug("%s: cannot be locked (%s)", path, error)

    def is_at(self, path: Path) -> bool:
        """Whether the path still leads to this very file."""
        try:
            status = os.lstat(path)
        except OSError:
            return False
        return (status.st_dev, status.st_ino) == self._identity

    def release(self) -> None:
        """Let others have it."""
        self._close()


def lock_file(path: Path, target: Path) -> FileLock:
    """Lock the file that has a name in the end.

    Args:
        path: of the file.
        target: what is to be written, for messages.

    Raises:
        UsageError: another run has locked it.
        OutputError: it cannot be made or written to.
    """
    try:
        for attempt in itertools.count():
            if os.path.lexists(path) and not stat.S_ISREG(path.lstat().st_mode):
                path.unlink()
            try:
                lock = FileLock(path)
            except BlockingIOError:
                owner = _owner(path)
                if owner is None and attempt < ATTEMPTS:  # it has just ended, or put another file in place
                    time.sleep(ATTEMPT_SECONDS)
                    continue
                reason = f"{owner or 'another run'} is writing it"
                raise UsageError(target, reason, "wait for its end, or choose another name") from None
            # Between opening and locking, the run that had it may have renamed or removed it.
            if lock.is_at(path):
                return lock
            lock.release()
    except FileNotFoundError:
        raise OutputError(target, "its folder does not exist", "add --parents to make it") from None
    except OSError as error:
        raise output_error(target, error) from error
    raise AssertionError


def _owner(path: Path) -> str | None:
    """The process that holds the lock on a file, by /proc/locks; None if nobody does any more."""
    try:
        inode = path.stat().st_ino
        with open("/proc/locks", encoding="ascii") as table:
            found = [line.split() for line in table if "->" not in line]
    except FileNotFoundError:
        return None if Path("/proc/locks").exists() else "another run"
    numbers = [fields[4] for fields in found if fields[5].endswith(f":{inode}")]
    return f"process {numbers[0]}" if numbers else None
