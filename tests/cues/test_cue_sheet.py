"""The page on which the styles of scenes are chosen, in a browser."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import pytest
from browser import Browser
from media import photograph

from vidstyle.cues.cue_file import CueTable, cue_file_text, read_cue_file, read_cue_tables, scene_cues
from vidstyle.cues.cue_list import CueList
from vidstyle.gallery.cue_sheet import SheetScene, cue_sheet

STARTS = [Fraction(0), Fraction(5, 2), Fraction(6)]
SAVED = """
globalThis.saved = null;
URL.createObjectURL = (blob) => { globalThis.saved = blob; return "about:blank#saved"; };
HTMLAnchorElement.prototype.click = () => {};
document.querySelector(".save").click();
return globalThis.saved.text();
"""


OLD = """
format = 1
scenes = [0, 9]
[[cue]]
scene = 1
style = "ink:green"
values = { strength = 0.25, "flow_dog.p" = 30 }
curve = "linear"
[[cue]]
time = "0:01.5"
values = { strength = 1 }
[[cue]]
time = 2.5
style = "mine.toml"
seconds = 0.5
[[cue]]
time = 6
style = "plain"
transition = "wipe"
seconds = 1
"""
BUTTONS = "[...document.querySelectorAll('dialog div button')]"
STYLES = ["ink", "noir:gray", "poster"]
CUES = scene_cues(STYLES)


def open_sheet(browser: Browser, folder: Path, cues: Sequence[CueTable], cards: int) -> None:
    """Open the page of a film with a </script> in its name, in a browser."""
    ends = [*STARTS[1:], Fraction(10)]
    scenes = [SheetScene(*span, photograph("coffee")) for span in zip(STARTS, ends, strict=True)]
    text = cue_sheet("a</script><b>.mp4", folder / "cues.toml", scenes, Fraction(25), cues)
    (folder / "sheet.html").write_text(text, encoding="utf-8")
    browser.open((folder / "sheet.html").as_uri())
    browser.until(f"document.querySelectorAll('li').length === {cards}")


@pytest.fixture
def page(browser: Browser, tmp_path: Path) -> Browser:
    """The page of three scenes."""
    open_sheet(browser, tmp_path, CUES, 3)
    return browser


def saved(page: Browser, folder: Path) -> CueList:
    """Read the file that the page saves."""
    (folder / "saved.toml").write_text(page.run(SAVED), encoding="utf-8")
    return read_cue_file(folder / "saved.toml")


def change(page: Browser, selector: str, value: str, event: str = "change") -> None:
    """Set the value of an input, as a user does."""
    page.run(
        """const input = document.querySelector(selector);
        input.value = value;
        input.dispatchEvent(new Event(event, { bubbles: true }));""",
        selector=selector, value=value, event=event,
    )  # fmt: skip


def pick(page: Browser, card: int, style: str) -> None:
    """Choose a style by mouse; "" continues the style before."""
    page.click(f"li:nth-child({card}) .style")
    names = page.run(f"return {BUTTONS}.map((each) => each.innerText.trim())")
    page.click(f"dialog div button:nth-child({names.index(style.title() or 'As the scene before') + 1})")


def test_the_page_saves_what_the_command_wrote(page: Browser, tmp_path: Path) -> None:
    (tmp_path / "written.toml").write_text(cue_file_text(STARTS, Fraction(25), CUES))
    assert saved(page, tmp_path) == read_cue_file(tmp_path / "written.toml")
    assert page.run("return document.querySelector('h1').textContent") == "Styles of a</script><b>.mp4"


def test_a_style_a_variant_and_a_fade_are_chosen_by_mouse(page: Browser, tmp_path: Path) -> None:
    pick(page, 2, "poster")
    change(page, "li:nth-child(2) select", "pink")
    change(page, "li:nth-child(2) .fields select:has(option[value=fade])", "fade")
    change(page, "li:nth-child(2) input[aria-label^=Seconds]", "1.5")
    cue = saved(page, tmp_path).cues[1]
    assert (cue.style.name, cue.transition, cue.seconds) == ("poster:pink", "fade", Fraction(3, 2))


def test_a_style_is_chosen_by_keyboard(page: Browser, tmp_path: Path) -> None:
    page.run("document.querySelector('li:nth-child(3) .style').focus()")
    page.press("Enter")
    page.until("document.querySelector('dialog').open")
    page.run(f"{BUTTONS}.find((each) => each.innerText.trim() === 'Noir').focus()")
    page.press("Enter")
    page.until("!document.querySelector('dialog').open")
    assert [cue.style.name for cue in saved(page, tmp_path).cues] == ["ink", "noir:gray", "noir"]
    assert page.run("return document.activeElement.closest('li') === document.querySelectorAll('li')[2]")


def test_a_scene_without_a_style_continues_and_strength_moves(page: Browser, tmp_path: Path) -> None:
    pick(page, 2, "")
    change(page, "li:nth-child(1) select:has(option[value=ease])", "ease")
    for card, value in ((1, "0"), (2, "1")):
        page.click(f"li:nth-child({card}) summary")
        page.until(f"document.querySelector('li:nth-child({card}) .value')")
        change(page, f"li:nth-child({card}) [data-path=strength] input[type=number]", value)
    cues = saved(page, tmp_path)
    assert [cue.style.name for cue in cues.cues] == ["ink", "ink", "poster"]
    assert cues.at(0).active.style.strength == pytest.approx(0, abs=1e-5)
    assert cues.at(Fraction(5, 4)).active.style.strength == pytest.approx(0.5, abs=0.01)
    assert cues.at(3).active.style.strength == 1


def test_a_cue_is_added_within_a_scene_and_removed(page: Browser, tmp_path: Path) -> None:
    page.click("li:nth-child(2) .add")
    page.until("document.querySelectorAll('li').length === 4")
    change(page, "li:nth-child(3) input[aria-label^=Start]", "4.25")
    pick(page, 3, "comic")
    assert [(cue.time, cue.style.name) for cue in saved(page, tmp_path).cues][2] == (Fraction(17, 4), "comic")
    page.click("li:nth-child(3) .remove")
    page.until("document.querySelectorAll('li').length === 3")
    assert [cue.style.name for cue in saved(page, tmp_path).cues] == STYLES


def test_a_file_is_edited_again(browser: Browser, tmp_path: Path) -> None:
    """Cues of all kinds survive the command and the page, also on other scenes."""
    (tmp_path / "mine.toml").write_text(
        'format = 1\nname = "mine"\nink = "#123456"\n[[lines]]\nblock = "sobel"'
    )
    (tmp_path / "old.toml").write_text(OLD)
    cues = read_cue_tables(tmp_path / "old.toml", STARTS, tmp_path)
    assert [cue.get("scene") for cue in cues] == [1, None, 2, 3]
    open_sheet(browser, tmp_path, cues, 4)
    assert saved(browser, tmp_path) == read_cue_file(tmp_path / "old.toml")
    (tmp_path / "elsewhere").mkdir()
    for folder in (tmp_path, tmp_path / "elsewhere"):
        again = cue_file_text(STARTS, None, read_cue_tables(tmp_path / "old.toml", STARTS, folder))
        (folder / "again.toml").write_text(again)
        assert read_cue_file(folder / "again.toml") == read_cue_file(tmp_path / "old.toml")


def test_impossible_cues_are_not_saved(page: Browser) -> None:
    page.click("li:nth-child(1) .add")
    pick(page, 2, "comic")
    change(page, "li:nth-child(2) select:has(option[value=wipe])", "wipe")
    change(page, "li:nth-child(2) input[aria-label^=Seconds]", "9")
    assert page.run(SAVED.replace("globalThis.saved.text()", "globalThis.saved")) is None
    page.until(
        "document.querySelector('footer output').textContent.includes('but the next cue begins after 1.50 s')"
    )


def mark(page: Browser, number: int) -> tuple[float, float, float]:
    """The middle of a cue on the timeline, and the width of the timeline, in pixels."""
    x, y, _, _ = page.still(f"[data-place=mark-{number}]")
    return x, y, page.place("#timeline")[2]


def test_a_cue_is_moved_along_the_timeline(page: Browser, tmp_path: Path) -> None:
    x, y, width = mark(page, 1)
    page.drag((x, y), (x + width / 10, y))  # one of ten seconds
    assert float(saved(page, tmp_path).cues[1].time) == pytest.approx(3.5, abs=0.02)
    x, y, _ = mark(page, 1)
    page.drag((x, y), (x - width / 10 + 3, y))
    page.until("document.querySelectorAll('li').length === 3")
    assert saved(page, tmp_path).cues[1].time == STARTS[1], "it snaps to the start of the scene"
    page.run("document.querySelector('[data-place=mark-2]').focus()")
    page.press("ArrowLeft", "ArrowLeft")
    assert float(saved(page, tmp_path).cues[2].time) == pytest.approx(5.8)
    assert page.run("return document.activeElement.dataset.place") == "mark-2"


@pytest.mark.parametrize("target", [".scene:nth-child(2)", "li:nth-child(2)"])
def test_a_style_is_dropped_on_a_scene(page: Browser, tmp_path: Path, target: str) -> None:
    page.run(
        """const data = new DataTransfer();
        const tile = [...document.querySelectorAll("#styles figure")].find((each) => each.title === "comic");
        tile.dispatchEvent(new DragEvent("dragstart", { dataTransfer: data }));
        document.querySelector(target).dispatchEvent(new DragEvent("drop", { dataTransfer: data }));""",
        target=target,
    )
    assert [cue.style.name for cue in saved(page, tmp_path).cues] == ["ink", "comic", "poster"]
