"""The font of a comic: its size, missing characters, and installed fonts that have them."""

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
from vidstyle.errors import InputError, UsageError, error_reason, log

if TYPE_CHECKING:
    from PIL import ImageFont

FONT_SIZE_POINTS = 10.0
"""Default font size on paper."""
_PAGE_WIDTH_FONT_SIZES, _STRIP_WIDTH_FONT_SIZES = 45, 28
"""Minimum width of a page in font sizes, and width of a strip, which is read on a phone."""
_MIN_FONT_SIZE_PX = 7
"""Minimum font size."""
_LETTER_SUBSTITUTES = {
    **dict.fromkeys("–—‐‑•", "-"),
    **dict.fromkeys("«»„", '"'),
    **dict(zip("ßẞæÆœŒøØłŁđı", "ss SS ae AE oe OE o O l L d i".split(), strict=True)),
}
"""Substitutes for characters that a font lacks; from other characters the accent is removed."""
_PUNCTUATION_MARKS, MUSIC_NOTES = "–—‐‑•«»„", "♪♫♩♬"
"""Characters that are substituted without a warning, and notes, which are omitted."""


_STRESS_PATTERN = re.compile(r"\*(\w(?:[^*\n]*\w)?)\*")


def split_stress(text: str) -> Iterator[tuple[str, bool]]:
    """Yield the parts of a text, and whether each is stressed, which is marked by two asterisks around it.

    >>> list(split_stress("I said *now*, 2 * 3."))
    [('I said ', False), ('now', True), (', 2 * 3.', False)]
    """
    end = 0
    for found in _STRESS_PATTERN.finditer(text):
        if found.start() > end:
            yield text[end : found.start()], False
        yield found[1], True
        end = found.end()
    if end < len(text):
        yield text[end:], False


def remove_stress(text: str) -> str:
    """Return the text without the asterisks of `split_stress`."""
    return "".join(part for part, _ in split_stress(text))


