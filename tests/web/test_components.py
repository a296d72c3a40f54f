"""The components that the pages share, all on one page: themes, narrow windows, forced colours, keyboard."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest
from browser import Browser

from vidstyle.design.page.design_server import STATIC_FOLDER
from vidstyle.export import module_text
from vidstyle.export.page import page_script, viewer_css

SCRIPT = Path(__file__).parents[1] / "support" / "pages" / "components.js"
_DESIGNER = (STATIC_FOLDER / "design.css").read_text(encoding="utf-8")
STYLES = {
    "designer": module_text("components.css") + _DESIGNER,
    "exported page": viewer_css(),
}
PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Components</title>
<style>{css} body {{ display: block; overflow: auto; height: auto; padding: 1rem; }}</style>
<main><h1>Components</h1><h2>A heading</h2><p>A text, and <code>code</code>.</p>
<p class="quiet">A quiet text.</p>
<p><button id="theme"><svg viewBox="0 0 16 16"><path d="M8 1.8a6.2 6.2 0 1 0 0 12.4z"/></svg></button></p>
<div id="buttons" style="display: flex; flex-wrap: wrap; gap: .5rem"></div>
<div id="values" class="values"></div>
<p id="message" role="status" style="position: static"></p><p id="alarm" role="alert"></p>
<p class="lost" role="alert">A lost server.</p><p class="unseen">For screen readers.</p></main>
<script type="module">{script}</script></html>"""

CONTRASTS = """
const canvas = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
const painted = (colors) => {
  for (const color of colors) {
    canvas.fillStyle = color;
    canvas.fillRect(0, 0, 1, 1);
  }
  return [...canvas.getImageData(0, 0, 1, 1).data].slice(0, 3);
};
const linear = (code) => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);
const light = (codes) =>
  codes.reduce((sum, code, place) => sum + linear(code / 255) * [0.2126, 0.7152, 0.0722][place], 0);
const grounds = (element) =>
  element ? [...grounds(element.parentElement), getComputedStyle(element).backgroundColor] : ["white"];
const isText = (child) => child.nodeType === 3 && child.textContent.trim();
return [...document.querySelectorAll("main *")]
  .filter((each) => each.checkVisibility() && !each.closest(":disabled, .unseen, option"))
  .filter((each) => [...each.childNodes].some(isText))
  .map((each) => {
    const ground = grounds(each);
    const lights = [light(painted(ground)), light(painted([...ground, getComputedStyle(each).color]))];
    return [each.textContent.trim(), (Math.max(...lights) + 0.05) / (Math.min(...lights) + 0.05)];
  });
"""
"""The ratio of luminance of each text and its background, as in WCAG 2."""


@pytest.fixture(params=STYLES)
def page(request: pytest.FixtureRequest, browser: Browser, tmp_path: Path) -> Iterator[Browser]:
    path = tmp_path / "components.html"
    path.write_text(PAGE.format(css=STYLES[request.param], script=page_script(SCRIPT)), encoding="utf-8")
    browser.open(path.as_uri())
    browser.until("'ready' in document.body.dataset")
    yield browser
    assert not [event for event in browser.events if event["method"] == "Runtime.exceptionThrown"]


@contextmanager
def emulated(browser: Browser, width: int = 1280, **features: str) -> Iterator[None]:
    """Show the page in a window of this width, with these media features."""
    named = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
    metrics = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", **metrics)
    browser.call("Emulation.setEmulatedMedia", features=named)
    try:
        yield
    finally:
        browser.call("Emulation.setEmulatedMedia", features=[])
        browser.call("Emulation.clearDeviceMetricsOverride")


def seen(browser: Browser, selector: str) -> np.ndarray:
    """The pixels of an element, H x W x 3."""
    x, y, width, height = browser.place(selector)
    scroll = browser.run("return scrollY")
    clip = {"x": x - width / 2, "y": y - height / 2 + scroll, "width": width, "height": height, "scale": 1}
    data = browser.call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)["data"]
    return cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_all_texts_can_be_read_in_both_themes(page: Browser, theme: str) -> None:
    with emulated(page, prefers_color_scheme=theme):
        found = page.run(CONTRASTS)
    assert len(found) > 20
    assert [(text, round(ratio, 2)) for text, ratio in found if ratio < 4.5] == []


def test_a_narrow_window_cuts_no_component(page: Browser) -> None:
    """360 px wide, which is also a window of 720 px at 200 %."""
    with emulated(page, width=360):
        assert page.run("return document.documentElement.scrollWidth") <= 360
        cut = """return [...document.querySelectorAll("main :is(button, input, select, label)")]
        .filter((each) => each.getBoundingClientRect().right > 360).map((each) => each.outerHTML)"""
        assert page.run(cut) == []


def test_sliders_are_visible_with_forced_colours(page: Browser) -> None:
    with emulated(page, forced_colors="active"):
        for number in range(3):
            pixels = seen(page, f"#value-{number}").astype(int)
            ground = pixels[0, 0]
            drawn = np.abs(pixels - ground).max(axis=2) > 100
            assert drawn.any(axis=0).mean() > 0.8, "the track"
            assert drawn.sum(axis=0).max() > 8, "the thumb"


def test_every_control_shows_its_value_and_is_set_by_keyboard(page: Browser) -> None:
    numbers = "return [...document.querySelectorAll('input[type=number]')].map((each) => each.value)"
    assert page.run(numbers) == ["1", "4.5", "32", ""]
    assert page.run("return ['value-4', 'value-5'].map((id) => document.getElementById(id).checked)") == [
        True,
        False,
    ]
    assert page.run("return document.getElementById('value-6').value") == "#c8460a"
    assert page.run("return document.getElementById('value-8').value") == "mine.png"
    for id, key, told in (
        ("value-0", "ArrowRight", "Low end: "),
        ("value-2", "ArrowLeft", "whole numbers: 31"),
    ):
        page.run("document.getElementById(id).focus()", id=id)
        page.press(key)
        assert told in page.run("return document.getElementById('message').textContent")
