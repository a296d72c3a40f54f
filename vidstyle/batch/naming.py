"""The names of results: a template with fields, filled in for each film and style."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping

from vidstyle.batch.inputs import Source
from vidstyle.batch.stored_path import FilmPath, StoredPath, film_path
from vidstyle.errors import UsageError, suggest

SOURCE_FIELDS = ("name", "folder")
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
    values = {**_source_values(source), "style": style_word(style)}
    path = _filled("--output", template, values)
    is_folder = path.endswith(("/", os.sep)) or os.path.isdir(path)
    return film_path(os.path.join(path, source.path.name) if is_folder else path)


def has_fields(text: str) -> bool:
    """Whether a text has fields in braces."""
    return bool(_FIELD.search(text))


def source_text(option: str, text: str, source: Source) -> str:
    """Return a text with {name} and {folder} of a source; raises UsageError for other fields of `option`."""
    return _filled(option, text, _source_values(source))


def _source_values(source: Source) -> dict[str, str]:
    return dict(zip(SOURCE_FIELDS, (source.path.stem, source.folder), strict=True))


def _filled(option: str, template: str, values: Mapping[str, str]) -> str:
    for word in _FIELD.findall(template):
        if word not in values:
            raise UsageError(option, f"there is no field {{{word}}}", suggest(word, list(values)))
    return _FIELD.sub(lambda field: values[field[1]], template)


def style_word(style: str) -> str:
    """Return the name of a style, of several, or of a cue file as a part of a file name.

    >>> style_word("ink:blue"), style_word("my/own.toml:red"), style_word("ink,noir")
    ('ink-blue', 'own-red', 'ink-noir')
    """
    return "-".join(
        os.path.basename(each.strip()).replace(".toml", "").replace(":", "-") for each in style.split(",")
    )


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
