"""The page on which the styles of scenes are chosen, in a browser."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
from browser import Browser
from browser import browser as browser
from media import photograph

from vidstyle.cues.cue_file import cue_file_text, read_cue_file
from vidstyle.cues.cue_list import CueList
from vidstyle.gallery.cue_sheet import SheetScene, cue_sheet
from vidstyle.style import load_style

STARTS = [Fraction(0), Fraction(5, 2), Fraction(6)]
SAVED = """
globalThis.saved = null;
URL.createObjectURL = (blob) => { globalThis.saved = blob; return "about:blank#saved"; };
HTMLAnchorElement.prototype.click = () => {};
document.querySelector(".save").click();
return globalThis.saved.text();
"""


@pytest.fixture
def page(browser: Browser, tmp_path: Path) -> Browser:
    """The page of a film with a </script> in its name, in a browser."""
    scenes = [SheetScene(start, "ink", photograph("coffee")) for start in STARTS]
    styles = {name: load_style(name) for name in ("ink", "noir", "poster")}
    text = cue_sheet("a</script><b>.mp4", "cues.toml", scenes, Fraction(25), styles)
    (tmp_path / "sheet.html").write_text(text, encoding="utf-8")
    browser.open((tmp_path / "sheet.html").as_uri())
    browser.until("document.querySelectorAll('li').length === 3")
    return browser


def saved(page: Browser, folder: Path) -> CueList:
    """Read the file that the page saves."""
    (folder / "saved.toml").write_text(page.run(SAVED), encoding="utf-8")
    return read_cue_file(folder / "saved.toml")


def test_the_page_saves_what_the_command_wrote(page: Browser, tmp_path: Path) -> None:
    (tmp_path / "written.toml").write_text(cue_file_text(STARTS, Fraction(25), ["ink"] * 3))
    assert saved(page, tmp_path) == read_cue_file(tmp_path / "written.toml")
    assert page.run("return document.querySelector('h1').textContent") == "Styles of a</script><b>.mp4"


def test_a_style_and_a_fade_are_chosen_by_mouse(page: Browser, tmp_path: Path) -> None:
    page.click("li:nth-child(2) .style")
    page.click("dialog div button:nth-child(3)")
    page.run(
        """const transition = document.querySelectorAll("li:nth-child(2) select")[0];
        transition.value = "fade";
        transition.dispatchEvent(new Event("change"));"""
    )
    cue = saved(page, tmp_path).cues[1]
    assert (cue.style.name, cue.transition, cue.seconds) == ("poster", "fade", 1)


def test_a_style_is_chosen_by_keyboard(page: Browser, tmp_path: Path) -> None:
    page.run("document.querySelector('li:nth-child(3) .style').focus()")
    page.press("Enter")
    page.until("document.querySelector('dialog').open")
    page.run("document.querySelector('dialog div button:nth-child(2)').focus()")
    page.press("Enter")
    page.until("!document.querySelector('dialog').open")
    assert [cue.style.name for cue in saved(page, tmp_path).cues] == ["ink", "ink", "noir"]
    assert page.run("return document.activeElement.className") == "style"


def test_a_scene_without_a_style_continues_and_strength_moves(page: Browser, tmp_path: Path) -> None:
    page.click("li:nth-child(2) .style")
    page.click("dialog div button:nth-child(4)")
    page.run(
        """const [strength] = document.querySelectorAll("li:nth-child(1) input[type=range]");
        strength.value = "0";
        strength.dispatchEvent(new Event("input"));
        const curve = document.querySelectorAll("li:nth-child(1) select")[1];
        curve.value = "ease";
        curve.dispatchEvent(new Event("change"));"""
    )
    cues = saved(page, tmp_path)
    assert [cue.style.name for cue in cues.cues] == ["ink"] * 3
    assert cues.at(0).active.style.strength == pytest.approx(0, abs=1e-5)
    assert cues.at(Fraction(5, 4)).active.style.strength == pytest.approx(0.5, abs=0.01)
    assert cues.at(3).active.style.strength == 1
