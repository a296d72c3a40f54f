"""A picture that is saved on the page of `vidstyle design` is shown."""

from __future__ import annotations

from pathlib import Path

from browser import Browser
from designing import served
from media import make_picture

from vidstyle.preview.clip import open_clip

SHOWN = "document.querySelector('#player[open] img')"


def save_picture(browser: Browser, name: str) -> None:
    """Save the picture under a name with the dialog."""
    browser.click("#render")
    browser.run("document.getElementById('render-name').value = name", name=name)
    browser.click("#render-go")


def test_the_first_picture_of_a_photograph_is_no_draft_at_another_size(
    tmp_path: Path, browser: Browser
) -> None:
    photo = make_picture(tmp_path / "photo.png", size=(750, 500))
    with served(tmp_path, open_clip(photo)) as server:
        server.designer.open("noir")
        source = """globalThis.seen = [];
            addEventListener("DOMContentLoaded", () => {
              const picture = document.getElementById("picture");
              const observer = new MutationObserver(() => seen.push(picture.dataset.lines));
              observer.observe(picture, { attributeFilter: ["data-lines"] });
            });"""
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=source)
        browser.open(server.url)
        browser.until("document.getElementById('picture').dataset.lines === '500'")
        assert set(browser.run("return seen")) == {"500"}


def test_each_saved_picture_is_shown_and_closing_it_leads_to_the_queue(
    tmp_path: Path, browser: Browser
) -> None:
    photo = make_picture(tmp_path / "photo.png", size=(96, 64))
    with served(tmp_path, open_clip(photo)) as server:
        browser.open(server.url)
        browser.until("document.querySelector('.tile:not(.new)')")
        browser.click(".tile:not(.new)")
        browser.until(
            "document.getElementById('start').hidden && document.querySelector('.style-panel .value')"
        )
        for name in ("one.png", "two.png"):
            save_picture(browser, name)
            browser.until(f"{SHOWN}?.alt === {name!r} && {SHOWN}.naturalWidth === 96")
            assert (tmp_path / name).exists()
            assert not browser.run("return document.querySelector('#render-dialog[open]')")
            browser.press("Escape")
            browser.until("document.querySelector('#queue:popover-open')")
            focused = "return document.activeElement.closest('#jobs li').textContent"
            assert browser.run(focused).startswith(name)
            browser.press("Escape")
        browser.open("about:blank")
