"""The font of a comic: size, missing characters, and installed fonts that have them."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.lettering.characters import replace_control
from vidstyle.errors import InputError, UsageError, log

if TYPE_CHECKING:
    from PIL import ImageFont

POINTS = 10.0
"""Default font size on paper, in points."""
_ACROSS, _ACROSS_STRIP = 45, 28
"""Maximum font size on a page, and font size on a strip (read on a phone), as fractions 1/N of the width."""
_MIN_SIZE = 7
"""Minimum font size in pixels."""
_SUBSTITUTES = {
    **dict.fromkeys("–—‐‑•", "-"),
    **dict.fromkeys("«»„", '"'),
    **dict(zip("ßẞæÆœŒøØłŁđı", "ss SS ae AE oe OE o O l L d i".split(), strict=True)),
}
"""Substitutes for characters that a font lacks; for others the accent is removed."""
_MARKS, NOTES = "–—‐‑•«»„", "♪♫♩♬"
"""Characters that are substituted without a warning, and notes, which are left out."""


_STRESS = re.compile(r"\*(\w(?:[^*\n]*\w)?)\*")


def runs(text: str) -> Iterator[tuple[str, bool]]:
    """The parts of a text, and whether each is stressed, which two asterisks around it say.

    >>> list(runs("I said *now*, 2 * 3."))
    [('I said ', False), ('now', True), (', 2 * 3.', False)]
    """
    end = 0
    for found in _STRESS.finditer(text):
        if found.start() > end:
            yield text[end : found.start()], False
        yield found[1], True
        end = found.end()
    if end < len(text):
        yield text[end:], False


def unstressed(text: str) -> str:
    """The text without the asterisks of `runs`."""
    return "".join(part for part, _ in runs(text))


def thickness(size: int) -> int:
    """Width of the outline that makes letters of a size bold, in pixels on each side."""
    return max(1, size // 28)


def check_pillow() -> None:
    """Raise UsageError if Pillow is not installed."""
    try:
        import PIL.ImageFont  # noqa: F401
    except ImportError as error:
        raise UsageError("comic", "needs Pillow", "pip install 'vidstyle[comic]'") from error


def letter_size(paper: Paper) -> int:
    """The font size for a paper, in pixels."""
    if paper.is_strip:
        return max(_MIN_SIZE, paper.width // _ACROSS_STRIP)
    return max(_MIN_SIZE, round(min(POINTS * paper.dpi / 72, paper.width / _ACROSS)))


class Letters:
    """A font at any size.

    Attributes:
        capitals: whether all is written in capitals, as comics are lettered.
        lacking: characters of texts so far that the font lacks.
    """

    def __init__(self, path: Path | None = None, capitals: bool = False) -> None:
        """`path`: a TrueType or OpenType font; None: Pillow's built-in one.

        Raises:
            InputError: it cannot be read.
        """
        self.path, self.capitals = path, capitals
        self.lacking: dict[str, None] = {}
        self._sizes: dict[int, ImageFont.FreeTypeFont] = {}
        self._known: dict[str, bool] = {}
        self.font(_MIN_SIZE)

    def font(self, size: int) -> ImageFont.FreeTypeFont:
        """Pillow's font at a size in pixels."""
        if size not in self._sizes:
            self._sizes[size] = _opened(self.path, size)
        return self._sizes[size]

    @property
    def family(self) -> str:
        """Its name."""
        return str(self.font(_MIN_SIZE).getname()[0] or "sans-serif")

    @property
    def free_font(self) -> bytes | None:
        """The file of Pillow's built-in font (CC0) or of the comic font (OFL), which may be embedded."""
        if self.path is not None:
            return self.path.read_bytes() if self.path == comic_font() else None
        file = self.font(_MIN_SIZE).path
        return file.getvalue() if isinstance(file, BytesIO) else None

    def width(self, text: str, size: int) -> float:
        """Of one line, in pixels; stress needs no room."""
        return float(self.font(size).getlength(unstressed(text)))

    def writable(self, text: str) -> str:
        """The text with substitutes for control characters and those that the font lacks, without notes."""
        text = text.upper() if self.capitals else text
        shown = "".join(self._written(letter) for letter in unicodedata.normalize("NFC", text))
        return replace_control(" ".join(shown.split()))

    def missing(self, text: str) -> set[str]:
        """The characters of a text that the font lacks and that are substituted."""
        text = text.upper() if self.capitals else text
        letters = set(unicodedata.normalize("NFC", text)).difference(_MARKS, NOTES)
        return {each for each in letters if not self._has(each)}

    def _written(self, letter: str) -> str:
        if self._has(letter):
            return letter
        if letter in _MARKS:
            return _SUBSTITUTES[letter]
        if letter in NOTES:
            return ""
        self.lacking[letter] = None
        plain = _SUBSTITUTES.get(letter) or "".join(
            part for part in unicodedata.normalize("NFKD", letter) if not unicodedata.combining(part)
        )
        return plain if plain and all(map(self._has, plain)) else letter

    def _has(self, letter: str) -> bool:
        if letter not in self._known:
            font = self.font(20)
            missing = bytes(font.getmask("\uffff"))
            self._known[letter] = letter.isspace() or bytes(font.getmask(letter)) != missing
        return self._known[letter]


