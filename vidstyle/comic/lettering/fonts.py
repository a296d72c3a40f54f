"""The letters of a comic: their size, what they look like, and how a text is broken into lines."""

from __future__ import annotations

import logging
import os
import unicodedata
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from vidstyle.comic.layout.paper import Paper
from vidstyle.errors import InputError, UsageError

if TYPE_CHECKING:
    from PIL import ImageFont

POINTS = 10.0
"""Size of the letters on paper."""
_ACROSS, _ACROSS_STRIP = 45, 28
"""Letters are no larger than the page's width by the first; on a strip, which is seen on a phone, they are as
large as its width by the second."""
_SMALLEST = 7
"""Pixels."""
_LIKE = {
    "–": "-",
    "—": "-",
    "‐": "-",
    "‑": "-",
    "•": "-",
    "ß": "ss",
    "ẞ": "SS",
    "æ": "ae",
    "œ": "oe",
    "ø": "o",
}
_LIKE |= {
    "Æ": "AE",
    "Œ": "OE",
    "Ø": "O",
    "ł": "l",
    "Ł": "L",
    "đ": "d",
    "ı": "i",
    "«": '"',
    "»": '"',
    "„": '"',
}
"""What a letter that is missing from a font is written as, besides the same without its accent."""
_MARKS, NOTES = "–—‐‑•«»„", "♪♫♩♬"
"""Of these it goes without saying; notes are left out."""


def check_pillow() -> None:
    """Raise UsageError if the library that letters and files come from is missing."""
    try:
        import PIL.ImageFont  # noqa: F401
    except ImportError as error:
        raise UsageError("comic", "Pillow is not installed", "pip install vidstyle[comic]") from error


def letter_size(paper: Paper) -> int:
    """How large the letters on a paper are, in pixels."""
    if paper.is_strip:
        return max(_SMALLEST, paper.width // _ACROSS_STRIP)
    return max(_SMALLEST, round(min(POINTS * paper.dpi / 72, paper.width / _ACROSS)))


class Letters:
    """A font in all sizes.

    Attributes:
        lacking: the letters that texts had and the font has not.
    """

    def __init__(self, path: Path | None = None) -> None:
        """`path`: a TrueType or OpenType font; None: the one that Pillow brings.

        Raises:
            InputError: it is none.
        """
        self.path = path
        self.lacking: dict[str, None] = {}
        self._sizes: dict[int, ImageFont.FreeTypeFont] = {}
        self._known: dict[str, bool] = {}
        self.font(_SMALLEST)

    def font(self, size: int) -> ImageFont.FreeTypeFont:
        """As Pillow has it, so many pixels high."""
        if size not in self._sizes:
            self._sizes[size] = _opened(self.path, size)
        return self._sizes[size]

    @property
    def family(self) -> str:
        """Its name."""
        return str(self.font(_SMALLEST).getname()[0] or "sans-serif")

    @property
    def free_font(self) -> bytes | None:
        """The file of the font that Pillow brings, which everybody may pass on (CC0); None for another."""
        if self.path is not None:
            return None
        file = self.font(_SMALLEST).path
        return file.getvalue() if isinstance(file, BytesIO) else None

    def width(self, text: str, size: int) -> float:
        """Of one line, in pixels."""
        return float(self.font(size).getlength(text))

    def writable(self, text: str) -> str:
        """The text with what comes nearest where the font lacks a letter; notes are left out."""
        shown = "".join(self._written(letter) for letter in unicodedata.normalize("NFC", text))
        return " ".join(shown.split())

    def missing(self, text: str) -> set[str]:
        """The letters of a text that the font has not, and that are written otherwise."""
        return {each for each in unicodedata.normalize("NFC", text) if not self._is_written_as_it_is(each)}

    def _is_written_as_it_is(self, letter: str) -> bool:
        return letter.isspace() or self._has(letter) or letter in _MARKS or letter in NOTES

    def _written(self, letter: str) -> str:
        if letter.isspace() or self._has(letter):
            return letter
        if letter in _MARKS:
            return _LIKE[letter]
        if letter in NOTES:
            return ""
        self.lacking[letter] = None
        plain = _LIKE.get(letter) or "".join(
            part for part in unicodedata.normalize("NFKD", letter) if not unicodedata.combining(part)
        )
        return plain if plain and all(map(self._has, plain)) else letter

    def _has(self, letter: str) -> bool:
        if letter not in self._known:
            font = self.font(20)
            self._known[letter] = bytes(font.getmask(letter)) != bytes(font.getmask("\uffff"))
        return self._known[letter]


def _opened(path: Path | None, size: int) -> ImageFont.FreeTypeFont:
    from PIL import ImageFont

    if path is None:
        font = ImageFont.load_default(size)
        assert isinstance(font, ImageFont.FreeTypeFont)
        return font
    try:
        return ImageFont.truetype(str(path), size)
    except OSError:
        reason = "no font that can be read" if path.is_file() else "no such file"
        raise InputError(path, reason, "give a .ttf or .otf file") from None


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
