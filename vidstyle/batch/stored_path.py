"""Names of films in storage, with the methods of `Path` that a batch needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from vidstyle.media.read.open import redact_url
from vidstyle.media.storage import StoredFile, is_stored


@dataclass(frozen=True)
class StoredPath:
    """The name of a file or a folder in storage, which need not exist.

    Its text, for messages and summaries, has no user name and no query.

    Attributes:
        url: as the user has given it.
    """

    url: str

    def __str__(self) -> str:
        return redact_url(self.url)

    @property
    def name(self) -> str:
        """See Path."""
        return PurePosixPath(self.url).name

    @property
    def stem(self) -> str:
        """See Path."""
        return PurePosixPath(self.url).stem

    @property
    def parent(self) -> StoredPath:
        """See Path."""
        return StoredPath(self.url.rstrip("/").rpartition("/")[0])

    def resolve(self) -> StoredPath:
        """See Path."""
        return self

    def absolute(self) -> StoredPath:
        """See Path."""
        return self

    def exists(self) -> bool:
        """See Path; raises OutputError if the storage does not answer."""
        return self.file().exists()

    def unlink(self, missing_ok: bool = False) -> None:
        """See Path; raises OutputError."""
        if not missing_ok or self.exists():
            self.file().remove()

    def file(self) -> StoredFile:
        """Return access to the file; raises UsageError."""
        return StoredFile(self.url)

    def matches(self) -> Iterator[StoredPath]:
        """Yield the files that match this pattern, or are in this folder and its subfolders.

        Raises:
            InputError: the storage does not answer.
            UsageError: the storage cannot list names.
        """
        return map(StoredPath, self.file().matches())


FilmPath = Path | StoredPath


def film_path(name: str) -> FilmPath:
    """Return a name as a path on this machine or in storage."""
    return StoredPath(name) if is_stored(name) else Path(name)


def argument_of(path: FilmPath) -> str:
    """Return a path as an argument of `vidstyle`."""
    return path.url if isinstance(path, StoredPath) else str(path)
