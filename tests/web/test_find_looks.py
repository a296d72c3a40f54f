"""The search of looks that pages share, used on a preview sheet: words of laypeople, best first."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from browser import Browser
from waiting import eventually

from vidstyle.export import SCRIPT_FOLDERS
from vidstyle.export.page import page_script
from vidstyle.gallery.preview import preview_page
from vidstyle.gallery.search_words import describe_look
from vidstyle.gallery.style_samples import StyleSample
from vidstyle.style import load_style, style_names
from vidstyle.style.model import KINDS

FIND = """
const finder = document.getElementById('find-look');
finder.value = text;
finder.dispatchEvent(new Event('input'));
const shown = [...document.querySelectorAll('main > :is(figure, #related):not([hidden])')];
const found = shown.slice(0, shown.findIndex(({ id }) => id) >>> 0);
return found.map((each) => each.querySelector('strong').textContent);
"""
MODULES = next(folder for folder in SCRIPT_FOLDERS if folder.name == "modules")
NEAR = "return document.getElementById('near-look').textContent"
OFFERED = "return [...document.querySelectorAll('#words-to-try button')].map((each) => each.textContent)"


@pytest.fixture
def sheet(tmp_path: Path) -> str:
    """The address of a preview sheet of all looks."""
    gray = np.full((9, 16, 3), 128, np.uint8)
    names = ["plain", *(name for name in style_names() if name != "plain")]
    page = tmp_path / "sheet.html"
    samples = [StyleSample(load_style(name), gray) for name in names]
    page.write_text(preview_page("in.png", "in.png", samples), encoding="utf-8")
    return page.as_uri()


def test_an_enlarged_look_counts_those_found_stays_and_is_saved(
    sheet: str, tmp_path: Path, browser: Browser
) -> None:
    browser.download_to(tmp_path)
    browser.open(sheet)
    browser.run(FIND, text="lego")
    browser.run("document.querySelector('main figure:not([hidden]) button').click()")
    browser.press("Enter")
    assert browser.run("return document.getElementById('count').textContent") == "1 of 2"
    browser.press("d")
    eventually((tmp_path / "in-mosaic.jpg").exists)
    assert browser.run("return document.getElementById('large').open")


def test_looks_are_found_by_the_words_of_laypeople_best_first(sheet: str, browser: Browser) -> None:
    browser.open(sheet)
    for text in ("watercolor", "Watercolour"):
        assert browser.run(FIND, text=text) == ["Watercolor"]
    assert browser.run(FIND, text="van gogh")[0] == "Impressionist", "it is its first other name"
    assert browser.run(FIND, text="lego") == ["Mosaic", "Pixel"]
    assert browser.run(FIND, text="gameboy") == browser.run(FIND, text="game-boy") == ["Dither", "Pixel"]
    assert browser.run(FIND, text="watercolour like turner") == ["Watercolor"], "the word that names a look"
    assert browser.run(FIND, text="scary")[0] in ("Woodcut", "Charcoal", "Noir"), "a mood"
    assert browser.run(FIND, text="flying saucer") == [], "a flyer is another word"
    assert browser.run(FIND, text="remmbrant") == []
    assert browser.run(OFFERED)[0] == "rembrandt", "the nearest name"
    assert browser.run(FIND, text="qqq") == [] == browser.run(OFFERED), "no word is near"
    assert browser.run(FIND, text="old photo")[0] == "Noir", "the whole phrase before its parts"
    assert browser.run(FIND, text="crayons") == browser.run(FIND, text="like a crayon") == ["Crayon"]
    assert browser.run(FIND, text="soft colours")[0] == "Watercolor", "a name before words of descriptions"
    assert browser.run(FIND, text="wattercolr") == [], "two errors are too many"
    browser.click("#words-to-try button")
    assert browser.run("return document.getElementById('find-look').value") == "Watercolor"
    browser.run("document.getElementById('find-look').value = ''")
    browser.run(FIND, text="")
    browser.until("document.querySelectorAll('main figure:not([hidden])').length > 1")
    kinds = browser.run(
        "return [...document.querySelectorAll('#groups button')].map((each) => each.textContent)"
    )
    assert kinds == ["All", *KINDS.values()], "the order of the front page"
    assert browser.run(FIND, text="mosaic") == ["Mosaic"]
    browser.press("Enter", "s", "Escape")
    assert browser.run("return document.querySelector('[aria-label=\"Star Mosaic\"]').ariaPressed") == "true"


def test_a_search_forgives_errors_endings_order_and_words_that_say_nothing(
    sheet: str, browser: Browser
) -> None:
    browser.open(sheet)
    same = {
        "Oil": ("rembrandt", "rembrant", "Rembradnt", "make it look like a Rembrandt painting"),
        "Cartoon": ("cartoon", "cartoonish", "cartoons filter", "cartooon effect"),
        "Blueprint": ("blue print", "blue-prints", "drawing technical"),
        "Charcoal": ("charcoal", "smudges", "smudgy", "smudging"),
    }
    for look, texts in same.items():
        assert {text: browser.run(FIND, text=text)[:1] for text in texts} == dict.fromkeys(texts, [look])
    assert browser.run(FIND, text="old mosaic")[0] == "Mosaic", "the rarer word decides"
    assert browser.run(FIND, text="tiels") == browser.run(FIND, text="tiles") != [], "letters swapped"
    assert browser.run(FIND, text="tlie") == [], "a short word must be right"


def tables_of_words() -> list[dict[str, str]]:
    """Return the looks for each list of words: of properties, and of looks that do not exist."""
    text = (MODULES / "look_properties.js").read_text(encoding="utf-8")
    tables = text.split("export const ")[1:]
    return [dict(re.findall(r'^ +"(.+)": "(.+)",$', table, re.MULTILINE)) for table in tables]


def test_properties_find_their_looks_in_the_declared_order(sheet: str, browser: Browser) -> None:
    declared, absent = tables_of_words()
    assert len(declared) > 20 and len(absent) > 4
    named = [*declared.values(), *(looks.partition(" | ")[0] for looks in absent.values())]
    assert set(" ".join(named).split()) <= set(style_names())
    browser.open(sheet)
    for text in ("gloomy", "gloomier", "more gloomy"):
        assert [name.lower().replace("our", "or") for name in browser.run(FIND, text=text)] == [
            look for words, looks in declared.items() if words.startswith("gloomy") for look in looks.split()
        ]


def test_a_sheet_says_that_no_look_is_exactly_what_was_asked(sheet: str, browser: Browser) -> None:
    browser.open(sheet)
    assert browser.run(FIND, text="bokeh")[0] == "Watercolor"
    assert browser.run(NEAR).startswith("No look is exactly “bokeh”. In the designer")
    assert browser.run(FIND, text="snow white") == ["Cartoon"]
    assert browser.run(NEAR) == ""


def test_every_name_finds_its_look_and_each_word_is_listed_once(tmp_path: Path, browser: Browser) -> None:
    looks = [describe_look(name, partial(load_style, name)) for name in style_names()]
    names = [[look["name"], *filter(None, look["aliases"].split(", "))] for look in looks]
    listed = [word for table in tables_of_words() for words in table for word in words.split(", ")]
    assert {word for word in listed if listed.count(word) > 1} == set()
    absent = {word for words in tables_of_words()[1] for word in words.split(", ")}
    assert absent & {name for each in names for name in each} == set()
    page = tmp_path / "search.html"
    page.write_text(f"<script>{page_script(MODULES / 'find_looks.js')}</script>", encoding="utf-8")
    browser.open(page.as_uri())
    missed = """const named = looks.map((look) => ({ ...look, about: look.note }));
    return names.flatMap((each, place) => each.filter((name) => !findLooks(named, name).includes(place)))"""
    assert browser.run(missed, looks=looks, names=names) == []
    assert browser.run(
        "return findLooks([{ name: 'ink', aliases: 'fire', about: '', words: '' }], 'fires')"
    ) == [0]
