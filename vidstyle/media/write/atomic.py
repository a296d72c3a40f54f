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
from vidstyle.media.write.run_record import RunRecord, unknown_file
from vidstyle.media.write.temporary_files import FileIdentity, create_file, partial_path, rename_to_new

MIN_FREE = 200 * 2**20
"""Bytes left free on the disk at which writing stops, so that the file can still be closed."""
POLL_SECONDS = 1.0


class OutputFile:
    """A new file with a random name next to its target: renamed to it at success, else removed.

    The record of the run is locked as long as the run lasts, so that no other writes the same target.

    Attributes:
        target: where the finished file goes; a symbolic link to a file is followed.
        path: where it is written meanwhile.
        record: of the run.
    """

    def __init__(
        self, target: Path, source: str | Path | None, overwrite: bool, record: RunRecord | None = None
    ) -> None:
        """Check all that can be checked before anything is written.

        Args:
            target: the file wanted.
            source: the input, which is never written to, whatever name or link leads there.
            overwrite: whether `target` may exist.
            record: of a run that writes several files; None: this file has one of its own.

        Raises:
            UsageError: the target is the input, exists, is no file, or is being written by another run.
            OutputError: its folder is missing or cannot be written to.
        """
        self.target = real_path(target)
        self._overwrite, self._source = overwrite, source
        _refuse_source(self.target, source)
        if self.target.is_dir():
            raise UsageError(target, "is a folder", "name a file")
        self._refuse_existing(target)
        self._checked = 0.0
        self._has_own_record = record is None
        self.record = record or RunRecord(self.target)
        try:
            self._refuse_existing(target)  # the run that had the record may have ended just now
            self.path, self._identity = self._create()
        except OSError as error:
            self._end_record(self.record.give_back)
            raise error if isinstance(error, OutputError) else output_error(target, error) from error
        except UsageError:
            self._end_record(self.record.give_back)
            raise

    def _create(self) -> tuple[Path, FileIdentity]:
        return self.record.create_temporary(self.target)

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

    @property
    def exists(self) -> bool:
        """Whether the file is still there, and no file of somebody else's."""
        return self._identity.is_at(self.path)

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
        self._check_owned()
        try:
            (os.replace if self._overwrite else rename_to_new)(self.path, self.target)
        except FileExistsError:
            raise OutputError(self.target, "has appeared meanwhile, and is not overwritten") from None
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
            raise UsageError(target, "exists already", "add -y to overwrite it, or choose another name")

    def _check_owned(self) -> None:
        if not self.exists:
            raise OutputError(self.target, f"{self.path.name} was removed or replaced while it was written")


class PartialFile(OutputFile):
    """`name.partial.mp4` beside `name.mp4`: renamed to it at success, kept or removed at failure.

    Attributes:
        is_left: whether an earlier run has left `path`; `start_anew` or `continue_beside` is due then.
    """

    def __init__(
        self, target: Path, source: str | Path | None, overwrite: bool, ending: str | None = None
    ) -> None:
        """See OutputFile; `ending`: of the partial file's name, if it is of another kind.

        Raises:
            UsageError: there is a file of the partial file's name that no run is known to have left.
        """
        self._ending = ending
        self._earlier: tuple[Path, FileIdentity] | None = None
        self.is_left = False
        super().__init__(target, source, overwrite)

    def _create(self) -> tuple[Path, FileIdentity]:
        path = partial_path(self.target, self._ending)
        _refuse_source(path, self._source)
        try:
            return path, create_file(path)
        except FileExistsError:
            status = os.lstat(path)
        if not self.record.is_left or not stat.S_ISREG(status.st_mode):
            raise unknown_file(path)
        self.is_left = True
        return path, FileIdentity.of(status)

    def start_anew(self) -> None:
        """Put an empty file in place of what an earlier run has left."""
        log.warning("%s: left over from an earlier run; it is replaced", self.path)
        self._check_owned()
        self.path.unlink()
        self._identity, self.is_left = create_file(self.path), False

    def continue_beside(self) -> None:
        """Write to an empty file next to the leftover of an earlier run, which stays until `take_over`."""
        self._earlier = self.path, self._identity
        self.path, self._identity = self.record.create_temporary(self.target)
        self.is_left = False

    def take_over(self) -> None:
        """Put the file in place of what an earlier run has left.

        Raises:
            OutputError: there is another file there now.
        """
        if self._earlier is None:
            return
        self._check_owned()
        path, identity = self._earlier
        try:
            (os.replace if identity.is_at(path) else rename_to_new)(self.path, path)
        except FileExistsError:
            raise OutputError(self.target, f"{path.name} was replaced while it was continued") from None
        self.path, self._earlier = path, None

    def rewrite(self, convert: Callable[[Path, Path], bool]) -> None:
        """Put in place of the file what `convert` makes of it, from path to path, if it returns True.

        Raises:
            OSError: it cannot be written; the file is as it was.
        """
        self.take_over()
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
    def earlier(self) -> Path | None:
        """The leftover of an earlier run, while this run writes next to it."""
        return self._earlier and self._earlier[0]

    def finish(self) -> None:
        """See OutputFile."""
        self.take_over()
        super().finish()

    def release(self) -> None:
        """Leave what an earlier run has left, and the record, as they are."""
        self.record.release()

    def keep(self) -> Path:
        """Leave the file to a later run; returns where it is, which is elsewhere if its name is taken."""
        try:
            self.take_over()
        except OSError:
            self.record.remove()  # with it, the next run would remove the file
        self.record.release()
        return self.path

    def remove(self) -> None:
        """Delete the file; what an earlier run has left stays."""
        if self._earlier is None:
            super().remove()
            return
        if self.exists:
            self.path.unlink(missing_ok=True)
        self.release()


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
