"""Atomic output: a file is written under a temporary name and renamed when it is complete."""

from __future__ import annotations

import errno
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from vidstyle.errors import OutputError, UsageError, log, output_error
from vidstyle.media.write.file_lock import FileLock, lock_file

MIN_FREE = 200 * 2**20
"""Bytes left free on the disk at which writing stops, so that the file can still be closed."""
POLL_SECONDS = 1.0
MAX_NAME = 255
"""Bytes in a file name (NAME_MAX)."""


class PartialFile:
    """`name.partial.mp4` beside `name.mp4`: renamed to it at success, kept or removed at failure.

    It is locked as long as the run that writes it lasts, so that no other takes it for a leftover.

    Attributes:
        target: where the finished file goes; a symbolic link to a file is followed.
        path: where it is written meanwhile.
        is_left: whether an earlier run has left `path`; `start_anew` or `continue_beside` is due then.
    """

    def __init__(
        self,
        target: Path,
        source: str | Path | None,
        overwrite: bool,
        ending: str | None = None,
        keep: bool = False,
    ) -> None:
        """Check all that can be checked before anything is written.

        Args:
            target: the file wanted.
            source: the input, which is never written to, whatever name or link leads there.
            overwrite: whether `target` may exist.
            ending: of the partial file's name, if it is of another kind.
            keep: whether to leave what an earlier run has left in place; otherwise it is replaced.

        Raises:
            UsageError: the target is the input, exists, is no file, or is being written by another run.
            OutputError: its folder is missing or cannot be written to.
        """
        self.target = real_path(target)
        self.path = partial_path(self.target, ending)
        self._overwrite = overwrite
        _refuse_source(self.target, source)
        _refuse_source(self.path, source)
        if self.target.is_dir():
            raise UsageError(target, "is a folder", "name a file")
        self._refuse_existing(target)
        self._checked = 0.0
        self._lock = lock_file(self.path, target)
        self._earlier: tuple[Path, FileLock] | None = None
        self.is_left = not self._lock.is_empty
        try:
            self._refuse_existing(target)  # the run that had the lock may have ended just now
        except UsageError:
            self.release() if self.is_left else self.remove()
            raise
        if self.is_left and not keep:
            self.start_anew()

    def start_anew(self) -> None:
        """Put an empty file in place of what an earlier run has left."""
        log.warning("%s: left over from an earlier run; it is replaced", self.path)
        self.path.unlink()
        self._beside.unlink(missing_ok=True)
        self.release()
        self._lock, self.is_left = lock_file(self.path, self.target), False

    def continue_beside(self) -> None:
        """Go on in an empty file beside what an earlier run has left, which stays until `take_over`."""
        self._earlier = self.path, self._lock
        self.path = self._beside
        self.path.unlink(missing_ok=True)
        self._lock, self.is_left = lock_file(self.path, self.target), False

    def take_over(self) -> None:
        """Put the file in place of what an earlier run has left."""
        if self._earlier is not None:
            self._check_owned()
            path, lock = self._earlier
            os.replace(self.path, path)
            self.path, self._earlier = path, None
            lock.release()

    def check(self) -> bool:
        """Whether it has looked, as it does once a second, if the file is there and the disk has room.

        Raises:
            OutputError: the file was taken away, or the disk is nearly full.
        """
        if time.monotonic() - self._checked < POLL_SECONDS:
            return False
        self._checked = time.monotonic()
        self._check_owned()
        if self.free_bytes < 0:
            raise OutputError(self.target, f"less than {MIN_FREE // 2**20} MB are left on the disk")
        return True

    def rewrite(self, convert: Callable[[Path, Path], bool]) -> None:
        """Put in place of the file what `convert` makes of it, from path to path, if it returns True.

        Raises:
            OSError: it cannot be written; the file is as it was.
        """
        self.take_over()
        other = self._beside
        lock = lock_file(other, self.target)
        try:
            if convert(self.path, other):
                self._check_owned()
                os.replace(other, self.path)
                self._lock, lock = lock, self._lock
        finally:
            lock.release()
            other.unlink(missing_ok=True)

    @property
    def _beside(self) -> Path:
        return partial_path(self.target, mark=".partial.2")

    @property
    def earlier(self) -> Path | None:
        """What an earlier run has left, while this one goes on beside it."""
        return self._earlier and self._earlier[0]

    @property
    def exists(self) -> bool:
        """Whether what was written is still there, and no file of somebody else's."""
        return self._lock.is_at(self.path)

    @property
    def free_bytes(self) -> int:
        """How many bytes may still be written beside it."""
        return shutil.disk_usage(self.target.parent).free - MIN_FREE

    def finish(self) -> None:
        """Rename the file to its target.

        Raises:
            OutputError: the target has appeared, and is not to be overwritten; or the file is gone.
            OSError: it cannot be renamed.
        """
        self.take_over()
        self._check_owned()
        try:
            (os.replace if self._overwrite else _rename_to_new)(self.path, self.target)
        except FileExistsError:
            raise OutputError(self.target, "has appeared meanwhile, and is not overwritten") from None
        self.release()

    def release(self) -> None:
        """Leave the file to others, as it is."""
        self._lock.release()
        if self._earlier is not None:
            self._earlier[1].release()

    def remove(self) -> None:
        """Delete the file."""
        if self.exists:
            self.path.unlink(missing_ok=True)
        self.release()

    def _refuse_existing(self, target: Path) -> None:
        if os.path.lexists(target) and not self._overwrite:
            raise UsageError(target, "exists already", "add -y to overwrite it, or choose another name")

    def _check_owned(self) -> None:
        if not self.exists:
            raise OutputError(self.target, f"{self.path.name} was removed or replaced while it was written")


