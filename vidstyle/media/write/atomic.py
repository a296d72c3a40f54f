"""Atomic output: a file is written under a temporary name and renamed when it is complete."""

from __future__ import annotations

import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from vidstyle.errors import OutputError, UsageError, log, output_error
from vidstyle.media.write.run_record import RunRecord, unknown_file_error
from vidstyle.media.write.temporary_files import FileIdentity, create_file, partial_path, rename_to_new

MIN_FREE_BYTES = 200 * 2**20
"""Free disk space at which writing stops, so that the file can still be closed."""
POLL_SECONDS = 1.0


class OutputFile:
    """A new file with a random name next to its target: renamed to the target at success, else removed.

    The record of the run is locked until the run ends, so that no other run writes the same target.

    Attributes:
        target: path of the finished file; a symbolic link to a file is followed.
        path: path of the temporary file.
        record: record of the run.
    """

    def __init__(
        self, target: Path, source: str | Path | None, overwrite: bool, record: RunRecord | None = None
    ) -> None:
        """Check everything that can be checked before writing starts.

        Args:
            target: the requested file.
            source: the input, which is never overwritten, by any name or link.
            overwrite: whether `target` may exist.
            record: record of a run that writes several files; None: a new record for this file.

        Raises:
            UsageError: the target is the input, exists, is not a file, or is being written by another run.
            OutputError: its folder is missing or not writable.
        """
        self.target = resolve_path(target)
        self._overwrite, self._source = overwrite, source
        _refuse_source(self.target, source)
        if self.target.is_dir():
            raise UsageError(target, "is a folder", "name a file")
        self._refuse_existing(target)
        self._checked = 0.0
        self._has_own_record = record is None
        self.record = record or RunRecord(self.target)
        try:
            self._refuse_existing(target)  # the run that held the record may have ended just now
            self.path, self._identity = self._create()
        except OSError as error:
            self._end_record(self.record.release_unused)
            raise error if isinstance(error, OutputError) else output_error(target, error) from error
        except UsageError:
            self._end_record(self.record.release_unused)
            raise

    def _create(self) -> tuple[Path, FileIdentity]:
        return self.record.create_temporary(self.target)

    def check(self) -> bool:
        """Check once per second that the file exists and the disk has free space; return whether it checked.

        Raises:
            OutputError: the file was removed or replaced, or the disk is nearly full.
        """
        if time.monotonic() - self._checked < POLL_SECONDS:
            return False
        self._checked = time.monotonic()
        self._check_owned()
        if self.free_bytes < 0:
            raise OutputError(self.target, f"less than {MIN_FREE_BYTES // 2**20} MB are left on the disk")
        return True

    @property
    def exists(self) -> bool:
        """Whether the file still exists and was not replaced by another one."""
        return self._identity.is_at(self.path)

    @property
    def free_bytes(self) -> int:
        """Number of bytes that may still be written to its folder."""
        return shutil.disk_usage(self.target.parent).free - MIN_FREE_BYTES

    def finish(self) -> None:
        """Rename the file to its target.

        Raises:
            OutputError: the target appeared and must not be overwritten, or the file was removed.
            OSError: the file cannot be renamed.
        """
        self._check_owned()
        try:
            (os.replace if self._overwrite else rename_to_new)(self.path, self.target)
        except FileExistsError:
            raise OutputError(self.target, "appeared during the run and is not overwritten") from None
        self._end_record(self.record.remove)

    def remove(self) -> None:
        """Delete the file."""
        if self.exists:
            self.path.unlink(missing_ok=True)
        self._end_record(self.record.remove)

    def _end_record(self, end: Callable[[], None]) -> None:
        if self._has_own_record:
            end()

    def _refuse_existing(self, target: Path) -> None:
        if os.path.lexists(target) and not self._overwrite:
            raise UsageError(target, "already exists", "add -y to overwrite it, or choose another name")

    def _check_owned(self) -> None:
        if not self.exists:
            raise OutputError(self.target, f"{self.path.name} was removed or replaced while it was written")


