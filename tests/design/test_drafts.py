"""Drafts of several styles: none replaces another."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import Browser
from designing import served, shown
from media import make_picture
from waiting import eventually

from vidstyle.design import drafts
from vidstyle.design.drafts import Drafts
from vidstyle.preview.clip import open_clip


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
        assert (page.told["draft"]["name"], page.told["draft"]["count"]) == ("sketch", 2)
        page.ask("open", style="comic")
        page.ask("field", name="ink", value="#112233", gesture=1)
        page.ask("save_as", name="mine", overwrite=False)
        page.ask("draft", accept=False)
        assert (page.told["draft"]["name"], page.told["draft"]["count"]) == ("ink", 1)
        page.ask("field", name="ink", value="#445566", gesture=2)
    with served(tmp_path, open_clip(photo)) as server, shown(server) as page:
        assert (page.told["draft"]["name"], page.told["draft"]["count"]) == ("mine", 2)
        page.ask("draft", accept=True)
        assert (page.told["state"]["name"], page.told["draft"]["name"]) == ("mine", "ink")
        page.ask("draft", accept=True)
        assert page.told["state"]["name"] == "ink"
        # The draft of "mine" was open: it is offered in place of the other one.
        assert (page.told["draft"]["name"], page.told["draft"]["count"]) == ("mine", 1)
        page.ask("field", name="ink", value="#778899", gesture=3)
        page.ask("draft", accept=True)
        assert (page.told["state"]["name"], page.told["draft"]["name"]) == ("mine", "ink")
        fields = {entry["name"]: entry["value"] for entry in page.told["state"]["fields"]}
        assert fields["ink"] == "#445566", "as it was left"
    left = Drafts(tmp_path / "drafts" / "draft.json").read()
    assert {draft.table["name"]: draft.table["ink"] for draft in left} == {
        "ink": "#778899",
        "mine": "#445566",
    }


def test_drafts_are_offered_one_after_the_other(tmp_path: Path, photo: Path, browser: Browser) -> None:
    offer = "document.getElementById('draft')"
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until(f"{offer}.textContent.includes('“Sketch” has unsaved changes')")
        assert browser.run(f"return {offer}.textContent.includes('(1 of 2)')")
        press = f"[...{offer}.querySelectorAll('button')].find((each) => each.textContent === name).click()"
        browser.run(press, name="Discard")
        browser.until(f"{offer}.textContent.includes('“Ink” has unsaved changes')")
        assert not browser.run(f"return {offer}.textContent.includes(' of ')")
        browser.run(press, name="Restore")
        browser.until(f"{offer}.hidden && document.getElementById('name').value === 'Ink'")
        eventually(lambda: server.designer.opened.style.ink == "#112233")


def test_no_question_is_asked_before_a_draft_since_both_styles_are_kept(
    tmp_path: Path, photo: Path, browser: Browser
) -> None:
    offer = "document.getElementById('draft')"
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        for name, other in (("Sketch", "Ink"), ("Ink", "Sketch")):
            browser.until(f"{offer}.textContent.includes('“{name}” has unsaved changes')")
            browser.run(f"{offer}.querySelector('button').click()")
            browser.until(f"document.getElementById('name').value === {name!r}")
            browser.until(f"{offer}.textContent.includes('“{other}” has unsaved changes')")
        assert len(Drafts(tmp_path / "drafts" / "draft.json").read()) == 2


def test_one_draft_too_many_replaces_the_oldest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drafts, "MAX_DRAFTS", 2)
    for name in ("oldest", "older", "newest"):
        Drafts(tmp_path / "draft.json").write({"name": name}, None, None)
    found = Drafts(tmp_path / "draft.json").read()
    assert [draft.table["name"] for draft in found] == ["newest", "older"]
