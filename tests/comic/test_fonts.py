"""Fallback to installed fonts for characters that the built-in font lacks."""

from __future__ import annotations

import logging
from io import BytesIO
from pathlib import Path

import pytest
from PIL import ImageFont

from vidstyle.comic.lettering import fonts
from vidstyle.comic.lettering.fonts import Letters, choose_letters

PLAIN, ACCENTED = "Plain words - and “more”.", "Été à Łódź"


class Accented(Letters):
    """Letters of which one font has every character, independent of the fonts installed on this machine."""

    def _has(self, letter: str) -> bool:
        return self.path is not None and self.path.name == "a font.ttf" or super()._has(letter)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the only folder that is searched for fonts."""
    monkeypatch.setattr(fonts, "find_comic_font", lambda: None)
    monkeypatch.setattr(
        fonts, "FONT_FOLDERS", (str(tmp_path / "none"), "$NO_SUCH_FOLDER/fonts", str(tmp_path))
    )
    return tmp_path


def save_built_in_font(path: Path) -> Path:
    """Save Pillow's built-in font as a file."""
    font = ImageFont.load_default(20)
    assert isinstance(font, ImageFont.FreeTypeFont) and isinstance(font.path, BytesIO)
    path.write_bytes(font.path.getvalue())
    return path


def test_missing_letters_are_found() -> None:
    letters = Letters()
    assert letters.find_missing(PLAIN + " ♪ «x» – y\n") == set()
    assert letters.find_missing(ACCENTED) >= set("Łź")


def test_the_built_in_font_is_kept_unless_another_has_more_letters(folder: Path) -> None:
    (folder / "broken.ttf").write_bytes(b"no font")
    save_built_in_font(folder / "another.ttf")
    assert choose_letters([PLAIN], Letters()).path is None
    assert choose_letters([ACCENTED], Letters()).path is None


def test_the_comic_font_writes_capitals_if_it_has_all_letters() -> None:
    letters = choose_letters([PLAIN], Letters())
    assert letters.family == "Intuitive" and letters.free_font
    assert letters.make_writable(PLAIN) == PLAIN.upper()
    assert choose_letters(["Łódź"], Letters()).family != "Intuitive"


def test_a_given_font_is_kept(folder: Path) -> None:
    path = save_built_in_font(folder / "mine.ttf")
    assert choose_letters([ACCENTED], Letters(path)).path == path


def test_an_installed_font_is_used_for_missing_letters(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / "deep").mkdir()
    path = save_built_in_font(folder / "deep" / "a font.ttf")
    save_built_in_font(folder / "another.ttf")
    monkeypatch.setattr(fonts, "Letters", Accented)
    with caplog.at_level(logging.INFO, logger="vidstyle"):
        letters = choose_letters([PLAIN, ACCENTED], Letters())
    assert letters.path == path
    assert letters.make_writable(ACCENTED) == ACCENTED
    assert not letters.lacking
    assert [each.getMessage() for each in caplog.records] == [
        f"using the font {letters.family}, which has letters that the built-in font lacks"
    ]


def test_suitable_fonts_come_first(folder: Path) -> None:
    for name in "Some-BoldItalic.ttf SomeSans.ttf SomeMono.ttf SomeSerif.otf Comic_Sans.ttf".split():
        (folder / name).write_bytes(b"")
    (folder / "text.txt").write_bytes(b"")
    assert [file.name for file in fonts._list_font_files()][:2] == ["Comic_Sans.ttf", "SomeSans.ttf"]
    assert len(list(fonts._list_font_files())) == 5
