"""Fonts that are installed, for letters that the font at hand has not."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path

from vidstyle.comic.font import Letters
from vidstyle.errors import InputError

FOLDERS: Sequence[Path] = (
    Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share") / "fonts",
    Path.home() / ".fonts",
    Path("/usr/local/share/fonts"),
    Path("/usr/share/fonts"),
    Path.home() / "Library/Fonts",
    Path("/Library/Fonts"),
    Path("/System/Library/Fonts"),
    Path(os.environ.get("WINDIR", "C:/Windows")) / "Fonts",
)
"""Where systems keep them."""

_ENDINGS = (".ttf", ".otf", ".ttc")
_MOST = 400
"""Files that are looked into."""
_LIKED = ("comic", "sans", "regular")
_DISLIKED = (
    "bold",
    "italic",
    "oblique",
    "mono",
    "serif",
    "light",
    "thin",
    "condensed",
    "black",
    "math",
    "symbol",
)
"""Parts of names of fonts that suit a comic, and that do not."""

_log = logging.getLogger("vidstyle")


def letters_for(texts: Iterable[str], path: Path | None) -> Letters:
    """The font of a file, or the one that Pillow brings; where that lacks letters, an installed one.

    Raises:
        InputError: the file is no font.
    """
    letters, wanted = Letters(path), "".join(texts)
    best, fewest = letters, len(letters.missing(wanted))
    if path is not None:
        return letters
    for file in islice(_files(), _MOST) if fewest else ():
        try:
            found = Letters(file)
        except InputError:
            continue
        if (count := len(found.missing(wanted))) < fewest:
            best, fewest = found, count
        if not fewest:
            break
    if best is not letters:
        _log.info("the font %s has letters that the built-in one lacks: it is used", best.family)
    return best


def _files() -> Iterator[Path]:
    """Files of fonts, those first that suit."""
    found = {file for folder in FOLDERS for file in folder.rglob("*") if file.suffix.lower() in _ENDINGS}
    yield from sorted(found, key=lambda file: (_dislike(file.stem.lower()), file.name, str(file)))


def _dislike(name: str) -> int:
    plain = name.replace("sansserif", "sans")
    return 2 * sum(part in plain for part in _DISLIKED) - sum(part in plain for part in _LIKED)
