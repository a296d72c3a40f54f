"""Fonts that are installed, for letters that the font at hand has not."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from vidstyle.comic.font import Letters
from vidstyle.errors import InputError

FOLDERS = (
    "$XDG_DATA_HOME/fonts",
    "~/.local/share/fonts",
    "~/.fonts",
    "/usr/local/share/fonts",
    "/usr/share/fonts",
    "~/Library/Fonts",
    "/Library/Fonts",
    "/System/Library/Fonts",
    "$WINDIR/Fonts",
)
"""Where systems keep them; one whose variable is not set is not there."""

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


def letters_for(texts: Iterable[str], letters: Letters) -> Letters:
    """The font at hand, or where it is the built-in one and lacks letters, an installed one that has more."""
    if letters.path is not None:
        return letters
    wanted = "".join(texts)
    best, fewest = letters, len(letters.missing(wanted))
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
    folders = (Path(os.path.expanduser(os.path.expandvars(folder))) for folder in FOLDERS)
    found = {
        file
        for folder in folders
        if folder.is_absolute()
        for file in folder.rglob("*")
        if file.suffix.lower() in _ENDINGS
    }
    yield from sorted(found, key=lambda file: (_dislike(file.stem.lower()), file.name, str(file)))


def _dislike(name: str) -> int:
    plain = name.replace("sansserif", "sans")
    return 2 * sum(part in plain for part in _DISLIKED) - sum(part in plain for part in _LIKED)
