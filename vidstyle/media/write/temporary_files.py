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

if sys.platform != "win32":  # Windows itself prevents removing or renaming an open file
    import fcntl

MAX_NAME_BYTES = 255
"""Maximum length of a file name (NAME_MAX)."""
TEMPORARY_MARK = ".vidstyle-"
"""Text before the random part of a temporary name."""
TOKEN_BYTES = 8


class FileIdentity(NamedTuple):
    """Device and inode of a file, which stay the same if it is renamed."""

    device: int
    inode: int

    @classmethod
    def of(cls, status: os.stat_result) -> FileIdentity:
        """Return the identity of the file with this status."""
        return cls(status.st_dev, status.st_ino)

    def is_at(self, path: Path) -> bool:
        """Whether a path refers to this file; links are not followed."""
        try:
            return FileIdentity.of(os.lstat(path)) == self
        except OSError:
            return False


def create_file(path: Path, content: bytes = b"") -> FileIdentity:
    """Create a file that does not exist.

    Raises:
        FileExistsError: the name is in use, even by a broken link.
        OSError: the file cannot be created or written.
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
    """Rename a file to an unused name; raise FileExistsError if it is in use."""
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
    """Return the path with a mark before its extension, which may be replaced; shorten long names.

    >>> partial_path(Path("a.mp4")).name
    'a.partial.mp4'
    """
    stem, suffix = os.path.splitext(target.name)
    suffix = mark + (suffix if ending is None else ending)
    while stem and len(os.fsencode(stem + suffix)) > MAX_NAME_BYTES:
        stem = stem[:-1]
    return target.with_name(stem + suffix)


def create_temporary(target: Path, content: bytes = b"") -> tuple[Path, FileIdentity]:
    """Create a file with a random name next to a target; raise OSError if that fails."""
    while True:
        path = partial_path(target, mark=TEMPORARY_MARK + secrets.token_hex(TOKEN_BYTES))
        with suppress(FileExistsError):
            return path, create_file(path, content)


def is_temporary(name: str) -> bool:
    """Whether a file name has the form that `create_temporary` uses.

    >>> is_temporary("a.vidstyle-0123456789abcdef.mp4"), is_temporary("../a.mp4"), is_temporary("a.mp4")
    (True, False, False)
    """
    _, found, token = os.path.splitext(name)[0].rpartition(TEMPORARY_MARK)
    is_token = len(token) == 2 * TOKEN_BYTES and set(token) <= set("0123456789abcdef")
    return bool(found) and is_token and os.path.basename(name) == name


class FileLock:
    """A file that is locked until `release` or any end of the process.

    The lock is advisory and belongs to the open file (flock), independent of other descriptors. Network
    folders may have no locks; then only `identity` detects another run.

    Attributes:
        identity: identity of the file.
    """

    def __init__(self, path: Path) -> None:
        """Lock an existing file that is not a link.

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
        """Append to the file, which is at `path`; raise OSError if that fails."""
        if sys.platform == "win32":  # an open file could not be removed
            with path.open("ab", buffering=0) as file:
                file.write(content)
        else:
            os.write(self._descriptor, content)

    def release(self) -> None:
        """Release the lock."""
        self._close()


def lock_owner(path: Path) -> str | None:
    """Return the process that holds the lock on a file, by /proc/locks; None if there is no lock."""
    try:
        inode = path.stat().st_ino
        with open("/proc/locks", encoding="ascii") as table:
            found = [line.split() for line in table if "->" not in line]
    except FileNotFoundError:
        return None if Path("/proc/locks").exists() else "another run"
    numbers = [fields[4] for fields in found if fields[5].endswith(f":{inode}")]
    return f"process {numbers[0]}" if numbers else None
