"""Local copies of files in storage, for the time of a render."""

from __future__ import annotations

import hashlib
import shutil
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import PurePosixPath

from vidstyle.core.machine.user_cache import user_cache
from vidstyle.errors import OutputError, UsageError, log, output_error
from vidstyle.media.read.sequence import is_pattern
from vidstyle.media.storage import StoredFile, is_stored
from vidstyle.media.write.temporary_files import FileLock

LOCK_NAME = "lock"


@dataclass
class StoredFilm:
    """Names of a render, of which one or both are in storage.

    Attributes:
        source, target: as the user has given them; `target` names a file.
        overwrite: whether the target may exist.
    """

    source: str
    target: str
    overwrite: bool

    def __post_init__(self) -> None:
        """Check the names.

        Raises:
            UsageError: the target exists, or a name stands for many files.
            OutputError: the storage of the target does not answer.
        """
        if self.target.endswith("/") and is_stored(self.target):
            self.target += PurePosixPath(self.source).name
        for name in (self.source, self.target):
            if is_stored(name) and is_pattern(name):
                raise UsageError(name, "is a pattern, and storage supports single files only")
        self._source = StoredFile(self.source) if is_stored(self.source) else None
        self._target = StoredFile(self.target) if is_stored(self.target) else None
        if self._target and not self.overwrite and self._target.exists():
            raise UsageError(self._target.name, "already exists", "add -y to overwrite it")

    @contextmanager
    def local_names(self, parts: Mapping[str, str], stop: threading.Event) -> Iterator[tuple[str, str]]:
        """Download the source, and yield local names of source and target; call `put` in the block.

        If the block ends without `put`, the next run continues with the local files.

        Args:
            parts: everything that determines the result, except the source.
            stop: set it to end early.

        Raises:
            UsageError: another run makes the same result.
            InputError: the source cannot be read.
            OutputError: the local disk has no room.
        """
        version = self._source.version() if self._source else ""
        key = repr((self.source, version, self.target, sorted(parts.items())))
        self._folder = user_cache() / "storage" / hashlib.sha256(key.encode()).hexdigest()[:32]
        lock = self._locked()
        try:
            source = self._fetched(self._source, stop) if self._source else self.source
            self._result = self._folder / PurePosixPath(self.target).name
            yield source, str(self._result) if self._target else self.target
        finally:
            lock.release()

    def put(self) -> None:
        """Upload the result, and remove the local files; raises OutputError."""
        if self._target:
            log.info("%s is written", self._target.name)
            self._target.put(self._result, self.overwrite)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _locked(self) -> FileLock:
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            (self._folder / LOCK_NAME).touch()
            return FileLock(self._folder / LOCK_NAME)
        except BlockingIOError:
            raise UsageError(self.target, "is being written by another run") from None
        except OSError as error:
            raise output_error(self._folder, error) from error

    def _fetched(self, source: StoredFile, stop: threading.Event) -> str:
        """The local copy of the source."""
        name = PurePosixPath(self.source).name
        path = self._folder / "source" / name
        if not path.exists():
            log.info("%s is downloaded", source.name)
            path.parent.mkdir(exist_ok=True)

            def check() -> None:
                if stop.is_set():
                    raise OutputError(self.target, "was not started: stopped")

            part = self._folder / "part"
            source.fetch(part, check)
            part.replace(path)
        return str(path)
