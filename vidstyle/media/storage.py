"""Files in storage, such as s3://bucket/film.mp4: downloaded to a local file, and uploaded from one.

A film is downloaded before it is read: a style needs all of it, each range is requested once, and a failure
of the storage ends the run, which a decoder would treat as damage of the film.
"""

from __future__ import annotations

import glob
import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from vidstyle.errors import InputError, OutputError, UsageError, VidstyleError
from vidstyle.media.read.open import is_url, redact_url
from vidstyle.media.write.atomic import MIN_FREE_BYTES

STORAGE_SCHEMES = ("abfs", "az", "gcs", "gs", "hdfs", "oci", "oss", "s3", "sftp", "smb", "webdav")
"""Schemes of fsspec that name files in storage; each needs a separate package."""
EXCLUSIVE_SCHEMES = ("gcs", "gs", "s3")
"""Storages in which a file appears when it is complete, and which can refuse to replace a file."""
BLOCK_BYTES = 2**24
"""Bytes per request: a film of an hour takes some hundred requests."""
ACCESS_FIELDS = frozenset({"time", "accessTime", "last_accessed_on"})
"""Properties that change when a file is read: of `sftp` and `smb`, `webhdfs`, and `abfs`."""
MAX_LETTERS = 200


def is_stored(name: object) -> bool:
    """Whether a name refers to a file in storage."""
    return is_url(name) and str(name).partition("://")[0].lower() in STORAGE_SCHEMES


class StoredFile:
    """A file in storage, which need not exist; credentials come from the environment.

    Attributes:
        name: for messages and lists.
    """

    def __init__(self, url: str) -> None:
        """Name the file.

        Raises:
            UsageError: a package is missing, or the name holds a password.
        """
        self.name, self._scheme = redact_url(url), url.partition("://")[0].lower()
        self._url = url
        if ":" in url.partition("://")[2].partition("/")[0].rpartition("@")[0]:
            raise UsageError(self.name, "holds a password", "give it in the environment")
        try:
            from fsspec.core import url_to_fs

            self._files, self._path = url_to_fs(url, skip_instance_cache=True, use_listings_cache=False)
        except ImportError as error:
            remedy = "pip install 'vidstyle[cloud]', and the package for this kind of storage"
            raise UsageError(self.name, f"needs a package: {_line(error)}", remedy) from error
        except Exception as error:  # each storage has different exceptions
            raise UsageError(self.name, f"cannot be used: {_line(error)}") from error

    def exists(self) -> bool:
        """Whether it is there; raises OutputError."""
        with self._reported(OutputError, "found"):
            return self._files.exists(self._path)

    def version(self) -> str:
        """Return a digest of its checksum, size, modification time and the rest; raises InputError."""
        with self._reported(InputError, "read"):
            facts = self._files.info(self._path).items()
            kept = sorted((name, str(value)) for name, value in facts if name not in ACCESS_FIELDS)
            return hashlib.sha256(repr(kept).encode()).hexdigest()

    def matches(self) -> list[str]:
        """Return the names of the files that match this pattern, or are in this folder and its subfolders.

        Raises:
            InputError: the storage does not answer.
            UsageError: its names do not end as the storage lists them.
        """
        prefix = self._url.rstrip("/").removesuffix(self._path)
        if prefix == self._url.rstrip("/"):
            raise UsageError(self.name, "cannot be listed", "name its films in a list")
        with self._reported(InputError, "listed"):
            if glob.has_magic(self._path):
                found = self._files.glob(self._path, detail=True)
                paths = [path for path, facts in found.items() if facts["type"] == "file"]
            else:
                paths = self._files.find(self._path)
        return [prefix + path for path in sorted(paths)]

    def remove(self) -> None:
        """Remove the file; raises OutputError."""
        with self._reported(OutputError, "removed"):
            self._files.rm(self._path)

    def fetch(self, path: Path, check: Callable[[], None]) -> None:
        """Download the content to a local file; continue a partial download.

        Args:
            path: of the local file.
            check: called before each request; may raise.

        Raises:
            InputError: it cannot be read, or changed during the download.
            OutputError: the disk space does not suffice.
        """
        version = self.version()
        with self._reported(InputError, "read"):
            size = self._files.info(self._path)["size"]
            with open(path, "ab") as file:
                file.truncate(min(file.tell(), size) // BLOCK_BYTES * BLOCK_BYTES)
                start = file.seek(0, os.SEEK_END)
                _check_room(path, size - start)
                while start < size:
                    check()
                    start += file.write(self._block(start, min(start + BLOCK_BYTES, size)))
        if self.version() != version:
            path.unlink()
            raise InputError(self.name, "was changed while it was read", "run the command again")

    def put(self, path: Path, overwrite: bool) -> None:
        """Upload a local file; the name appears when the content is complete.

        Args:
            overwrite: whether a file of this name is replaced.

        Raises:
            OutputError: it cannot be written, or there is such a file.
        """
        with self._reported(OutputError, "written", f"{path} is kept, and --resume tries again"):
            if self._scheme in EXCLUSIVE_SCHEMES:
                self._files.put_file(str(path), self._path, mode="overwrite" if overwrite else "create")
            else:
                self._put_and_rename(path, overwrite)
            sent, stored = path.stat().st_size, self._files.info(self._path)["size"]
            if sent != stored:
                raise OutputError(self.name, f"has {stored} bytes after {sent} were written")

    def _put_and_rename(self, path: Path, overwrite: bool) -> None:
        temporary = f"{self._path}.vidstyle-{uuid4().hex}"
        try:
            self._files.put_file(str(path), temporary)
            if not overwrite and self._files.exists(self._path):
                raise FileExistsError
            self._files.mv(temporary, self._path)
        except BaseException:
            with suppress(Exception):
                self._files.rm(temporary)
            raise

    def _block(self, start: int, end: int) -> bytes:
        block = self._files.cat_file(self._path, start=start, end=end)
        if len(block) != end - start:
            raise InputError(self.name, f"has given {len(block)} of {end - start} bytes", "run it again")
        return block

    @contextmanager
    def _reported(
        self, kind: type[InputError] | type[OutputError], action: str, remedy: str = ""
    ) -> Iterator[None]:
        """Report all exceptions of the storage in one line."""
        try:
            yield
        except VidstyleError:
            raise
        except FileNotFoundError:
            reason = "no such file" if kind is InputError else "its bucket or folder does not exist"
        except FileExistsError:
            reason = "has appeared meanwhile, and is not overwritten"
        except Exception as error:  # each storage has different exceptions
            reason = f"cannot be {action}: {_line(error)}"
        else:
            return
        raise kind(self.name, reason, remedy)


def _check_room(path: Path, needed: int) -> None:
    free = shutil.disk_usage(path.parent).free - MIN_FREE_BYTES
    if free < needed:
        reason = f"needs {needed >> 20} MB, and {max(free, 0) >> 20} MB are free"
        raise OutputError(path.parent, reason, "set XDG_CACHE_HOME to a folder on another disk")


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:MAX_LETTERS] or type(error).__name__
