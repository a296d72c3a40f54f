"""A designer in a browser, controlled by mouse and keyboard."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browser import Browser
from media import make_clip
from waiting import eventually

from vidstyle.design.designer import Designer
from vidstyle.design.drafts import Drafts
from vidstyle.design.page import open_page
from vidstyle.design.page.design_server import DesignServer
from vidstyle.preview.clip import Clip, open_clip

WATCH = """
globalThis.faults = [];
globalThis.compiled = 0;
addEventListener("error", (event) => faults.push(event.message));
addEventListener("unhandledrejection", (event) => faults.push(String(event.reason)));
addEventListener("securitypolicyviolation", (event) => faults.push(event.violatedDirective));
addEventListener("beforeunload", (event) => event.stopImmediatePropagation());
const compile = WebGL2RenderingContext.prototype.compileShader;
WebGL2RenderingContext.prototype.compileShader = function (...all) {
  globalThis.compiled += 1;
  return compile.apply(this, all);
};
"""
"""Counts shaders, records errors of the page, and disables the question before leaving."""
FRAMES = 10
CHOSEN = ".card.selected"


class Page:
    """A designer and its browser."""

    def __init__(self, browser: Browser, server: DesignServer, folder: Path) -> None:
        self.browser, self.server, self.folder = browser, server, folder

    def steps(self, layer: str) -> list[str]:
        document = self.server.designer.opened
        return [step.table["block"] for step in document.content.layers[layer]]

    @property
    def history(self) -> list[str]:
        """Return the labels of the edits that can be undone, oldest first."""
        return [each["label"] for each in self.server.designer.state["history"]]

    def add(self, gap: str, block: str, name: str) -> None:
        """Add a step by mouse."""
        self.browser.click(f".gap{gap}")
        self.browser.until("document.activeElement.id === 'search'")
        self.browser.type(block)
        self.browser.until(f"document.getElementById('blocks').dataset.asked === {block!r}")
        self.browser.click("#blocks .option")
        self.shows(name)

    def slide(self, name: str, part: float) -> float:
        """Drag a slider to a part of its length, and return its value."""
        slider = f".inspector [data-path$='.{name}'] input[type=range]"
        x, y, width, _ = self.browser.still(slider)
        part_of = "return Number(document.querySelector(slider).style.getPropertyValue('--part'))"
        now = self.browser.run(part_of, slider=slider)
        self.browser.drag((x + (now - 0.5) * (width - 16), y), (x + (part - 0.5) * (width - 16), y))
        number = slider.replace("range", "number")
        return float(self.browser.run("return document.querySelector(number).value", number=number))

    def drop(self, path: Path) -> None:
        """Drop a file on the page."""
        self.browser.run(
            """const data = new DataTransfer();
            data.items.add(new File([Uint8Array.from(atob(text), (each) => each.charCodeAt(0))], name));
            dispatchEvent(new DragEvent("drop", { dataTransfer: data }));""",
            text=base64.b64encode(path.read_bytes()).decode(), name=path.name,
        )  # fmt: skip

    def begin(self) -> None:
        """Start an empty style."""
        self.browser.click(".tile.new")
        self.browser.until("document.querySelectorAll('.gap').length === 3")

    def moves(self) -> None:
        """Wait until the picture has changed twice without input."""
        seen: set[str] = set()

        def has_moved() -> bool:
            seen.add(self.browser.run("return document.getElementById('picture').toDataURL()"))
            return len(seen) > 2

        eventually(has_moved, "the picture stands still")

    def is_drawn(self) -> None:
        """Wait until the picture shows the current style."""
        revision = self.server.designer.opened.revision
        self.browser.until(f"document.getElementById('picture').dataset.revision >= {revision}")

    def shows(self, text: str) -> None:
        """Wait until the selected card has this name and the server is idle."""
        self.browser.until(f"document.querySelector('{CHOSEN} .name')?.textContent === {text!r}")

    def told(self, text: str) -> None:
        """Wait for an announcement to screen readers."""
        self.browser.until(f"document.getElementById('toast').textContent.includes({text!r})")

    def undone(self, label: str) -> None:
        """Wait until this is the edit that undo reverts."""
        self.browser.until(f"document.getElementById('undo').title.includes({label!r})")


@contextmanager
def shown(browser: Browser, clip: Clip, folder: Path) -> Iterator[Page]:
    """Show the page of a designer that writes to a folder."""
    server = open_page(Designer(clip, folder, Drafts(folder / "draft.json")), 0, "cpu")
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=1440, height=900, deviceScaleFactor=1, mobile=False
    )
    browser.call("Network.disable")  # it reports every message of every socket
    watching = browser.call("Page.addScriptToEvaluateOnNewDocument", source=WATCH)["identifier"]
    try:
        browser.open(server.url)
        browser.until("document.querySelector('.tile')")
        yield Page(browser, server, folder)
        assert browser.run("return faults") == []
        browser.open("about:blank")
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=watching)
        server.close()


@pytest.fixture
def film(tmp_path: Path) -> Path:
    return make_clip(tmp_path / "film.mp4", size=(128, 72), frames=FRAMES + 2)


@pytest.fixture
def page(browser: Browser, film: Path, tmp_path: Path) -> Iterator[Page]:
    with shown(browser, open_clip(film), tmp_path) as page:
        yield page


def open_style(page: Page, name: str) -> None:
    """Open a shipped style, and show its diagram."""
    page.browser.run(
        "document.getElementById('to-styles').click();"
        "[...document.querySelectorAll('.tile b')].find((each) => each.textContent === name).click()",
        name=name,
    )
    page.browser.until(f"document.getElementById('name').value === {name!r}")
    if not page.browser.run("return document.body.classList.contains('building')"):
        page.browser.click("#to-diagram")
