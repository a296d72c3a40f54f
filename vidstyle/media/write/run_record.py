"""The record of a run, next to its unfinished output: its process, its inputs and its progress."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vidstyle.core.file_checks import read_regular_file
from vidstyle.errors import OutputError, UsageError, log, output_error
from vidstyle.media.write.temporary_files import (
    FileIdentity,
    FileLock,
    create_temporary,
    is_temporary,
    lock_owner,
    partial_path,
    rename_to_new,
)

RESTART_REMEDY = "-y starts again"
MAX_RECORD_BYTES = 2**28
MAX_ATTEMPTS, ATTEMPT_SECONDS = 50, 0.02
"""Number of attempts, and pause between them, for a locked record whose owner is about to release it."""
CHECKPOINT_SECONDS = 0.25
"""Minimum time between two checkpoints of a file."""
READ_BYTES = 2**20

RecordEntry = dict[str, Any]


@dataclass(frozen=True)
class Fingerprint:
    """Everything that determines the pictures and packets of a film.

    Attributes:
        parts: a text for each part, by names that users know ("source", "style", "crf").
        resume: whether to continue the unfinished output of an earlier run of the same parts.
    """

    parts: Mapping[str, str]
    resume: bool = False

    def check(self, record: RunRecord, left: Path) -> None:
        """Raise UsageError if an earlier run has different parts; `left`: its output, for messages."""
        earlier = record.parts
        names = [name for name in {**self.parts, **earlier} if self.parts.get(name) != earlier.get(name)]
        if names:
            reason = f"was started with another {', '.join(names)}"
            raise UsageError(left, reason, f"use the same to resume it; {RESTART_REMEDY}")


class RunRecord:
    """`name.mp4.partial.jsonl` next to `name.mp4`: locked during a run, removed at its success.

    Each line is a JSON object. The first names the target, so that no other file is mistaken for a record.

    Attributes:
        path: path of the record.
        is_left: whether it is from an earlier run.
        parts: fingerprint of the earlier run; empty if unknown.
        entries: later entries of the earlier run.
    """

    def __init__(self, target: Path) -> None:
        """Create the record, or reuse the record of an earlier run, and lock it.

        Raises:
            UsageError: another run has locked it, or a file of this name is not a record of the target.
            OutputError: it cannot be created.
        """
        self.path, self._target = record_path(target), target
        self.is_left, self._is_held = False, True
        self.parts: Mapping[str, str] = {}
        self.entries: list[RecordEntry] = []
        try:
            self._lock = self._claim()
            if self.is_left:
                self._read()
        except FileNotFoundError:
            raise OutputError(target, "its folder does not exist", "add --parents to create it") from None
        except UsageError:
            raise
        except OSError as error:
            raise output_error(target, error) from error

    def _claim(self) -> FileLock:
        for attempt in itertools.count():
            lock = self._create() or self._lock_earlier(may_wait=attempt < MAX_ATTEMPTS)
            if lock is not None:
                return lock
            time.sleep(ATTEMPT_SECONDS)
        raise AssertionError

    def _create(self) -> FileLock | None:
        """Create and lock a record, whose name appears with its first line; return None if one exists."""
        path, _ = create_temporary(self.path, _to_line(self._first_entry))
        try:
            lock = FileLock(path)
            rename_to_new(path, self.path)
        except FileExistsError:
            return None
        finally:
            path.unlink(missing_ok=True)
        return lock

    def _lock_earlier(self, may_wait: bool) -> FileLock | None:
        """Lock an existing record; return None if its run is about to end, and `may_wait`."""
        try:
            if read_entries(self.path)[:1] != [self._first_entry]:
                raise unknown_file_error(self.path)
            lock = FileLock(self.path)
        except FileNotFoundError:
            return None
        except BlockingIOError:
            owner = lock_owner(self.path)
            if owner is None and may_wait:
                return None
            reason = f"is being written by {owner or 'another run'}"
            raise UsageError(self._target, reason, "wait for its end, or choose another name") from None
        # Between opening and locking, the run that held it may have removed it.
        if not lock.identity.is_at(self.path):
            lock.release()
            return None
        self.is_left = True
        return lock

    def _read(self) -> None:
        entries = read_entries(self.path)
        for entry in entries:
            name = entry.get("temporary")
            if isinstance(name, str) and is_temporary(name):
                self.path.with_name(name).unlink(missing_ok=True)
        for number, entry in enumerate(entries):
            if isinstance(entry.get("parts"), dict):
                self.parts, self.entries = entry["parts"], entries[number + 1 :]

    @property
    def _first_entry(self) -> RecordEntry:
        return {"unfinished output of vidstyle": self._target.name}

    def append(self, **entry: object) -> None:
        """Add a line.

        Raises:
            OutputError: the record was removed or replaced.
            OSError: it cannot be written.
        """
        if not (self._is_held and self._lock.identity.is_at(self.path)):
            raise OutputError(self._target, f"{self.path.name} was removed or replaced while it was written")
        # So this line is complete even if an earlier run was killed while it wrote the previous line.
        self._lock.append(self.path, b"\n" + _to_line(entry))

    def begin(self, parts: Mapping[str, str]) -> None:
        """Record the fingerprint of a new run; earlier entries become invalid."""
        self.append(parts=dict(parts))
        self.parts, self.entries = dict(parts), []

    def create_temporary(self, target: Path) -> tuple[Path, FileIdentity]:
        """Create a file with a random name next to a target; if this run is killed, the next removes it."""
        path, identity = create_temporary(target)
        try:
            self.append(temporary=path.name)
        except OSError:
            path.unlink(missing_ok=True)
            raise
        return path, identity

    def add_written(self, path: Path, name: str) -> None:
        """Record a complete file before it is renamed; raise OSError if that fails."""
        self.append(written=_signature(path, name))

    def written(self) -> set[str]:
        """Return the files that the earlier run recorded with `add_written`, for `is_written`."""
        return {str(entry.get("written")) for entry in self.entries}

    def verified_bytes(self, path: Path) -> int | None:
        """Count the leading bytes of a file that are unchanged since the earlier run.

        Returns:
            None if it is another file, 0 if only its header is verified.
        """
        if is_written(path, self.written()):
            return path.stat().st_size
        marks = sorted(
            mark for entry in self.entries if (mark := entry.get("checkpoint")) and _is_checkpoint(mark)
        )
        found = None
        with path.open("rb") as file:
            for start, group in itertools.groupby(marks, key=lambda mark: mark[0]):
                file.seek(start)
                digest = hashlib.sha256()
                for _, end, expected in group:
                    _update_digest(digest, file, end - file.tell())
                    if file.tell() == end and digest.hexdigest() == expected:
                        found = max(found or 0, end if start else 0)
        return found

    def remove(self) -> None:
        """Delete the record, unless it was released to the next run."""
        if self._is_held and self._lock.identity.is_at(self.path):
            self.path.unlink(missing_ok=True)
        self.release()

    def release(self) -> None:
        """Keep the record for the next run."""
        self._is_held = False
        self._lock.release()

    def release_unused(self) -> None:
        """Keep the record of an earlier run; delete a new one."""
        self.release() if self.is_left else self.remove()


class Checkpoints:
    """Digests of a growing file, in its record, which a killed run leaves for the next one.

    The first data in the file is its header. Muxers change it when they close the file, so it has a separate
    digest; everything after it is only appended.
    """

    def __init__(self, record: RunRecord, path: Path) -> None:
        self._record = record
        self._file = path.open("rb")
        self._digest = hashlib.sha256()
        self._start = self._end = 0
        self._due = 0.0

    def update(self, is_last: bool = False) -> None:
        """Add a checkpoint if the file has grown and the interval has passed, or if this is the last.

        Raises:
            OSError: the record cannot be written.
        """
        size = os.fstat(self._file.fileno()).st_size
        if size <= self._end or not (is_last or time.monotonic() >= self._due):
            return
        _update_digest(self._digest, self._file, size - self._end)
        self._record.append(checkpoint=[self._start, size, self._digest.hexdigest()])
        if self._end == 0:
            self._digest, self._start = hashlib.sha256(), size
        else:
            self._due = time.monotonic() + CHECKPOINT_SECONDS
        self._end = size

    def close(self) -> None:
        """Add the last checkpoint; if that fails, a later run continues from the previous one."""
        if self._file.closed:
            return
        try:
            self.update(is_last=True)
        except OSError as error:
            log.debug("%s: %s", self._record.path, error)
        self._file.close()  # Windows could not rename it otherwise


def is_written(path: Path, written: set[str]) -> bool:
    """Whether a run has written this file, by its size and modification time."""
    return path.exists() and _signature(path, path.name) in written


def _signature(path: Path, name: str) -> str:
    status = path.stat()
    return f"{status.st_size} {status.st_mtime_ns} {name}"


def _update_digest(digest: Any, file: Any, count: int) -> None:
    while count > 0 and (content := file.read(min(count, READ_BYTES))):
        digest.update(content)
        count -= len(content)


def _is_checkpoint(mark: object) -> bool:
    kinds = [type(each) for each in mark] if isinstance(mark, list) else []
    return kinds == [int, int, str] and 0 <= mark[0] <= mark[1] < 2**62  # type: ignore[index]


def _to_line(entry: Mapping[str, object]) -> bytes:
    return json.dumps(entry).encode()


def read_entries(path: Path) -> list[RecordEntry]:
    """Return the lines of a record that are JSON objects; none if it is not a file or too large.

    Raises:
        OSError: the record cannot be read.
    """
    try:
        content = read_regular_file(path, MAX_RECORD_BYTES)
    except ValueError:
        return []
    return parse_entries(content)


def parse_entries(content: bytes) -> list[RecordEntry]:
    """Return the lines of a record, or of a part of it, that are JSON objects."""
    return [entry for line in content.splitlines() if isinstance(entry := _parse_line(line), dict)]


def _parse_line(line: bytes) -> object:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


def record_path(target: Path) -> Path:
    """Return the path of the record of an unfinished target.

    >>> record_path(Path("a.mp4")).name
    'a.mp4.partial.jsonl'
    """
    return partial_path(target.with_name(target.name + ".jsonl"))


def is_being_written(target: Path) -> bool:
    """Whether a running process writes this target."""
    try:
        FileLock(record_path(target)).release()
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def unknown_file_error(path: Path) -> UsageError:
    """Return the error for an existing file that is not from an earlier run, or was changed since."""
    return UsageError(path, "exists and is not an unfinished output of this name", "rename or remove it")


def earlier_run_error(left: Path, held: str, record: RunRecord) -> UsageError:
    """Return the error for the output of an earlier run, which must not be lost.

    Args:
        left: the file.
        held: description of its content.
        record: record of the earlier run.
    """
    remedy = (
        f"--resume continues it, {RESTART_REMEDY}"
        if record.parts
        else f"rename it to keep it; {RESTART_REMEDY}"
    )
    return UsageError(left, f"holds {held} of an earlier run", remedy)
