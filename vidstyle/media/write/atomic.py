"""Atomic output: a file is written under a temporary name and renamed when it is complete."""

from __future__ import annotations

import logging
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from vidstyle.errors import OutputError, UsageError, output_error

MIN_FREE = 200 * 2**20
"""Bytes left free on the disk at which writing stops, so that the file can still be closed."""
POLL_SECONDS = 1.0
MAX_NAME = 255
"""Bytes in a file name (NAME_MAX)."""

_log = logging.getLogger("vidstyle")


class PartialFile:
    """`name.partial.mp4` beside `name.mp4`: renamed to it at success, kept or removed at failure.

    Attributes:
        target: where the finished file goes; a symbolic link to a file is followed.
        path: where it is written meanwhile.
    """

    def __init__(
        self, target: Path, source: str | Path | None, overwrite: bool, ending: str | None = None
    ) -> None:
        """Check all that can be checked before anything is written.

        Args:
            target: the file wanted.
            source: the input, which is never written to, whatever name or link leads there.
            overwrite: whether `target` may exist.
            ending: of the partial file's name, if it is of another kind.

        Raises:
            UsageError: the target is the input, exists, or is no file.
            OutputError: its folder is missing or cannot be written to.
        """
        self.target = _real(target)
        self.path = self.target.with_name(_partial_name(self.target.name, ending))
        _refuse_source(self.target, source)
        _refuse_source(self.path, source)
        if self.target.is_dir():
            raise UsageError(target, "is a folder", "name a file")
        if os.path.lexists(target) and not overwrite:
            raise UsageError(target, "exists already", "add -y to overwrite it, or choose another name")
        self._create(target)
        self._checked = 0.0

    def check_space(self) -> None:
        """Raise OutputError if the disk is nearly full; it looks once a second."""
        if time.monotonic() - self._checked < POLL_SECONDS:
            return
        self._checked = time.monotonic()
        if self.free_bytes < 0:
            raise OutputError(self.target, f"less than {MIN_FREE // 2**20} MB are left on the disk")

    def rewrite(self, convert: Callable[[Path, Path], bool]) -> None:
        """Put in place of the file what `convert` makes of it, from path to path, if it returns True.

        Raises:
            OSError: it cannot be written; the file is as it was.
        """
        other = self.path.with_name(_partial_name(self.target.name, mark=".partial.2"))
        try:
            if convert(self.path, other):
                os.replace(other, self.path)
        finally:
            other.unlink(missing_ok=True)

    @property
    def free_bytes(self) -> int:
        """How many bytes may still be written beside it."""
        return shutil.disk_usage(self.target.parent).free - MIN_FREE

    def finish(self) -> None:
        """Rename the file to its target."""
        os.replace(self.path, self.target)

    def remove(self) -> None:
        """Delete the file."""
        self.path.unlink(missing_ok=True)

    def _create(self, target: Path) -> None:
        """Make the empty file, so that a missing right shows before any work is done."""
        if self.path.exists():
            _log.warning("%s: left over from an earlier run; it is replaced", self.path)
        try:
            self.path.unlink(missing_ok=True)
            os.close(os.open(self.path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        except FileNotFoundError:
            raise OutputError(target, "its folder does not exist", "make the folder first") from None
        except OSError as error:
            raise output_error(target, error) from error


def is_regular_file(target: Path) -> bool:
    """Whether the target is, or would become, a file on a disk: no device, pipe or socket."""
    try:
        return stat.S_ISREG(target.stat().st_mode) or target.is_dir()
    except OSError:
        return True


def _real(target: Path) -> Path:
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


def _partial_name(name: str, ending: str | None = None, mark: str = ".partial") -> str:
    """The name with a mark before its ending, cut where it would become too long."""
    stem, suffix = os.path.splitext(name)
    suffix = mark + (suffix if ending is None else ending)
    return os.fsencode(stem)[: MAX_NAME - len(os.fsencode(suffix))].decode("utf-8", "ignore") + suffix


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
            file.check_space()
            file.finish()
        except OSError as error:
            raise output_error(target, error) from error

    try:
        yield write
    finally:
        file.remove()
