"""Finds films: files, folders, patterns and lists of files."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from vidstyle.batch.journal import Journal
from vidstyle.batch.stored_path import FilmPath, StoredPath, film_path
from vidstyle.core.file_checks import read_regular_file
from vidstyle.errors import InputError, UsageError, error_reason
from vidstyle.media.write.temporary_files import is_temporary

ENDINGS = frozenset(
    ".3g2 .3gp .asf .avi .dv .flv .m2t .m2ts .m2v .m4v .mkv .mov .mp4 .mpeg .mpg .mts .mxf .nut .ogv .ts "
    ".vob .webm .wmv .y4m".split()
)
"""Extensions of films in a folder."""
LIST_ENDING = ".txt"
"""Extension of a list with one film name per line."""
MAX_LIST_BYTES = 2**26


@dataclass(frozen=True)
class Source:
    """A film to restyle.

    Attributes:
        path: path of the film, as the user would write it.
        folder: value of the field {folder} of an output name.
    """

    path: FilmPath
    folder: str


def find_sources(inputs: Sequence[str]) -> list[Source]:
    """Return the films of the inputs, each one once.

    Args:
        inputs: files, folders, patterns such as "clips/*.mp4", and lists (.txt).

    Raises:
        UsageError: an input names no film.
        InputError: a list or a folder cannot be read.
    """
    found: dict[FilmPath, Source] = {}
    for name in inputs:
        sources = [*_sources(name)]
        if not sources:
            raise UsageError(
                str(film_path(name)), "contains no films", f"their extensions are {' '.join(sorted(ENDINGS))}"
            )
        for source in sources:
            found.setdefault(source.path.resolve(), source)
    return [*found.values()]


def folder_sources(folder: Path) -> Iterator[Source]:
    """Yield the films in a folder and its subfolders, without hidden files and results of a batch.

    Raises:
        InputError: the folder cannot be read.
    """
    top = folder.resolve().name
    for place, folders, names in os.walk(folder, onerror=_refuse):
        folders[:] = sorted(each for each in folders if not each.startswith("."))
        inside = (Path(top) / Path(place).relative_to(folder)).as_posix()
        results = Journal(Path(place)).names()
        yield from (
            Source(Path(place) / name, inside)
            for name in sorted(names)
            if is_film_name(name) and name not in results
        )


def is_film_name(name: str) -> bool:
    """Whether a file in a folder is a film, by its extension; hidden and partial files are not.

    >>> [is_film_name(name) for name in ("a.MP4", ".a.mp4", "a.partial.mp4", "a.jpg")]
    [True, False, False, False]
    """
    stem, ending = os.path.splitext(name)
    is_unfinished = stem.endswith(".partial") or is_temporary(name)
    return ending.lower() in ENDINGS and not name.startswith(".") and not is_unfinished


def _stored_sources(path: StoredPath) -> Iterator[Source]:
    """Yield the films of a name in storage: of a pattern, a film, or else a folder."""
    if glob.has_magic(path.url):
        yield from (Source(each, each.parent.name) for each in path.matches())
    elif is_film_name(path.name):
        yield Source(path, path.parent.name)
    elif path.name.lower().endswith(LIST_ENDING):
        raise UsageError(path, "is a list in storage", "copy it to this machine")
    else:
        for each in path.matches():
            inner = PurePosixPath(each.url.removeprefix(path.url))
            is_hidden = any(part.startswith(".") for part in inner.parts)
            if is_film_name(each.name) and not is_hidden and each.name not in Journal(each.parent).names():
                yield Source(
                    each, str(PurePosixPath(path.name, *inner.relative_to(inner.anchor).parent.parts))
                )


def _sources(name: str, may_be_list: bool = True) -> Iterator[Source]:
    path = film_path(name)
    if isinstance(path, StoredPath):
        yield from _stored_sources(path)
    elif path.is_dir():
        yield from folder_sources(path)
    elif may_be_list and path.suffix.lower() == LIST_ENDING and path.is_file():
        for line in _lines(path):
            place = film_path(line)
            name = line if isinstance(place, StoredPath) else str(path.parent / line)
            yield from _sources(name, may_be_list=False)
    elif os.path.lexists(path) or not glob.has_magic(name):
        yield Source(path, path.resolve().parent.name)
    else:
        for each in sorted(glob.glob(name, recursive=True)):
            yield from _sources(each, may_be_list)


def _lines(path: Path) -> list[str]:
    try:
        text = read_regular_file(path, MAX_LIST_BYTES).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be read ({error_reason(error)})") from error
    return [line.strip() for line in text.splitlines() if line.strip()]


def _refuse(error: OSError) -> None:
    raise InputError(error.filename, f"cannot be read ({error.strerror})") from error
