"""Temporary files next to an output: their names, exclusive creation, identity and locks."""

from __future__ import annotations

import errno
import os
import secrets
import sys
import weakref
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from vidstyle.errors import log

if sys.platform != "win32":  # Windows itself lets nobody remove or rename a file that is being written
    import fcntl

MAX_NAME_BYTES = 255
"""Maximum length of a file name (NAME_MAX)."""
MARK = ".vidstyle-"
"""What precedes the random part of a temporary name."""
TOKEN_BYTES = 8


class FileIdentity(NamedTuple):
    """Device and number of a file, which stay the same when it is renamed."""

    device: int
    inode: int

    @classmethod
    def of(cls, status: os.stat_result) -> FileIdentity:
        """The identity of the file that has this status."""
        return cls(status.st_dev, status.st_ino)

    def is_at(self, path: Path) -> bool:
        """Whether a path, not followed if it is a link, leads to this file."""
        try:
            return FileIdentity.of(os.lstat(path)) == self
        except OSError:
            return False


def create_file(path: Path, content: bytes = b"") -> FileIdentity:
    """Create a file that did not exist.

    Raises:
        FileExistsError: anything has this name, a broken link too.
        OSError: it cannot be created or written to.
    """
    with open(path, "xb", buffering=0) as file:
        identity = FileIdentity.of(os.fstat(file.fileno()))
        try:
            file.write(content)
        except OSError:
            path.unlink(missing_ok=True)
            raise
    return identity


def rename_to_new(path: Path, target: Path) -> None:
    """Rename a file to a name that nothing has; raises FileExistsError otherwise."""
    try:
        os.link(path, target)
    except FileExistsError:
        raise
    except OSError:  # a disk without hard links
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target)) from None
        path.rename(target)
    else:
        path.unlink()


def partial_path(target: Path, ending: str | None = None, mark: str = ".partial") -> Path:
    """The path with a mark before its ending, which may be another; cut where it would become too long.

    >>> partial_path(Path("a.mp4")).name
    'a.partial.mp4'
    """
    stem, suffix = os.path.splitext(target.name)
    suffix = mark + (suffix if ending is None else ending)
    while stem and len(os.fsencode(stem + suffix)) > MAX_NAME_BYTES:
        stem = stem[:-1]
    return target.with_name(stem + suffix)


def create_temporary(target: Path, content: bytes = b"") -> tuple[Path, FileIdentity]:
    """Create a file with a random name next to a target; raises OSError."""
    while True:
        path = partial_path(target, mark=MARK + secrets.token_hex(TOKEN_BYTES))
        with suppress(FileExistsError):
            return path, create_file(path, content)


def is_temporary(name: str) -> bool:
    """Whether a file name is one that `create_temporary` gives.

    >>> is_temporary("a.vidstyle-0123456789abcdef.mp4"), is_temporary("../a.mp4"), is_temporary("a.mp4")
    (True, False, False)
    """
    _, found, token = os.path.splitext(name)[0].rpartition(MARK)
    is_token = len(token) == 2 * TOKEN_BYTES and set(token) <= set("0123456789abcdef")
    return bool(found) and is_token and os.path.basename(name) == name


class FileLock:
    """A file that is locked until `release` or the end of the process, however it ends.

    The lock is advisory and belongs to the open file (flock): other descriptors on it may come and go.
    Network folders may have no locks; then only `identity` tells of another run.

    Attributes:
        identity: of the file.
    """

    def __init__(self, path: Path) -> None:
        """Lock a file that exists and is no link.

        Raises:
            BlockingIOError: another run has locked it.
            OSError: it cannot be opened for writing.
        """
        descriptor = os.open(path, os.O_RDWR | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0))
        self._descriptor = descriptor
        self._close = weakref.finalize(self, os.close, descriptor)
        self.identity = FileIdentity.of(os.fstat(descriptor))
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

    def append(self, path: Path, content: bytes) -> None:
        """Add to the file, which is at `path`; raises OSError."""
        if sys.platform == "win32":  # which could not remove the file if it stayed open
            with path.open("ab", buffering=0) as file:
                file.write(content)
        else:
            os.write(self._descriptor, content)

    def release(self) -> None:
        """Let others have it."""
        self._close()


def lock_owner(path: Path) -> str | None:
    """The process that holds the lock on a file, by /proc/locks; None if nobody does any more."""
    try:
        inode = path.stat().st_ino
        with open("/proc/locks", encoding="ascii") as table:
            found = [line.split() for line in table if "->" not in line]
    except FileNotFoundError:
        return None if Path("/proc/locks").exists() else "another run"
    numbers = [fields[4] for fields in found if fields[5].endswith(f":{inode}")]
    return f"process {numbers[0]}" if numbers else None