class PartialFile(OutputFile):
    """`name.partial.mp4` next to `name.mp4`: renamed to it at success, kept or removed at failure.

    Attributes:
        has_leftover: whether `path` is from an earlier run; then call `restart` or `continue_separately`.
    """

    def __init__(
        self, target: Path, source: str | Path | None, overwrite: bool, ending: str | None = None
    ) -> None:
        """See OutputFile; `ending`: extension of the partial file if it has another format.

        Raises:
            UsageError: a file with the name of the partial file exists that is not from an earlier run.
        """
        self._ending = ending
        self._leftover: tuple[Path, FileIdentity] | None = None
        self.has_leftover = False
        super().__init__(target, source, overwrite)

    def _create(self) -> tuple[Path, FileIdentity]:
        path = partial_path(self.target, self._ending)
        _refuse_source(path, self._source)
        try:
            return path, create_file(path)
        except FileExistsError:
            status = os.lstat(path)
        if not self.record.is_left or not stat.S_ISREG(status.st_mode):
            raise unknown_file_error(path)
        self.has_leftover = True
        return path, FileIdentity.of(status)

    def restart(self) -> None:
        """Replace the leftover of an earlier run with an empty file."""
        log.warning("%s is from an earlier run and is replaced", self.path)
        self._check_owned()
        self.path.unlink()
        self._identity, self.has_leftover = create_file(self.path), False

    def continue_separately(self) -> None:
        """Write to an empty file next to the leftover of an earlier run, kept until `replace_leftover`."""
        self._leftover = self.path, self._identity
        self.path, self._identity = self.record.create_temporary(self.target)
        self.has_leftover = False

    def replace_leftover(self) -> None:
        """Replace the leftover of an earlier run with the file.

        Raises:
            OutputError: the leftover was replaced by another file.
        """
        if self._leftover is None:
            return
        self._check_owned()
        path, identity = self._leftover
        try:
            (os.replace if identity.is_at(path) else rename_to_new)(self.path, path)
        except FileExistsError:
            raise OutputError(self.target, f"{path.name} was replaced while it was continued") from None
        self.path, self._leftover = path, None

    def rewrite(self, convert: Callable[[Path, Path], bool]) -> None:
        """Replace the file with the output of `convert(source, target)`, if that returns True.

        Raises:
            OSError: the output cannot be written; the file is unchanged.
        """
        self.replace_leftover()
        other, identity = self.record.create_temporary(self.target)
        try:
            if convert(self.path, other):
                self._check_owned()
                self.record.add_written(other, self.path.name)
                os.replace(other, self.path)
                self._identity = identity
        finally:
            if identity.is_at(other):
                other.unlink()

    @property
    def leftover(self) -> Path | None:
        """The leftover of an earlier run, while this run writes next to it."""
        return self._leftover and self._leftover[0]

    def finish(self) -> None:
        """See OutputFile."""
        self.replace_leftover()
        super().finish()

    def release(self) -> None:
        """Keep the leftover of an earlier run and the record unchanged."""
        self.record.release()

    def keep(self) -> Path:
        """Keep the file for a later run; return its path, another one if its name is in use."""
        try:
            self.replace_leftover()
        except OSError:
            self.record.remove()  # by this record, the next run would remove the file
        self.record.release()
        return self.path

    def remove(self) -> None:
        """Delete the file; keep the leftover of an earlier run."""
        if self._leftover is None:
            super().remove()
            return
        if self.exists:
            self.path.unlink(missing_ok=True)
        self.release()


def check_folder(target: Path) -> None:
    """Raise OutputError if no file can be created in the folder of the target."""
    folder = target.parent
    if not folder.is_dir():
        raise OutputError(target, "its folder does not exist", "add --parents to create it")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(target, "cannot be written: its folder is not writable", "choose another folder")


def is_regular_file(target: Path) -> bool:
    """Whether the target is or would be a file on a disk, not a device, pipe or socket."""
    try:
        return stat.S_ISREG(target.stat().st_mode) or target.is_dir()
    except OSError:
        return True


def resolve_path(target: Path) -> Path:
    """Resolve all links of a path; raise UsageError if they form a loop."""
    try:
        return target.resolve()
    except (OSError, RuntimeError):
        raise UsageError(target, "is a loop of symbolic links", "name a file") from None


def _refuse_source(path: Path, source: str | Path | None) -> None:
    try:
        same = source is not None and os.path.samefile(path, source)
    except OSError:
        return
    if same:
        raise UsageError(path, "is the input itself, and would be overwritten", "choose another output name")


@contextmanager
def atomic_file(
    target: Path, source: str | Path | None = None, overwrite: bool = False
) -> Iterator[Callable[[bytes], None]]:
    """Check that the target may be written; yield a function that writes the content.

    If the block raises, no file is left.

    Raises:
        UsageError: the target is the source, exists, or is not a file.
        OutputError: the target cannot be written.
    """
    if not is_regular_file(target):
        raise UsageError(target, "is a device or a pipe", "name a file")
    file = OutputFile(target, source, overwrite)

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
