"""Fallback to installed fonts for characters that the built-in font lacks."""

from __future__ import annotations

import logging
from io import BytesIO
from pathlib import Path

import pytest
from PIL import ImageFont

from vidstyle.comic.lettering import fonts
from vidstyle.comic.lettering.fonts import Letters, letters_for

PLAIN, ACCENTED = "Plain words - and “more”.", "Été à Łódź"


class Accented(Letters):
    """Letters, one font of which has all that there are, whatever fonts this machine has."""

    def _has(self, letter: str) -> bool:
        return self.path is not None and self.path.name == "a font.ttf" or super()._has(letter)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only one in which fonts are looked for."""
    monkeypatch.setattr(fonts, "comic_font", lambda: None)
    monkeypatch.setattr(fonts, "FOLDERS", (str(tmp_path / "none"), "$NO_SUCH_FOLDER/fonts", str(tmp_path)))
    return tmp_path


def builtin(path: Path) -> Path:
    """The font that Pillow brings, as a file."""
    font = ImageFont.load_default(20)
    assert isinstance(font, ImageFont.FreeTypeFont) and isinstance(font.path, BytesIO)
    path.write_bytes(font.path.getvalue())
    return path


def test_what_a_font_lacks_is_known() -> None:
    letters = Letters()
    assert letters.missing(PLAIN + " ♪ «x» – y\n") == set()
    assert letters.missing(ACCENTED) >= set("Łź")


def test_the_built_in_font_stays_where_it_has_all_or_no_other_has_more(folder: Path) -> None:
    (folder / "broken.ttf").write_bytes(b"no font")
    builtin(folder / "another.ttf")
    assert letters_for([PLAIN], Letters()).path is None
    assert letters_for([ACCENTED], Letters()).path is None


def test_comics_are_lettered_in_capitals_where_their_font_has_all() -> None:
    letters = letters_for([PLAIN], Letters())
    assert letters.family == "Intuitive" and letters.free_font
    assert letters.writable(PLAIN) == PLAIN.upper()
    assert letters_for(["Łódź"], Letters()).family != "Intuitive"


def test_a_font_that_was_given_stays(folder: Path) -> None:
    path = builtin(folder / "mine.ttf")
    assert letters_for([ACCENTED], Letters(path)).path == path


def test_an_installed_font_is_taken_for_letters_that_are_missing(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / "deep").mkdir()
    path = builtin(folder / "deep" / "a font.ttf")
    builtin(folder / "another.ttf")
    monkeypatch.setattr(fonts, "Letters", Accented)
    with caplog.at_level(logging.INFO, logger="vidstyle"):
        letters = letters_for([PLAIN, ACCENTED], Letters())
    assert letters.path == path
    assert letters.writable(ACCENTED) == ACCENTED
    assert not letters.lacking
    assert [each.getMessage() for each in caplog.records] == [
        f"the font {letters.family} has letters that the built-in one lacks: it is used"
    ]


def test_fonts_that_suit_come_first(folder: Path) -> None:
    for name in "Some-BoldItalic.ttf SomeSans.ttf SomeMono.ttf SomeSerif.otf Comic_Sans.ttf".split():
        (folder / name).write_bytes(b"")
    (folder / "text.txt").write_bytes(b"")
    assert [file.name for file in fonts._files()][:2] == ["Comic_Sans.ttf", "SomeSans.ttf"]
    assert len(list(fonts._files())) == 5