def thickness(size: int) -> int:
    """Return the width of the outline that makes letters of a size bold, in pixels on each side."""
    return max(1, size // 28)


def check_pillow() -> None:
    """Raise UsageError if Pillow is not installed."""
    try:
        import PIL.ImageFont  # noqa: F401
    except ImportError as error:
        raise UsageError("comic", "needs Pillow", "pip install 'vidstyle[comic]'") from error


def letter_size(paper: Paper) -> int:
    """Return the font size for a paper, in pixels."""
    if paper.is_strip:
        return max(_MIN_FONT_SIZE_PX, paper.width // _STRIP_WIDTH_FONT_SIZES)
    return max(
        _MIN_FONT_SIZE_PX, round(min(FONT_SIZE_POINTS * paper.dpi / 72, paper.width / _PAGE_WIDTH_FONT_SIZES))
    )


class Letters:
    """A font at any size.

    Attributes:
        path: its file, or None for Pillow's built-in font.
        capitals: whether all text is written in capitals, as comics are lettered.
        lacking: characters of the texts so far that the font lacks.
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
        self.font(_MIN_FONT_SIZE_PX)

    def font(self, size: int) -> ImageFont.FreeTypeFont:
        """Return Pillow's font at a size in pixels."""
        if size not in self._sizes:
            self._sizes[size] = _open_font(self.path, size)
        return self._sizes[size]

    @property
    def family(self) -> str:
        """Name of the font family."""
        return str(self.font(_MIN_FONT_SIZE_PX).getname()[0] or "sans-serif")

    @property
    def free_font(self) -> bytes | None:
        """The file of Pillow's built-in font (CC0) or of the comic font (OFL), which may be embedded."""
        if self.path is not None:
            return self.path.read_bytes() if self.path == find_comic_font() else None
        file = self.font(_MIN_FONT_SIZE_PX).path
        return file.getvalue() if isinstance(file, BytesIO) else None

    def width(self, text: str, size: int) -> float:
        """Return the width of one line, in pixels; stressed words are no wider."""
        return float(self.font(size).getlength(remove_stress(text)))

    def make_writable(self, text: str) -> str:
        """Substitute control characters and characters that the font lacks; notes are omitted."""
        text = text.upper() if self.capitals else text
        shown = "".join(self._substitute(letter) for letter in unicodedata.normalize("NFC", text))
        return replace_control(" ".join(shown.split()))

    def find_missing(self, text: str) -> set[str]:
        """Return the characters of a text that the font lacks and that are not substituted silently."""
        text = text.upper() if self.capitals else text
        letters = set(unicodedata.normalize("NFC", text)).difference(_PUNCTUATION_MARKS, MUSIC_NOTES)
        return {each for each in letters if not self._has(each)}

    def _substitute(self, letter: str) -> str:
        if self._has(letter):
            return letter
        if letter in _PUNCTUATION_MARKS:
            return _LETTER_SUBSTITUTES[letter]
        if letter in MUSIC_NOTES:
            return ""
        self.lacking[letter] = None
        plain = _LETTER_SUBSTITUTES.get(letter) or "".join(
            part for part in unicodedata.normalize("NFKD", letter) if not unicodedata.combining(part)
        )
        return plain if plain and all(map(self._has, plain)) else letter

    def _has(self, letter: str) -> bool:
        if letter not in self._known:
            font = self.font(20)
            missing = bytes(font.getmask("\uffff"))
            self._known[letter] = letter.isspace() or bytes(font.getmask(letter)) != missing
        return self._known[letter]


def _open_font(path: Path | None, size: int) -> ImageFont.FreeTypeFont:
    from PIL import ImageFont

    if path is None:
        font = ImageFont.load_default(size)
        assert isinstance(font, ImageFont.FreeTypeFont)
        return font
    remedy = "give a .ttf or .otf file"
    if os.path.exists(path) and not os.path.isfile(path):  # a pipe would wait for a writer
        raise InputError(path, "is not a file", remedy)
    try:
        path.open("rb").close()  # FreeType gives no reason, and its errors have no number
        return ImageFont.truetype(str(path), size)
    except (OSError, ValueError) as error:
        is_denied = isinstance(error, OSError) and error.errno
        reason = error_reason(error).lower() if is_denied else "is not a font"
        raise InputError(path, reason, remedy) from None


FONT_FOLDERS = (
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
"""Folders of installed fonts; a folder whose variable is not set is skipped."""

_FONT_SUFFIXES = (".ttf", ".otf", ".ttc")
_MAX_FONT_FILES = 400
"""Maximum number of font files that are opened."""
_LIKED_NAME_PARTS = ("comic", "sans", "regular")
"""Parts of font names that suit a comic, and parts that do not."""
_DISLIKED_NAME_PARTS = "bold italic oblique mono serif light thin condensed black math symbol".split()
"""Parts of font names that suit a comic, and that do not."""


def find_comic_font() -> Path | None:
    """Return the hand-lettered font that is installed with the extra `comic`; None if it is not installed."""
    found = find_spec("font_intuitive")
    path = Path(found.origin).parent / "files" / "Intuitive.ttf" if found and found.origin else None
    return path if path and path.is_file() else None


def choose_letters(texts: Iterable[str], letters: Letters) -> Letters:
    """Return the given font; instead of the built-in one the comic font, or the best installed font."""
    if letters.path is not None:
        return letters
    wanted, comic = "".join(texts), find_comic_font()
    if comic and not (drawn := Letters(comic, capitals=True)).find_missing(wanted):
        return drawn
    best, fewest = letters, len(letters.find_missing(wanted))
    for file in islice(_list_font_files(), _MAX_FONT_FILES) if fewest else ():
        try:
            found = Letters(file)
        except InputError:
            continue
        if (count := len(found.find_missing(wanted))) < fewest:
            best, fewest = found, count
        if not fewest:
            break
    if best is not letters:
        log.info("using the font %s, which has letters that the built-in font lacks", best.family)
    return best


def _list_font_files() -> Iterator[Path]:
    """Yield font files, suitable ones first."""
    folders = (Path(os.path.expanduser(os.path.expandvars(folder))) for folder in FONT_FOLDERS)
    found = {
        file
        for folder in filter(Path.is_absolute, folders)
        for file in folder.rglob("*")
        if file.suffix.lower() in _FONT_SUFFIXES
    }
    yield from sorted(found, key=lambda file: (_unsuitability(file.stem.lower()), file.name, str(file)))


def _unsuitability(name: str) -> int:
    plain = name.replace("sansserif", "sans")
    return 2 * sum(part in plain for part in _DISLIKED_NAME_PARTS) - sum(
        part in plain for part in _LIKED_NAME_PARTS
    )
