"""Styles over time in the designer: the scenes of the film, and the cues that the picture shows."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import Browser
from designing import Page, served, shown
from media import make_picture
from stories import PLACES, shot, write_film

import vidstyle
from vidstyle.cues.cue_file import read_cue_file
from vidstyle.design.page.design_server import DesignServer
from vidstyle.design.style_list import list_styles
from vidstyle.preview.clip import open_clip

CUES = """
format = 1
[[cue]]
time = 0
style = "ink"
[[cue]]
time = 0.8
style = "sketch"
seconds = 0.4
"""
FRAMES = 40
STYLED = 2
DISABLED = "return ['undo', 'redo'].map((id) => document.getElementById(id).disabled)"
SAVE = """
globalThis.saved = null;
URL.createObjectURL = (blob) => { globalThis.saved = blob; return "about:blank#saved"; };
HTMLAnchorElement.prototype.click = () => {};
document.getElementById("save-cues").click();
return globalThis.saved?.text() ?? "";
"""


@pytest.fixture(scope="module")
def film() -> Iterator[Path]:
    """Two shots of 0.8 s each."""
    with tempfile.TemporaryDirectory() as folder:
        frames = [*shot(PLACES[0], FRAMES // 2), *shot(PLACES[2], FRAMES // 2)]
        yield write_film(Path(folder) / "film.mp4", frames)


@pytest.fixture
def server(tmp_path: Path, film: Path) -> Iterator[DesignServer]:
    with served(tmp_path, open_clip(film)) as server:
        yield server


@pytest.fixture
def page(server: DesignServer) -> Iterator[Page]:
    with shown(server) as page:
        page.ask("open", style="ink")
        yield page


def picture_at(page: Page, number: int) -> np.ndarray:
    page.pictures.clear()
    page.ask("frame", number=number)
    while (sent := page.picture(STYLED, number)).revision != page.told["state"]["revision"]:
        pass
    return sent.pixels.astype(int)


def test_scenes_have_their_starts_and_all_styles(page: Page) -> None:
    sheet = page.ask("scenes")["sheet"]
    assert [float(scene["start"]) for scene in sheet["scenes"]] == [0, pytest.approx(0.8, abs=0.05)]
    assert float(sheet["end"]) == pytest.approx(1.6, abs=0.05) and sheet["cues"] == []
    assert {"ink", "sketch", "comic"} <= set(sheet["styles"])


def test_the_picture_has_the_style_of_its_time_and_both_in_a_transition(page: Page) -> None:
    """The open style returns where the cues end."""
    alone = {}
    page.ask("watch", solo=None, side=64, where="server")
    for style, numbers in {"ink": (5, 25), "sketch": (25, 35)}.items():
        page.ask("open", style=style)
        alone |= {(style, number): picture_at(page, number) for number in numbers}
    page.ask("watch", solo=None, side=64, where="page")
    assert page.error("cues", text=CUES) == ""
    assert np.abs(picture_at(page, 5) - alone["ink", 5]).mean() < 3, "JPEG beside PNG"
    assert np.abs(picture_at(page, 35) - alone["sketch", 35]).mean() < 3
    mixed = (alone["ink", 25] + alone["sketch", 25]) / 2
    assert np.abs(picture_at(page, 25) - mixed).mean() < 3
    assert np.abs(alone["ink", 25] - mixed).mean() > 6
    assert "compares the open style" in page.error("check", side=64)
    page.order.clear()
    page.ask("cues", text="")
    assert "plan" in page.order


def test_a_cue_in_the_open_style_has_its_unsaved_changes(page: Page) -> None:
    page.ask("cues", text=CUES)
    before = picture_at(page, 5)
    page.ask("field", name="paper", value="#3050ff", gesture=1)
    after = picture_at(page, 5)
    assert after[..., 2].mean() - after[..., 0].mean() > 60 > before[..., 2].mean() - before[..., 0].mean()
    page.ask("undo")
    assert np.abs(picture_at(page, 5) - before).mean() < 1


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("format = 1", "has no cues"),
        ('format = 1\n[[cue]]\ntime = 0\nstyle = "none"', "none"),
        ("[[cue", "cues.toml"),
        (CUES.replace("0.4", "4").replace("time = 0.8", "time = 0.8\ntransition = 7"), "transition = 7"),
    ],
)
def test_mistakes_are_one_line_and_keep_the_picture(page: Page, text: str, error: str) -> None:
    page.ask("cues", text=CUES)
    assert error in (told := page.error("cues", text=text)) and "\n" not in told
    assert picture_at(page, 35) is not None


def test_a_film_is_rendered_with_its_cues(page: Page, film: Path, tmp_path: Path) -> None:
    (tmp_path / "cues.toml").write_text(CUES)
    page.ask("cues", text=CUES)
    assert page.error("render", name="out.mp4", overwrite=False, frames=None) == ""
    vidstyle.render(film, tmp_path / "by-hand.mp4", read_cue_file(tmp_path / "cues.toml"))
    assert (tmp_path / "out.mp4").read_bytes() == (tmp_path / "by-hand.mp4").read_bytes()
    assert page.ask("command", name="", frames=None)["text"].endswith("output.mp4 --cues cues.toml")


def test_a_photograph_has_one_scene_and_a_page_that_asks_for_a_film_is_told(tmp_path: Path) -> None:
    clip = open_clip(make_picture(tmp_path / "photo.png", size=(50, 40)))
    with served(tmp_path, clip) as server, shown(server) as page:
        assert len(page.ask("scenes")["sheet"]["scenes"]) == 1


def test_cues_are_made_by_mouse_and_by_keyboard_undone_and_saved(
    browser: Browser, server: DesignServer, tmp_path: Path
) -> None:
    browser.open(server.url)
    browser.until("document.querySelector('.tile')")
    number = list(list_styles(tmp_path)).index("sketch")
    browser.run("document.querySelectorAll('.tile:not(.new)')[number].click()", number=number)
    browser.until("document.getElementById('start').hidden")
    browser.until("document.getElementById('picture').dataset.revision")
    browser.press("t")
    browser.until("document.querySelectorAll('#cues li').length === 2")
    assert browser.run(DISABLED) == [True, True]
    for scene, style in ((1, "ink"), (2, "comic")):
        browser.run(
            """const data = new DataTransfer();
            const tiles = [...document.querySelectorAll("#styles figure")];
            const tile = tiles.find(({ title }) => title === style);
            tile.dispatchEvent(new DragEvent("dragstart", { dataTransfer: data }));
            document.querySelector(strip).dispatchEvent(new DragEvent("drop", { dataTransfer: data }));""",
            strip=f"#timeline .scene:nth-child({scene})", style=style,
        )  # fmt: skip
    browser.until("document.querySelectorAll('#timeline .mark').length === 2")
    first, second = "[data-place=mark-0]", "[data-place=mark-1]"
    x, y, _, _ = browser.still(second)
    browser.drag((x, y), (x + browser.place("#timeline")[2] / 8, y))
    browser.until(f"document.querySelector({second!r}).getAttribute('aria-label').includes('at 1')")
    moved = saved(browser, tmp_path)[1][0]
    assert moved == pytest.approx(1.0, abs=0.06)
    browser.run(f"document.querySelector({second!r}).focus()")
    browser.press("ArrowRight")
    assert saved(browser, tmp_path)[1] == (pytest.approx(moved + 0.1), "comic")
    assert browser.run(DISABLED) == [False, True]
    browser.click("#undo")
    browser.click("#undo")
    browser.until("document.querySelectorAll('#cues li').length === 2")
    assert [style for _, style in saved(browser, tmp_path)] == ["ink", "comic"]
    browser.click("#redo")
    assert saved(browser, tmp_path)[1][0] == pytest.approx(moved)
    browser.run(f"document.querySelector({first!r}).focus()")
    browser.press("Enter")
    browser.until("Number(document.getElementById('place').value) === 0")
    assert server.browsers[0].frames.shown.cues is not None
    browser.run("document.activeElement.blur()")
    browser.press("t")
    browser.until("document.getElementById('scenes').hidden")
    browser.until("!document.querySelector('#tabs [value=scenes]').offsetParent")


def saved(browser: Browser, folder: Path) -> list[tuple[float, str]]:
    """Times and styles of the file that the page saves."""
    (folder / "saved.toml").write_text(browser.run(SAVE), encoding="utf-8")
    return [(float(cue.time), cue.style.name) for cue in read_cue_file(folder / "saved.toml").cues]