def _opened(path: Path | None, size: int) -> ImageFont.FreeTypeFont:
    from PIL import ImageFont

    if path is None:
        font = ImageFont.load_default(size)
        assert isinstance(font, ImageFont.FreeTypeFont)
        return font
    remedy = "give a .ttf or .otf file"
    if os.path.exists(path) and not os.path.isfile(path):  # a pipe would wait for a writer
        raise InputError(path, "is not a file", remedy)
    try:
        return ImageFont.truetype(str(path), size)
    except (OSError, ValueError):
        reason = "is not a font" if os.path.isfile(path) else "no such file"
        raise InputError(path, reason, remedy) from None


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
"""Folders of installed fonts; one whose variable is not set is skipped."""

_ENDINGS = (".ttf", ".otf", ".ttc")
_MAX_FILES = 400
"""Font files that are opened at most."""
_LIKED = ("comic", "sans", "regular")
_DISLIKED = "bold italic oblique mono serif light thin condensed black math symbol".split()
"""Parts of font names that suit a comic, and that do not."""


def comic_font() -> Path | None:
    """The hand-lettered font that is installed with comics; None where it is not."""
    found = find_spec("font_intuitive")
    path = Path(found.origin).parent / "files" / "Intuitive.ttf" if found and found.origin else None
    return path if path and path.is_file() else None


def letters_for(texts: Iterable[str], letters: Letters) -> Letters:
    """The given font; instead of the built-in one the comic font, or an installed one that lacks less."""
    if letters.path is not None:
        return letters
    wanted, comic = "".join(texts), comic_font()
    if comic and not (drawn := Letters(comic, capitals=True)).missing(wanted):
        return drawn
    best, fewest = letters, len(letters.missing(wanted))
    for file in islice(_files(), _MAX_FILES) if fewest else ():
        try:
            found = Letters(file)
        except InputError:
            continue
        if (count := len(found.missing(wanted))) < fewest:
            best, fewest = found, count
        if not fewest:
            break
    if best is not letters:
        log.info("the font %s has letters that the built-in one lacks: it is used", best.family)
    return best


def _files() -> Iterator[Path]:
    """Font files, suitable ones first."""
    folders = (Path(os.path.expanduser(os.path.expandvars(folder))) for folder in FOLDERS)
    found = {
        file
        for folder in filter(Path.is_absolute, folders)
        for file in folder.rglob("*")
        if file.suffix.lower() in _ENDINGS
    }
    yield from sorted(found, key=lambda file: (_unsuitability(file.stem.lower()), file.name, str(file)))


def _unsuitability(name: str) -> int:
    plain = name.replace("sansserif", "sans")
    return 2 * sum(part in plain for part in _DISLIKED) - sum(part in plain for part in _LIKED)
