"""The journal of a folder: its results of batches, and their sources and settings."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vidstyle.batch.stored_path import FilmPath, StoredPath
from vidstyle.core.file_checks import open_regular_file
from vidstyle.core.machine.user_cache import user_cache
from vidstyle.errors import OutputError, VidstyleError, output_error
from vidstyle.media.write.run_record import parse_entries, record_path
from vidstyle.media.write.writer import is_finished

JOURNAL = ".vidstyle-batch.jsonl"
"""File name of the journal in each folder with results."""

MAX_JOURNAL_BYTES = 2**28
"""Maximum number of bytes that are read of a journal at a time: 100,000 results."""

DIGEST_CHUNK_BYTES = 2**20

Parts = Mapping[str, str]
"""Everything that determines a result, by names that users know, as in `Fingerprint`."""


class Journal:
    """`.vidstyle-batch.jsonl`: each line is a JSON object about one result; its last line is valid.

    Several batches may append lines at the same time. Storage cannot append lines, so the journals of its
    folders are in the user's cache folder.
    """

    def __init__(self, folder: FilmPath) -> None:
        if isinstance(folder, StoredPath):
            digest = hashlib.sha256(folder.url.encode()).hexdigest()[:32]
            folder = user_cache() / "batch" / digest
        self._path = folder / JOURNAL
        self._known: dict[str, dict[str, Any]] = {}
        self._read_bytes = 0

    def names(self) -> set[str]:
        """Return the names of all results."""
        return set(self._entries())

    def source_digest(self, target: FilmPath, source: Path) -> str | None:
        """Return the digest of a source at the time of rendering; None if the source has changed since."""
        entry = self._entries().get(target.name, {})
        is_same = entry.get("source file") == [str(source.resolve()), *_signature(source)]
        return entry.get("parts", {}).get("source") if is_same else None

    def is_finished(self, target: FilmPath, parts: Parts) -> bool:
        """Whether the target exists, unchanged since a batch rendered it from the same parts."""
        entry = self._entries().get(target.name)
        if entry is None or entry.get("parts") != dict(parts) or not target.exists():
            return False
        if "result" in entry:
            return entry["result"] == _signature(target)
        if isinstance(target, StoredPath):
            return "begun" in entry and entry.get("before") != _signature(target)
        # The batch was killed after the film was complete, before its line was written.
        is_left = record_path(target).exists() or not is_finished(target)
        return not is_left and target.stat().st_mtime_ns >= entry.get("begun", float("inf"))

    def changed_parts(self, target: FilmPath, parts: Parts) -> list[str]:
        """Return the names of the parts that differ from the parts of the existing target."""
        earlier = self._entries().get(target.name, {}).get("parts", {})
        names = {**parts, **earlier} if earlier else {}
        return [name for name in names if parts.get(name) != earlier.get(name)]

    def begin(self, target: FilmPath, parts: Parts) -> None:
        """Record that rendering of a target starts.

        Raises:
            OutputError: the journal cannot be written.
        """
        entry = {"target": target.name, "parts": dict(parts), "begun": time.time_ns()}
        if isinstance(target, StoredPath) and target.exists():
            entry["before"] = _signature(target)
        self._append(entry)

    def abandon(self, target: FilmPath, parts: Parts) -> None:
        """Record that rendering has failed: a file of this name is no result; raises OutputError."""
        self._append({"target": target.name, "parts": dict(parts)})

    def finish(self, target: FilmPath, parts: Parts, source: FilmPath) -> None:
        """Record that a target is complete.

        Raises:
            OutputError: the journal cannot be written, or the target does not exist.
        """
        try:
            files = {
                "result": _signature(target),
                "source file": [str(source.resolve()), *_signature(source)],
            }
        except VidstyleError:
            raise
        except OSError as error:
            raise OutputError(target, f"was not written completely ({error.strerror})") from error
        self._append({"target": target.name, "parts": dict(parts), **files})

    def _entries(self) -> dict[str, dict[str, Any]]:
        """The last entry of each result; each call reads the new lines."""
        try:
            with open_regular_file(self._path, follows=False) as file:
                start = file.seek(self._read_bytes)
                content = file.read(MAX_JOURNAL_BYTES)
        except (OSError, ValueError):
            return {}
        for entry in filter(_is_entry, parse_entries(content)):
            self._known[entry["target"]] = entry
        # The last line may still be incomplete.
        self._read_bytes = start + content.rfind(b"\n") + 1
        return self._known

    def _append(self, entry: Mapping[str, object]) -> None:
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with open_regular_file(self._path, "ab", follows=False) as file:
                if file.seek(0, os.SEEK_END) and not self._is_journal():
                    raise ValueError("is not a journal of a batch")
                # So this line is complete even if an earlier run was killed while it wrote the previous line.
                file.write(b"\n" + json.dumps(entry).encode())
        except ValueError as error:
            raise OutputError(self._path, str(error), "move it away") from error
        except OSError as error:
            raise output_error(self._path, error) from error

    def _is_journal(self) -> bool:
        """Whether the file begins as a journal, which another batch may just have done, or holds an entry."""
        with open_regular_file(self._path, follows=False) as file:
            return file.read(2) == b"\n{" or bool(self._entries())


def _is_entry(entry: Mapping[str, Any]) -> bool:
    """Whether a line has the types of those that are written here; others are damaged."""
    begun = entry.get("begun", 0)
    return (
        isinstance(entry.get("target"), str) and isinstance(entry.get("parts"), dict) and type(begun) is int
    )


def content_digest(path: Path, is_stopped: Callable[[], bool] = lambda: False) -> str:
    """Return the SHA-256 of a file, in hexadecimal digits.

    Args:
        is_stopped: called repeatedly; returns whether to stop.

    Raises:
        InterruptedError: stopped.
        ValueError: it is a pipe or a device, which may never end.
        OSError: it cannot be read.
    """
    digest = hashlib.sha256()
    with open_regular_file(path) as file:
        while content := file.read(DIGEST_CHUNK_BYTES):
            if is_stopped():
                raise InterruptedError
            digest.update(content)
    return digest.hexdigest()


def _signature(path: FilmPath) -> list[int] | list[str]:
    """Return size in bytes and modification time in nanoseconds; raise OSError if that fails.

    In storage: a digest of all properties of the file.
    """
    if isinstance(path, StoredPath):
        return [path.file().version()]
    status = os.stat(path)
    return [status.st_size, status.st_mtime_ns]
