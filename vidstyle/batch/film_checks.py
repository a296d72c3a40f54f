"""Checks whether a film of a batch is finished, and whether its target may be written."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from vidstyle.batch.batch_film import BatchFilm, State
from vidstyle.batch.journal import Parts, content_digest
from vidstyle.batch.resources import missing_space
from vidstyle.batch.stored_path import StoredPath
from vidstyle.errors import InputError, OutputError, UsageError, VidstyleError, error_reason, output_error
from vidstyle.media.write.temporary_files import partial_path

FINISHED = "is finished"
"""Reason for skipping a film."""


def parts_of(film: BatchFilm, is_stopped: Callable[[], bool] = lambda: False) -> Parts:
    """Return everything that determines the result; read the source if the journal does not have its digest.

    A source in storage is not read: its properties replace the digest.

    Args:
        is_stopped: called repeatedly while the source is read; returns whether to stop.

    Raises:
        InterruptedError: stopped.
        InputError: the source cannot be read.
    """
    source = film.source.path
    if isinstance(source, StoredPath):
        return {"source": source.file().version(), **film.settings}
    try:
        digest = film.journal.source_digest(film.target, source) or content_digest(source, is_stopped)
    except InterruptedError:
        raise
    except FileNotFoundError:
        raise InputError(source, "no such file") from None
    except (OSError, ValueError) as error:
        raise InputError(source, f"cannot be read ({error_reason(error)})") from error
    return {"source": digest, **film.settings}


def preview(film: BatchFilm, overwrite: bool) -> None:
    """Set the state of a film to what a batch would do with it, unless it has failed already."""
    try:
        if film.has_ended or not film.target.exists():
            return
        parts = parts_of(film)
        if film.journal.is_finished(film.target, parts):
            film.end(State.SKIPPED, FINISHED)
        elif not overwrite:
            raise existing_target(film, parts)
    except VidstyleError as error:
        film.end(State.FAILED, str(error), error.exit_code)


def check_target(
    film: BatchFilm, parts: Parts, overwrite: bool, films: Iterable[BatchFilm], copies: int
) -> None:
    """Create the folder of the target, and check that the target may be written.

    Args:
        parts: see `parts_of`.
        overwrite: whether the target may exist.
        films: all films of the batch; films in progress also need disk space.
        copies: disk space of a film, as a multiple of the size of its source.

    Raises:
        UsageError: the target exists.
        OutputError: the disk space does not suffice, or the folder is missing.
    """
    if film.target.exists() and not overwrite:
        raise existing_target(film, parts)
    if isinstance(film.target, StoredPath):
        return
    try:
        film.target.parent.mkdir(parents=True, exist_ok=True)
        reserved = [
            (each.target, copies * _bytes_left(each, each.target))
            for each in films
            if each.state is State.RUNNING and isinstance(each.target, Path)
        ]
        missing = missing_space(film.target, copies * film.source_bytes, reserved)
    except OSError as error:
        raise output_error(film.target, error) from error
    if missing:
        raise OutputError(film.target, missing)


def existing_target(film: BatchFilm, parts: Parts) -> UsageError:
    """Return the error for an existing target that is not the result of this film."""
    changed = film.journal.changed_parts(film.target, parts)
    origin = f", made with another {', '.join(changed)}" if changed else ""
    return UsageError(film.target, f"already exists{origin}", "add -y to replace it")


def _bytes_left(film: BatchFilm, target: Path) -> int:
    """Return the expected number of bytes that are still to be written for a film in progress."""
    try:
        return max(0, film.source_bytes - partial_path(target).stat().st_size)
    except OSError:
        return film.source_bytes


def source_signature(film: BatchFilm) -> tuple[int, int] | str | None:
    """Return size and modification time of the source; None if it does not exist.

    In storage: a digest of all its properties.

    Raises:
        InputError: the storage does not answer.
    """
    source = film.source.path
    if isinstance(source, StoredPath):
        return source.file().version()
    try:
        status = source.stat()
    except OSError:
        return None
    return status.st_size, status.st_mtime_ns
