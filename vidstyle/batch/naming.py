"""The names of results: a template with fields, filled in for each film and style."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable

from vidstyle.batch.inputs import Source
from vidstyle.batch.stored_path import FilmPath, StoredPath, film_path
from vidstyle.errors import UsageError, suggest

FIELDS = ("name", "folder", "style")
_FIELD = re.compile(r"\{([^{}]*)\}")


def result_path(template: str, source: Source, style: str) -> FilmPath:
    """Return the name of a result.

    Args:
        template: name with {name}, {folder} and {style}; in a folder, a result keeps the source's file name.
        style: name of a style, or a style file.

    Raises:
        UsageError: there is no such field.

    >>> from pathlib import Path
    >>> source = Source(Path("clips/a.mov"), "clips")
    >>> result_path("out/{folder}/{name}-{style}.mp4", source, "ink:blue").as_posix()
    'out/clips/a-ink-blue.mp4'
    """
    values = {"name": source.path.stem, "folder": source.folder, "style": style_word(style)}
    for word in _FIELD.findall(template):
        if word not in values:
            raise UsageError("--output", f"there is no field {{{word}}}", suggest(word, FIELDS))
    path = _FIELD.sub(lambda field: values[field[1]], template)
    is_folder = path.endswith(("/", os.sep)) or os.path.isdir(path)
    return film_path(os.path.join(path, source.path.name) if is_folder else path)


def style_word(style: str) -> str:
    """Return the name of a style as a part of a file name.

    >>> style_word("ink:blue"), style_word("my/own.toml"), style_word("my/own.toml:red")
    ('ink-blue', 'own', 'own-red')
    """
    return os.path.basename(style).replace(".toml", "").replace(":", "-")


def check_names(results: Iterable[tuple[FilmPath, Source, str]]) -> None:
    """Check the names of all results.

    Args:
        results: name, source and style of each result.

    Raises:
        UsageError: two results have the same name, or one has the name of a source.
    """
    results = list(results)
    sources = {source.path.resolve() for _, source, _ in results}
    taken: dict[object, tuple[Source, str]] = {}
    for target, source, style in results:
        place = target.resolve()
        if place in sources:
            raise UsageError(target, "is an input, and would be overwritten", "choose another --output")
        # Many file systems ignore case.
        key = place if isinstance(place, StoredPath) else str(place).casefold()
        other, other_style = taken.setdefault(key, (source, style))
        if other != source:
            reason = f"would be the result of both {other.path} and {source.path}"
            raise UsageError(target, reason, "use {name} and {folder} in --output")
        if other_style != style:
            reason = f"would be the result of both --style {other_style} and --style {style}"
            raise UsageError(target, reason, "use {style} in --output")
