"""The page of a preview sheet in a browser: stars, comparing, and what may not move."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import Browser

from vidstyle.gallery.preview import preview_page
from vidstyle.gallery.style_samples import StyleSample
from vidstyle.style import load_style, style_names

PLACES = """
return [...document.querySelectorAll("#looks :is(p, button)")].map((each) => {
  const { left, top, width } = each.getBoundingClientRect();
  return [left, top, width].map(Math.round);
});
"""
TEXT = "return document.querySelector(selector).textContent"
STAR = """document.querySelector(`figure:has([alt="${name}"]) .star`).click()"""


@pytest.fixture
def sheet(tmp_path: Path) -> str:
    """The address of a preview sheet of all looks; stars are kept under the name of its picture."""
    names = ["plain", *(name for name in style_names() if name != "plain")]
    pictures = [np.full((300, 450, 3), 10 * number, np.uint8) for number in range(len(names))]
    samples = [StyleSample(load_style(name), each) for name, each in zip(names, pictures, strict=True)]
    page = tmp_path / "sheet.html"
    page.write_text(preview_page(f"{tmp_path.name}.png", "in.png", samples), encoding="utf-8")
    return page.as_uri()


def test_all_starred_looks_are_compared_with_their_texts_below_and_a_key_shows_the_original(
    sheet: str, browser: Browser
) -> None:
    size = {"width": 1280, "height": 800}
    browser.call("Emulation.setDeviceMetricsOverride", **size, deviceScaleFactor=1, mobile=False)
    browser.open(sheet)
    for name in ("vhs", "oil", "noir"):
        browser.run(STAR, name=name)
    browser.click("#compare-starred")
    tags = "return [...document.querySelectorAll('#compared .tag')].map((each) => each.textContent)"
    assert browser.run(tags) == ["VHS", "Oil", "Noir"]
    assert browser.run(TEXT, selector="#compared-names") == "VHS, Oil and Noir"
    below = """return [...document.querySelectorAll("#compared figure")].map((each) => {
      const [image, text] = ["img", "p"].map((name) => each.querySelector(name).getBoundingClientRect());
      return each.querySelector("p").textContent && text.top >= image.bottom && text.left === image.left
        && image.width > 200 && text.bottom <= innerHeight;
    });"""
    assert browser.run(below) == [True] * 3
    stars = "[...document.querySelectorAll('#compared [aria-pressed]')]"
    for is_starred in ("false", "true"):
        browser.run(f"{stars}[0].click()")
        assert browser.run(f"return {stars}.map((each) => each.ariaPressed)") == [is_starred, "true", "true"]
    browser.run("dispatchEvent(new KeyboardEvent('keydown', { key: 'b' }))")
    assert browser.run(tags) == [f"{name}: original" for name in ("VHS", "Oil", "Noir")]
    browser.run("dispatchEvent(new KeyboardEvent('keyup', { key: 'b' }))")
    assert browser.run(tags) == ["VHS", "Oil", "Noir"]
    browser.click("#compared figure:nth-child(2) .enlarge")
    assert browser.run(TEXT, selector="#name") == "Oil"
    browser.press("Escape")
    assert browser.run("return document.getElementById('comparison').open")


def test_of_more_starred_looks_the_last_six_are_compared(sheet: str, browser: Browser) -> None:
    browser.open(sheet)
    for name in ("vhs", "oil", "noir", "ink", "neon", "poster", "manga"):
        browser.run(STAR, name=name)
    assert browser.run(TEXT, selector="#compare-starred") == "Compare last 6"
    assert browser.run(TEXT, selector="#intro") == "Compare: Oil, Noir, Ink, Neon, Poster and Manga"
    browser.click("#compare-starred")
    assert browser.run(TEXT, selector="#compared-names") == "Oil, Noir, Ink, Neon, Poster and Manga"


def test_the_whole_card_enlarges_a_look_and_a_key_stars_it(sheet: str, browser: Browser) -> None:
    browser.open(sheet)
    x, y, *_ = browser.place("figure:nth-of-type(3) .about")
    for kind in ("mousePressed", "mouseReleased"):
        browser.mouse(kind, x, y)
    name = browser.run(TEXT, selector="#name")
    assert name == browser.run(TEXT, selector="figure:nth-of-type(3) strong")
    browser.press("d", "ArrowRight")
    assert browser.run(TEXT, selector="#save-word") == "Save picture", "the next look is not saved"
    browser.press("Escape", "s", "s", "s")
    assert browser.run(TEXT, selector="#starred") == "Starred: 1", "the card keeps the focus"


def test_a_search_that_finds_few_looks_shows_related_ones_below(sheet: str, browser: Browser) -> None:
    browser.open(sheet)
    search = """const finder = document.getElementById("find-look");
        finder.value = text;
        finder.dispatchEvent(new Event("input"));
        return [...document.querySelectorAll("main > :is(figure, h2):not([hidden])")].map((each) =>
          each.querySelector("strong")?.textContent ?? each.textContent);"""
    found, title, *related = browser.run(search, text="matchbox")
    assert (found, title) == ("Riso", "Related looks") and related
    assert browser.run(TEXT, selector="h1").startswith("1 of "), "related looks are not counted"
    assert "Related looks" not in browser.run(search, text="")


def test_the_filter_bar_stays_in_place_with_the_first_star_and_a_copied_list(
    sheet: str, browser: Browser
) -> None:
    browser.open(sheet)
    before = browser.run(PLACES)
    for name in ("oil", "noir"):
        browser.run(STAR, name=name)
    assert browser.run(PLACES) == before
    browser.run(
        """Object.defineProperty(navigator, "clipboard", { value: {
          writeText: async (text) => void (globalThis.copied = text) } });
        document.getElementById("copy-starred").click();"""
    )
    assert browser.run("return copied") == "noir,oil"
    assert browser.run(TEXT, selector="#copy-starred") == "Copied"
    assert browser.run(PLACES) == before


def test_few_looks_keep_their_width_and_the_title_counts_them(sheet: str, browser: Browser) -> None:
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=1280, height=800, deviceScaleFactor=1, mobile=False
    )
    browser.open(sheet)
    total = len(style_names()) - 1
    browser.run(STAR, name="oil")
    assert browser.run(TEXT, selector="h1").startswith(f"{total} looks")
    width = "return document.querySelector('main figure:not([hidden]) img').getBoundingClientRect().width"
    before = browser.run(width)
    browser.run("document.getElementById('starred').click()")
    assert browser.run(TEXT, selector="h1").startswith(f"1 of {total} looks")
    assert browser.run(width) == before


def test_descriptions_are_shown_whole(sheet: str, browser: Browser) -> None:
    for width in (360, 1280):
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=False
        )
        browser.open(sheet)
        shown = """return [...document.querySelectorAll(".about")].map((each) =>
          [each.textContent, each.scrollHeight - each.clientHeight, each.clientHeight]);"""
        texts = browser.run(shown)
        assert all(text and overflow <= 0 and height for text, overflow, height in texts)
        assert ["Flat, clean colours in few tones"] == [text for text, *_ in texts if "clean colours" in text]


def test_a_look_is_enlarged_alone_after_others_were_compared(sheet: str, browser: Browser) -> None:
    browser.open(sheet)
    for name in ("vhs", "oil"):
        browser.run(STAR, name=name)
    alone = "return document.getElementById('large').classList.contains('alone')"
    browser.run("document.getElementById('compare-starred').click()")
    browser.press("Escape")
    enlarge = "document.querySelectorAll('main figure > button:first-child')[8].click()"
    browser.run(enlarge)
    assert browser.run(alone)
    browser.press("c", "Escape")
    browser.run(enlarge)
    assert not browser.run(alone), "as it was left"


def test_a_card_is_one_stop_of_the_tab_key_and_arrow_keys_move_between_cards(
    sheet: str, browser: Browser
) -> None:
    browser.open(sheet)
    stops = """return [...document.querySelectorAll("main figure button")]
        .filter((each) => each.tabIndex === 0).length;"""
    assert browser.run(stops) == 1
    browser.run("document.querySelector('#groups button').focus()")
    assert browser.run(stops) == 1, "other buttons of the page change nothing"
    browser.press("Tab", "ArrowDown", "ArrowRight", "ArrowUp")
    place = """const cards = [...document.querySelectorAll("main figure")];
        return cards.indexOf(document.activeElement.closest("figure"));"""
    assert browser.run(place) == 1, "down a row, right, and up again"


@pytest.mark.parametrize(("width", "height"), [(2560, 1440), (360, 740)])
def test_large_pictures_fill_the_window_and_compared_ones_stay_in_it(
    sheet: str, browser: Browser, width: int, height: int
) -> None:
    size = {"width": width, "height": height}
    browser.call("Emulation.setDeviceMetricsOverride", **size, deviceScaleFactor=1, mobile=False)
    browser.open(sheet)
    for name in ("vhs", "impressionist", "watercolor", "pointillist"):
        browser.run(STAR, name=name)
    browser.run("document.getElementById('compare-starred').click()")
    right = """const shown = [...document.querySelectorAll("#comparison :is(button, img)")];
        return Math.max(...shown.map((each) => each.getBoundingClientRect().right));"""
    assert browser.run(right) <= width
    apart = """return [...document.querySelectorAll("#compared figure")].every((each) => {
      const [image, text, row] = [...each.children].map((part) => part.getBoundingClientRect());
      return image.height > 50 && text.top >= image.bottom && row.top >= text.bottom;
    });"""
    assert browser.run(apart)
    browser.press("Escape")
    browser.run("document.querySelectorAll('main figure > button:first-child')[3].click()")
    box = """const box = document.getElementById("after").getBoundingClientRect();
        const place = document.querySelector(".pair").getBoundingClientRect();
        return Math.max(box.width / place.width, box.height / place.height);"""
    assert 0.9 < browser.run(box) <= 1
