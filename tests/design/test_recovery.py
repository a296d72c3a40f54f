"""The page of the designer survives what users and servers do: reloads, lost connections, other styles."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Browser
from media import make_clip
from waiting import eventually

from vidstyle.design.designer import Designer
from vidstyle.design.drafts import Drafts
from vidstyle.design.page import open_page
from vidstyle.design.page.design_server import DesignServer
from vidstyle.preview.clip import open_clip

COLOR_OF_FIRST_ENTRY = """
const canvas = document.querySelector(".history canvas");
const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
const sums = [0, 0, 0, 0];
data.forEach((value, at) => (sums[at % 4] += value / (data.length / 4)));
return sums;
"""


@pytest.fixture
def server(tmp_path: Path, browser: Browser) -> Iterator[DesignServer]:
    clip = open_clip(make_clip(tmp_path / "film.mp4", size=(128, 72), frames=8))
    server = open_page(Designer(clip, tmp_path, Drafts(tmp_path / "draft.json")), 0, "cpu")
    browser.open(server.url)
    browser.until("document.querySelector('.tile')")
    yield server
    browser.open("about:blank")
    server.close()


def open_style(browser: Browser, name: str) -> None:
    """Open a style, and wait for its picture in the history."""
    if browser.run("return document.getElementById('start').hidden"):
        browser.click("#to-styles")
    tiles = "[...document.querySelectorAll('.tile b')]"
    browser.run(f"{tiles}.find((each) => each.textContent === name).click()", name=name)
    browser.until(f"document.getElementById('name').value === {name!r}")
    browser.run("document.querySelector('[role=tab][value=history]').click()")
    eventually(lambda: browser.run(COLOR_OF_FIRST_ENTRY)[3] > 0, "the history has no picture")


def test_the_history_shows_no_picture_of_another_style(browser: Browser, server: DesignServer) -> None:
    open_style(browser, "Blueprint")
    red, _, blue, _ = browser.run(COLOR_OF_FIRST_ENTRY)
    assert blue - red > 50
    open_style(browser, "Ink")
    red, _, blue, _ = browser.run(COLOR_OF_FIRST_ENTRY)
    assert abs(blue - red) < 30


def test_the_position_in_the_film_is_kept_when_the_page_is_loaded_again(
    browser: Browser, server: DesignServer
) -> None:
    open_style(browser, "Ink")
    browser.run("document.getElementById('next').click(); document.getElementById('next').click();")
    browser.until("document.getElementById('place').value === '2'")
    browser.run("globalThis.isOld = true; location.reload()")
    browser.until("!globalThis.isOld && document.getElementById('place')?.value === '2'")


def test_an_empty_file_is_reported(browser: Browser, server: DesignServer) -> None:
    browser.run(
        """const data = new DataTransfer();
        data.items.add(new File([], "nothing.mp4"));
        dispatchEvent(new DragEvent("drop", { dataTransfer: data }));"""
    )
    line = "document.getElementById('open-error')"
    browser.until(f"{line}.checkVisibility() && {line}.textContent === 'nothing.mp4: the file is empty.'")


def test_a_value_that_is_changed_while_the_connection_is_lost_is_set_afterwards(
    browser: Browser, server: DesignServer
) -> None:
    open_style(browser, "Ink")
    browser.run("document.querySelector('[role=tab][value=style]').click()")

    async def disconnect() -> None:
        await server.browsers[0]._socket.close()

    server.submit(disconnect)
    browser.until("document.querySelector('.lost').matches(':popover-open')")
    path = browser.run(
        """const range = document.querySelector(".style-panel input[type=range]");
        range.value = range.max;
        range.dispatchEvent(new Event("input"));
        return range.closest("[data-path]").dataset.path;"""
    )
    browser.until("!document.querySelector('.lost').matches(':popover-open')")
    eventually(lambda: server.designer.opened.is_changed, f"{path} is not set")


def test_edits_leave_no_elements_and_listeners_behind(browser: Browser, server: DesignServer) -> None:
    """Dragging for minutes: the list of edits shows the last twenty."""
    open_style(browser, "Sketch")
    browser.run("document.querySelector('[role=tab][value=style]').click()")

    def edit(count: int) -> None:
        browser.run(
            """const ranges = document.querySelectorAll(".style-panel > .values input[type=range]");
            for (let edit = 0; edit < count; edit++) {
              const range = ranges[edit % 2];
              dispatchEvent(new PointerEvent("pointerdown"));
              for (const part of [0.3, 0.5, 0.4 + 0.1 * (edit % 3)]) {
                range.value = part * range.max;
                range.dispatchEvent(new Event("input"));
                await new Promise(requestAnimationFrame);
              }
              dispatchEvent(new PointerEvent("pointerup"));
            }""",
            count=count,
        )
        shown = "return Number(document.getElementById('picture').dataset.revision)"
        eventually(lambda: browser.run(shown) == server.designer.opened.revision)

    def count() -> tuple[int, int]:
        browser.call("HeapProfiler.collectGarbage")
        counts = browser.call("Memory.getDOMCounters")
        return counts["nodes"], counts["jsEventListeners"]

    # Later rows replace earlier ones once the list is full.
    while browser.run("return document.querySelectorAll('ol.history > li').length") < 20:
        edit(30)
    nodes, listeners = count()
    edit(60)
    more_nodes, more_listeners = count()
    assert more_nodes < 1.03 * nodes and more_listeners < 1.03 * listeners


def test_a_stopped_server_is_called_stopped_and_covers_no_button(
    browser: Browser, server: DesignServer
) -> None:
    open_style(browser, "Ink")
    server.close()
    browser.until("document.querySelector('.lost').textContent.startsWith('vidstyle has stopped')")
    covered = """const { top } = document.querySelector(".lost").getBoundingClientRect();
    const bottom = (id) => document.getElementById(id).getBoundingClientRect().bottom;
    return ["save", "undo", "render"].filter((id) => bottom(id) > top);"""
    assert browser.run(covered) == []