def _rename_to_new(path: Path, target: Path) -> None:
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


def check_folder(target: Path) -> None:
    """Raise OutputError if files cannot be made where the target is to be."""
    folder = target.parent
    if not folder.is_dir():
        raise OutputError(target, "its folder does not exist", "add --parents to make it")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(target, "cannot be written: its folder is not writable", "choose another folder")


def is_regular_file(target: Path) -> bool:
    """Whether the target is, or would become, a file on a disk: no device, pipe or socket."""
    try:
        return stat.S_ISREG(target.stat().st_mode) or target.is_dir()
    except OSError:
        return True


def real_path(target: Path) -> Path:
    """Where a path leads, links followed; raises UsageError where they lead in a circle."""
    try:
        return target.resolve()
    except (OSError, RuntimeError):
        raise UsageError(target, "is a symbolic link that leads back to itself", "name a file") from None


def _refuse_source(path: Path, source: str | Path | None) -> None:
    try:
        same = source is not None and os.path.samefile(path, source)
    except OSError:
        return
    if same:
        raise UsageError(path, "is the input itself, and would be overwritten", "choose another output name")


def partial_path(target: Path, ending: str | None = None, mark: str = ".partial") -> Path:
    """The path with a mark before its ending, which may be another; cut where it would become too long.

    >>> partial_path(Path("a.mp4")).name
    'a.partial.mp4'
    """
    stem, suffix = os.path.splitext(target.name)
    suffix = mark + (suffix if ending is None else ending)
    while stem and len(os.fsencode(stem)) > MAX_NAME - len(os.fsencode(suffix)):
        stem = stem[:-1]
    return target.with_name(stem + suffix)


@contextmanager
def atomic_file(
    target: Path, source: str | Path | None = None, overwrite: bool = False
) -> Iterator[Callable[[bytes], None]]:
    """Check that the target may be written; the function it gives writes the content.

    The target has its name when the block ends; when it raises, nothing is left.

    Raises:
        UsageError: the target is the source, exists, or is no file.
        OutputError: it cannot be written.
    """
    if not is_regular_file(target):
        raise UsageError(target, "is a device or a pipe", "name a file")
    file = PartialFile(target, source, overwrite)

    def write(content: bytes) -> None:
        try:
            file.path.write_bytes(content)
            file.check()
            file.finish()
        except OutputError:
            raise
        except OSError as error:
            raise output_error(target, error) from error

    try:
        yield write
    finally:
        file.remove()
