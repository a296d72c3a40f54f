"""Selects the writer for a target."""

from __future__ import annotations

import os
from pathlib import Path

from vidstyle.errors import OutputError, UsageError
from vidstyle.media.options import VideoInfo, WriteOptions
from vidstyle.media.read.reader import Reader
from vidstyle.media.write.atomic import is_regular_file, resolve_path
from vidstyle.media.write.base import Writer
from vidstyle.media.write.containers import find_kind
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.media.write.gif import GifWriter
from vidstyle.media.write.images import PictureWriter, is_numbered, numbered_path
from vidstyle.media.write.run_record import Fingerprint, record_path
from vidstyle.media.write.temporary_files import partial_path

__all__ = ["WriteOptions", "Writer", "open_writer"]


def open_writer(
    target: str | Path,
    info: VideoInfo,
    options: WriteOptions,
    source: Reader | None = None,
    fingerprint: Fingerprint | None = None,
) -> Writer:
    """Open a writer for the target; check everything possible before the first frame is decoded.

    Args:
        target: a path whose extension selects the format; `%05d.png` for one file per picture; "-" for
            standard output, which needs `options.format`.
        info: description of the video.
        options: how to write.
        source: the source, whose other streams, chapters and tags are copied.
        fingerprint: everything that determines the result, for resuming an earlier run, or this run later.

    Raises:
        UsageError: the target exists, is the input, or does not support the options.
        OutputError: its folder is missing or not writable.
    """
    kind = find_kind(str(target), options.format, info.still or is_numbered(str(target)))
    writers: dict[str, type[Writer]] = {"picture": PictureWriter, "gif": GifWriter, "film": FilmWriter}
    return writers[kind.way](target, kind, info, options, source, fingerprint)


def file_in_folder(target: str | Path, source: str | Path) -> str | Path:
    """Return the target, or, if it is a folder, the file in it with the name of the source.

    Raises:
        UsageError: the target is a folder, and the source is not a file.
        OutputError: the target ends in a slash, and there is no such folder.
    """
    path, name = Path(target), Path(source).name
    if str(target) == "-" or not os.path.isdir(path):
        if str(target).endswith(("/", os.sep)):
            raise OutputError(target, "is not an existing folder", "add --parents to create it")
        return target
    if str(source) == "-" or not os.path.isfile(source):
        raise UsageError(target, "is a folder", f"name a file in it, such as {path / 'film.mp4'}")
    return path / name


def is_resumable(target: str | Path, options: WriteOptions) -> bool:
    """Whether an unfinished target can be resumed: films in most containers, and numbered pictures.

    Raises:
        UsageError: its extension is unknown.
    """
    if str(target) == "-" or not is_regular_file(Path(target)):
        return False
    kind = find_kind(str(target), options.format, False)
    return kind.resumable and (kind.way == "film" or is_numbered(str(target)))


def is_finished(target: str | Path) -> bool:
    """Whether a resumable target exists and is finished."""
    path = resolve_path(Path(target))
    if is_numbered(str(target)):
        return numbered_path(str(path), 1).exists() and not record_path(path).exists()
    partial = partial_path(path)
    # A run that is killed while it renames its film leaves it under both names.
    return path.exists() and (not partial.exists() or path.samefile(partial))
