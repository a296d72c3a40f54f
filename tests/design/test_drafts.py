"""Drafts of several styles: none replaces another."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import Browser
from designing import Page, served, shown
from media import make_picture

from vidstyle.design import drafts
from vidstyle.design.drafts import Drafts
from vidstyle.preview.clip import open_clip


def offered(page: Page) -> list[str]:
    """Return the names of the drafts that the page lists."""
    return [draft["name"] for draft in page.told["drafts"]]


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A photograph, and the drafts of two earlier runs: of ink, and later of sketch."""
    path = make_picture(tmp_path / "photo.png", size=(96, 64))
    for style in ("ink", "sketch"):
        with served(tmp_path, open_clip(path)) as server, shown(server) as page:
            page.ask("open", style=style)
            page.ask("field", name="ink", value="#112233", gesture=1)
    return path


def test_a_draft_of_another_style_remains(tmp_path: Path, photo: Path) -> None:
    with served(tmp_path, open_clip(photo)) as server, shown(server) as page:
        assert offered(page)[0] == "sketch" and len(offered(page)) == 2
        page.ask("open", style="comic")
        page.ask("field", name="ink", value="#112233", gesture=1)
        page.ask("save_as", name="mine", overwrite=False)
        page.ask("draft", accept=False, place=0)
        assert offered(page)[0] == "ink" and len(offered(page)) == 1
        page.ask("field", name="ink", value="#445566", gesture=2)
    with served(tmp_path, open_clip(photo)) as server, shown(server) as page:
        assert offered(page)[0] == "mine" and len(offered(page)) == 2
        page.ask("draft", accept=True, place=0)
        assert (page.told["state"]["name"], offered(page)[0]) == ("mine", "ink")
        page.ask("draft", accept=True, place=0)
        assert page.told["state"]["name"] == "ink"
        # The draft of "mine" was open: it is offered in place of the other one.
        assert offered(page)[0] == "mine" and len(offered(page)) == 1
        page.ask("field", name="ink", value="#778899", gesture=3)
        page.ask("draft", accept=True, place=0)
        assert (page.told["state"]["name"], offered(page)[0]) == ("mine", "ink")
        fields = {entry["name"]: entry["value"] for entry in page.told["state"]["fields"]}
        assert fields["ink"] == "#445566", "as it was left"
    left = Drafts(tmp_path / "drafts" / "draft.json").offered
    assert {draft.table["name"]: draft.table["ink"] for draft in left} == {
        "ink": "#778899",
        "mine": "#445566",
    }


def test_drafts_are_listed_and_restored_or_discarded(tmp_path: Path, photo: Path, browser: Browser) -> None:
    names = "[...document.querySelectorAll('#drafts b')].map((each) => each.textContent).join()"
    entry = "#drafts li:nth-child({}) button:nth-of-type({})"
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until("document.querySelector('#looks .to-drafts').textContent === 'Unsaved changes (2)'")
        browser.click("#looks .to-drafts")
        browser.until(f"{names} === 'Sketch,Ink'")
        browser.click(entry.format(1, 2))
        browser.until(f"{names} === 'Ink'")
        browser.click(entry.format(1, 1))
        browser.until("document.getElementById('name').value === 'Ink'")
        browser.until("document.querySelector('#looks .to-drafts').hidden")
        assert not browser.run("return document.getElementById('drafts-dialog').open")
        assert server.designer.opened.style.ink == "#112233"
        browser.open("about:blank")  # without a question of the browser


def test_drafts_say_what_they_were_made_on_and_where(
    tmp_path: Path, photo: Path, browser: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside the looks, changes that were left in another folder would be nobody's."""
    (tmp_path / "elsewhere").mkdir()
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until("!document.querySelector('#looks .to-drafts').hidden")
        assert "on photo.png" in browser.run("return document.getElementById('drafts').textContent")
        assert "folder" not in browser.run("return document.getElementById('drafts').textContent")
    here = Path.cwd().name
    monkeypatch.chdir(tmp_path / "elsewhere")
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until("document.getElementById('drafts').children.length === 2")
        assert browser.run("return document.querySelector('#looks .to-drafts').hidden")
        assert not browser.run("return document.querySelector('#actions .to-drafts').hidden")
        assert f"in the folder {here}" in browser.run("return document.getElementById('drafts').textContent")


def test_changes_of_the_open_look_are_kept_without_a_question(
    tmp_path: Path, photo: Path, browser: Browser
) -> None:
    """Somebody who wants a film does not know what it would be to save a style."""
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until("document.querySelector('.tile:not(.new)')")
        for name, more in (("Comic", "2"), ("Ink", "3")):
            tile = "[...document.querySelectorAll('.tile')].find((each) => each.textContent.startsWith(name))"
            browser.run(f"{tile}.click()", name=name)
            browser.until(f"document.getElementById('name').value === {name!r}")
            browser.until(f"document.querySelector('.to-drafts').textContent === 'Unsaved changes ({more})'")
            browser.run(
                """const slider = document.querySelector(".style-panel input[type=range]");
                slider.value = slider.value === slider.max ? slider.min : slider.max;
                slider.dispatchEvent(new Event("input"));"""
            )
            browser.until("document.getElementById('saved').textContent === 'Edited'")
            browser.run("document.getElementById('to-styles').click()")
        assert not browser.run("return document.querySelector('dialog[open]')")
        assert browser.run("return document.getElementById('toast').textContent").startswith("Your changes")
        names = [draft.table["name"] for draft in server.designer.drafts.offered]
        assert names == ["comic", "sketch", "ink"], "newest first"
        browser.open("about:blank")


def test_the_tab_key_stays_in_an_open_dialog(tmp_path: Path, photo: Path, browser: Browser) -> None:
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until("document.querySelector('#looks .to-drafts:not([hidden])')")
        browser.click("#looks .to-drafts")
        inside = "return document.activeElement.closest('dialog') !== null"
        for key in ("Tab", "Shift+Tab"):
            focused = set()
            for _ in range(7):
                browser.press(key)
                assert browser.run(inside)
                focused.add(browser.run("return document.activeElement.parentElement.textContent"))
            assert len(focused) > 2, "it moves"


def test_one_draft_too_many_replaces_the_oldest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drafts, "MAX_DRAFTS", 2)
    for name in ("oldest", "older", "newest"):
        kept = Drafts(tmp_path / "draft.json")
        kept.write({"name": name}, None, None)
    assert [draft.table["name"] for draft in kept.offered] == ["older"], "the replaced one is not offered"
    found = Drafts(tmp_path / "draft.json").offered
    assert [draft.table["name"] for draft in found] == ["newest", "older"]
