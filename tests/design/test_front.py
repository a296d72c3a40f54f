"""The page of `vidstyle open`: a queue of renders, and the ways to other pages."""

from __future__ import annotations

import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from browser import Browser
from designing import shown
from media import make_clip, make_picture, photograph
from PIL import Image
from waiting import LONG, eventually

from vidstyle.cli.parsing.child_pages import ChildPages
from vidstyle.design.designer import Designer
from vidstyle.design.drafts import Drafts
from vidstyle.design.front_door import FrontDoor
from vidstyle.design.page import open_page
from vidstyle.design.page.design_server import DesignServer
from vidstyle.design.style_list import list_styles
from vidstyle.errors import UsageError
from vidstyle.gallery.thumbnail import (
    THUMBNAIL_HEIGHT_PX,
    THUMBNAIL_WIDTH_PX,
    restyle_thumbnail,
    shipped_thumbnail,
)
from vidstyle.preview.clip import open_clip
from vidstyle.preview.representative import GLANCE_SIDE_PX, representative_frame
from vidstyle.style import FIRST_STYLES, load_style, style_names

FOCUSED = """
const frame = () => new Promise(requestAnimationFrame);
return frame().then(frame).then(() => document.activeElement.outerHTML.slice(0, 90));
"""


@pytest.fixture
def revealed() -> list[Path]:
    return []


@pytest.fixture
def server(tmp_path: Path, revealed: list[Path]) -> Iterator[DesignServer]:
    clip = open_clip(make_clip(tmp_path / "film.mp4", size=(64, 36), frames=8))
    front = FrontDoor(
        {"explore": lambda file, report: f"http://127.0.0.1:1/?of={Path(file or '').name}"}, revealed.append
    )
    made = open_page(Designer(clip, tmp_path, Drafts(tmp_path / "draft.json")), 0, "cpu", front)
    yield made
    made.close()


def test_renders_wait_for_one_another_under_names_that_are_free(server: DesignServer, tmp_path: Path) -> None:
    with shown(server) as page:
        page.ask("open", style="sketch")
        asked = [page.say("render", name="", overwrite=False, frames=3) for _ in range(3)]
        eventually(lambda: page.ask("find", text="") and len(page.told.get("queue", [])) == 3)
        numbers = [job["number"] for job in page.told["queue"]]
        page.ask("stop", job=numbers[2])
        assert [page.answer(each).get("file") for each in asked[:2]] == [
            str(tmp_path / "film-sketch.mp4"), str(tmp_path / "film-sketch-2.mp4")
        ]  # fmt: skip
        page.answer(asked[2])
        page.ask("find", text="")
        assert [job["state"] for job in page.told["queue"]] == ["done", "done", "stopped"]
        assert not (tmp_path / "film-sketch-3.mp4").exists()
        assert open_clip(tmp_path / "film-sketch-2.mp4").count == 3


def test_a_stopped_render_is_continued_or_removed_with_its_part(tmp_path: Path) -> None:
    clip = open_clip(make_clip(tmp_path / "long.mp4", size=(128, 72), frames=400))
    server = open_page(Designer(clip, tmp_path, Drafts(tmp_path / "draft.json")), 0, "cpu")

    def is_newest(state: str, least: int) -> bool:
        job = server.queue.message["queue"][-1:]
        return bool(job) and job[0]["state"] == state and job[0]["done"] > least

    with closing(server), shown(server) as page:
        page.ask("open", style="oil")
        for number, end in ((1, "resume"), (2, "discard")):
            asked = page.say("render", name="", overwrite=False, frames=None)
            eventually(lambda: page.ask("find", text="") and is_newest("rendering", 5))
            page.ask("stop", job=number)
            page.answer(asked)
            job = server.queue.job(number)
            assert job.state == "stopped" and job.partial is not None and job.partial.is_file()
            page.ask(end, job=number)
            if end == "resume":
                eventually(lambda: page.ask("find", text="") and is_newest("done", 5))
                assert open_clip(job.path).count == 400
        assert [each["number"] for each in server.queue.message["queue"]] == [1]
    assert [path.name for path in tmp_path.glob("*partial*")] == []


def test_a_film_that_waits_is_rendered_after_another_was_opened(server: DesignServer, tmp_path: Path) -> None:
    content = make_picture(tmp_path / "photo.png", size=(50, 40)).read_bytes()
    with shown(server) as page:
        page.ask("open", style="sketch")
        first = page.say("render", name="", overwrite=False, frames=4)
        for name in ("one.png", "two.png"):
            id = page.say("upload", name=name, size=len(content))
            page.answer(id)
            page.socket.send(content)
            page.answer(id)
            second = page.say("render", name="", overwrite=False, frames=None)
            assert page.answer(second)["file"] == str(tmp_path / f"{name[:3]}-sketch.png")
        assert page.answer(first)["file"] == str(tmp_path / "film-sketch.mp4")


def test_other_pages_and_folders_are_opened_where_the_command_allows_it(
    server: DesignServer, revealed: list[Path], tmp_path: Path
) -> None:
    with shown(server) as page:
        assert page.told["front"] == {"pages": ["explore"], "reveal": True}
        assert page.ask("page", kind="explore")["url"] == "http://127.0.0.1:1/?of=film.mp4"
        assert "cannot be opened" in page.error("page", kind="passwords")
        page.ask("open", style="sketch")
        page.ask("render", name="", overwrite=False, frames=1)
        page.ask("reveal", job=page.told["queue"][0]["number"])
        assert revealed == [tmp_path / "film-sketch.mp4"]
        assert "no job" in page.error("reveal", job=99)


def test_a_rendered_file_is_served_to_be_played_and_no_other_file(
    server: DesignServer, tmp_path: Path
) -> None:
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    root = server.url.partition("/?")[0]
    with shown(server) as page, opener.open(server.url):
        page.ask("open", style="plain")
        page.ask("render", name="", overwrite=False, frames=2)
        (job,) = page.told["queue"]
        film = tmp_path / "film-plain.mp4"
        part = urllib.request.Request(root + job["address"], headers={"Range": "bytes=4-11"})
        with opener.open(part) as answer:
            assert (
                answer.read() == film.read_bytes()[4:12] and answer.headers.get_content_type() == "video/mp4"
            )
        for wrong in ("", "?of=0", "?of=2", "?of=-1", "?of=../film.mp4", f"?of={film}"):
            with pytest.raises(urllib.error.HTTPError, match="404"):
                opener.open(f"{root}/rendered{wrong}")
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(root + job["address"])
        for state in ("waiting", "rendering", "stopped", "failed"):
            server.queue.job(job["number"]).state = state
            with pytest.raises(urllib.error.HTTPError, match="404"):
                opener.open(root + job["address"])
        server.queue.job(job["number"]).state = "done"
        film.unlink()
        with pytest.raises(urllib.error.HTTPError, match="404"):
            opener.open(root + job["address"])


def test_a_comic_is_made_and_shown_under_its_own_policy(server: DesignServer, tmp_path: Path) -> None:
    """Only documents that the page had made are served."""
    made = tmp_path / "film-comic-1.html"
    made.write_text("<title>Comic</title>")
    assert server.front is not None
    pages = {
        "comic": lambda file, report: str(made),
        "print": lambda file, report: str(made.with_suffix(".pdf")),
    }
    server.front = replace(server.front, pages=pages)
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with shown(server) as page, opener.open(server.url):
        address = page.ask("page", kind="comic")["url"]
        assert "film-comic-1.html" in page.told["notice"]
        with opener.open(server.url.partition("/?")[0] + address) as answer:
            assert answer.read() == b"<title>Comic</title>"
            assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
            assert "script-src 'unsafe-inline'" in answer.headers["Content-Security-Policy"]
        assert page.ask("page", kind="print")["url"] == ""
        with pytest.raises(urllib.error.HTTPError, match="404"):
            opener.open(server.url.partition("/?")[0] + "/document?of=2")


def test_a_sheet_of_all_looks_is_made_of_a_photograph(
    server: DesignServer, browser: Browser, tmp_path: Path
) -> None:
    asked: list[str] = []
    made = tmp_path / "photograph-looks-1.html"
    made.write_text("<title>Looks</title>")

    def make(file: str | None, report: Callable[[str], None]) -> str:
        asked.append(Path(str(file)).suffix)
        return str(made)

    assert server.front is not None
    server.front = replace(server.front, pages={"sheet": make, "comic": make})
    browser.open(server.url)
    browser.until("document.querySelector('[data-kind=sheet]')")
    browser.choose_file("#file", make_picture(tmp_path / "photograph.png"))
    browser.until("document.querySelector('[data-kind=comic]').hidden")
    browser.run("document.querySelector('[data-kind=sheet]').click()")
    browser.until("document.querySelector('[data-kind=sheet]').nextElementSibling?.matches('a')")
    assert asked == [".png"]


def test_a_comic_is_cancelled_on_the_page(server: DesignServer, browser: Browser) -> None:
    cancelled = Event()

    def make(file: str | None, report: Callable[[str], None]) -> str:
        report("Drawing: 33 %, 0:04 left")
        assert cancelled.wait(LONG)
        raise UsageError("vidstyle comic", "cancelled")

    assert server.front is not None
    server.front = replace(server.front, pages={"comic": make}, cancel=cancelled.set)
    browser.open(server.url)
    door = "document.querySelector('[data-kind=comic]')"
    browser.until(f"{door} && !{door}.hidden")
    browser.run(f"{door}.click()")
    browser.until(f"{door}.nextElementSibling?.textContent === 'Cancel'")
    browser.until(f"{door}.querySelector('[role=status]').textContent === 'Drawing: 33 %, 0:04 left'")
    browser.run(f"{door}.nextElementSibling.click()")
    browser.until(f"!{door}.nextElementSibling && !{door}.disabled")
    assert "cancelled" in browser.run("return document.getElementById('toast').textContent")


def test_a_command_serves_its_page_until_the_front_page_ends() -> None:
    with ChildPages() as children:
        url = children.open(["live", "test", "--size", "64x36", "--style", "plain", "--to", "page"])
        with urllib.request.build_opener(urllib.request.HTTPCookieProcessor()).open(url) as answer:
            assert b"vidstyle live" in answer.read()
        with pytest.raises(UsageError, match="vidstyle explore"):
            children.open(["explore", "missing.mp4"])
    with pytest.raises(OSError):
        urllib.request.urlopen(url)


def test_a_name_is_not_free_where_an_interrupted_run_has_left_a_part(
    server: DesignServer, tmp_path: Path
) -> None:
    (tmp_path / "film-sketch.partial.mp4").write_bytes(b"part")
    with shown(server) as page:
        page.ask("open", style="sketch")
        assert page.ask("render", name="", overwrite=False, frames=1)["file"].endswith("film-sketch-2.mp4")


@pytest.mark.parametrize(("black", "number"), [(0, 0), (5, 10), (99, 0)])
def test_a_film_that_begins_black_is_shown_by_a_later_frame(tmp_path: Path, black: int, number: int) -> None:
    for each in range(100):
        picture = np.zeros((36, 64, 3), np.uint8) if each <= black - 1 else photograph("astronaut")[:36, :64]
        Image.fromarray(picture).save(tmp_path / f"{each:02}.png")
    assert representative_frame(open_clip(tmp_path)) == number


def test_the_first_picture_is_served_before_any_frame_is_requested(server: DesignServer) -> None:
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    root = server.url.partition("/?")[0]
    with opener.open(server.url) as page, opener.open(f"{root}/opening.js") as script:
        assert b'<script src="opening.js"' in page.read()
        assert b'<img src="glance.jpg"' in script.read()
    with opener.open(f"{root}/glance.jpg") as answer:
        picture = np.asarray(Image.open(answer), float)
    exact = server.designer.clip.frame(representative_frame(server.designer.clip))
    assert picture.shape == exact.shape and np.abs(picture - exact).mean() < 6


def test_blocks_are_shown_on_the_own_picture(server: DesignServer) -> None:
    clip = server.designer.clip
    own = fetch_sample(server, "source")
    shown = clip.glance(representative_frame(clip), GLANCE_SIDE_PX)
    assert np.abs(own - restyle_thumbnail(load_style("plain"), shown)).mean() < 6
    gray = fetch_sample(server, "to_gray")
    assert np.ptp(gray, axis=2).mean() < 3 < np.ptp(own, axis=2).mean()


def fetch_sample(server: DesignServer, name: str) -> np.ndarray:
    """Return the picture of a block that the server sends, H x W x 3."""
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with opener.open(server.url), opener.open(f"{server.url.partition('/?')[0]}/block.jpg?of={name}") as sent:
        return np.asarray(Image.open(sent), float)


def test_the_first_looks_of_the_list_exist_and_lead_it(tmp_path: Path) -> None:
    assert set(FIRST_STYLES) <= set(style_names())
    assert [*list_styles(tmp_path)][: len(FIRST_STYLES)] == list(FIRST_STYLES)


def test_only_shipped_styles_have_ready_thumbnails() -> None:
    ink = load_style("ink")
    ready = shipped_thumbnail(ink)
    assert ready is not None and ready.shape == (THUMBNAIL_HEIGHT_PX, THUMBNAIL_WIDTH_PX, 3)
    assert shipped_thumbnail(replace(ink, strength=0.5)) is None


def test_escape_clears_the_search_and_never_shows_a_designer_without_a_style(
    server: DesignServer, browser: Browser
) -> None:
    browser.open(server.url)
    browser.until("document.querySelector('.tile:not(.new)')")
    browser.run("document.getElementById('find-look').focus()")
    browser.type("noir")
    browser.until("document.querySelectorAll('.tile:not([hidden])').length < 9")
    shown = "[...document.querySelectorAll('#tiles > :not([hidden])')]"
    names = f"{shown}.map((each) => (each.querySelector('b') ?? each).textContent)"
    assert browser.run(f"return {names}.slice(0, 3)") == ["Noir", "Related looks", "Charcoal"]
    browser.press("Escape")
    assert browser.run("return document.getElementById('find-look').value") == ""
    assert "Related looks" not in browser.run(f"return {names}")
    near = "document.getElementById('near-look').textContent"
    browser.type("bokeh")
    browser.until(f"{near}.startsWith('No look is exactly “bokeh”')")
    browser.press("Escape")
    assert browser.run(f"return {near}") == ""
    for asked, best in (("8mm", "Noir"), ("super 8", "Noir"), ("old film", "Noir"), ("sepia", "Engraving")):
        browser.type(asked)
        browser.until(f"{near}.startsWith('No look is exactly “{asked}”. {best}')")
        assert "Related looks" not in browser.run(f"return {names}"), "none is near to what is only near"
        browser.press("Escape")
    browser.type("pencil")
    browser.until(f"{names}.join() === 'Sketch,Related looks,Crayon,Charcoal'")
    assert browser.run(f"return {near}") == ""
    browser.press("Escape")
    browser.press("Escape")
    assert not browser.run("return document.getElementById('start').hidden")


def test_the_front_page_stays_when_it_is_loaded_again(server: DesignServer, browser: Browser) -> None:
    browser.open(server.url)
    browser.until("document.querySelector('.tile:not(.new)')")
    browser.click(".tile:not(.new)")
    browser.until("document.getElementById('start').hidden && document.querySelector('.style-panel .value')")
    browser.run("document.getElementById('to-styles').click()")
    browser.run("window.isOld = true; location.reload()")
    browser.until("!window.isOld && document.querySelector('.tile:not(.new)')")
    browser.until("document.querySelector('.style-panel .value')")
    assert not browser.run(
        "return document.getElementById('start').hidden || document.getElementById('back').hidden"
    )
    browser.open("about:blank")
    browser.open(server.url)
    browser.until("document.querySelector('.style-panel .value')")
    assert not browser.run("return document.getElementById('start').hidden"), "a new visit"
    assert browser.run("return getComputedStyle(document.activeElement).outlineStyle") == "none"


def test_after_a_click_on_a_look_no_control_has_the_focus(server: DesignServer, browser: Browser) -> None:
    """The page has the same keys: the space bar plays the film."""
    browser.open(server.url)
    browser.until("document.querySelector('.tile:not(.new)')")
    browser.click(".tile:not(.new)")
    browser.until("document.getElementById('start').hidden && document.querySelector('.style-panel .value')")
    assert browser.run(FOCUSED).startswith("<body")


def test_an_error_is_below_the_button_that_opens_files_and_no_button_moves_while_a_film_is_rendered(
    server: DesignServer, browser: Browser, tmp_path: Path
) -> None:
    size = {"width": 1280, "height": 800}
    browser.call("Emulation.setDeviceMetricsOverride", **size, deviceScaleFactor=1, mobile=False)
    browser.open(server.url)
    browser.until("document.querySelector('.tile:not(.new)')")
    (tmp_path / "broken.jpg").write_bytes(b"no picture")
    browser.choose_file("#file", tmp_path / "broken.jpg")
    error = "document.getElementById('open-error')"
    browser.until(f"{error}.checkVisibility() && {error}.textContent.includes('broken.jpg')")
    browser.click(".tile:not(.new)")
    browser.until("document.getElementById('start').hidden && document.querySelector('.style-panel .value')")
    places = """return ["to-diagram", "save", "to-queue", "render"].map((id) =>
      Math.round(document.getElementById(id).getBoundingClientRect().left));"""
    before = browser.run(places)
    browser.press("Ctrl+Enter")
    browser.until("document.getElementById('queue-count').textContent === '1'")
    assert browser.run(places) == before
    browser.until("document.getElementById('jobs').textContent.includes('Saved in')")
    assert browser.run(places) == before


def test_by_keyboard_a_film_is_opened_restyled_adjusted_and_rendered(
    server: DesignServer, browser: Browser, tmp_path: Path
) -> None:
    browser.open(server.url)
    browser.until("document.getElementById('start-title').textContent.startsWith('Restyle')")
    browser.until("document.activeElement.matches('.tile')")
    tiles = "return [...document.querySelectorAll('.tile')]"
    stops = browser.run(f"{tiles}.filter((each) => each.tabIndex === 0).length")
    assert stops == 1, "all looks are one stop of the Tab key"
    browser.press("ArrowRight")
    assert browser.run(f"{tiles}.indexOf(document.activeElement)") == 1
    browser.press("/")
    browser.until("document.activeElement.id === 'find-look'")
    first = "document.querySelector('.tile:not([hidden]) b')?.textContent"
    for asked, name in (("comic book", "Comic"), ("van gogh", "Impressionist"), ("sketch", "Sketch")):
        browser.run("document.getElementById('find-look').value = ''")
        browser.type(asked)
        browser.until(f"{first} === {name!r}")
    browser.press("ArrowDown")
    browser.until("document.activeElement.matches('.tile:not([hidden])')")
    browser.press("/")
    browser.press("Enter")
    browser.until("document.getElementById('start').hidden && document.querySelector('.style-panel .value')")
    browser.until("document.activeElement.matches('#style-tab-content *')")
    browser.run("history.back()")
    browser.until("!document.getElementById('start').hidden")
    browser.run("history.forward()")
    browser.until("document.getElementById('start').hidden")
    browser.run("window.isOld = true; location.reload()")
    browser.until("!window.isOld && document.querySelector('.style-panel .value')")
    assert browser.run("return document.getElementById('start').hidden")
    browser.run("history.back()")
    browser.until("!document.getElementById('start').hidden")
    browser.run("document.getElementById('back').click()")
    browser.run("document.querySelector('.style-panel input[type=range]').focus()")
    browser.press("ArrowRight")
    browser.until("document.getElementById('saved').textContent === 'Edited'")
    browser.press("Ctrl+Enter")
    browser.until("document.getElementById('jobs').textContent.includes('Saved in')")
    assert browser.run("return document.querySelector('#jobs .strong').textContent") == "Play"
    assert (tmp_path / "film-sketch.mp4").exists()
    browser.run("history.back()")
    browser.until("!document.getElementById('start').hidden")
    browser.press("/")
    browser.run("document.getElementById('find-look').value = ''")
    browser.type("comic book")
    browser.press("Enter")
    browser.until("document.getElementById('name').value === 'Comic'")
    assert browser.run("return document.querySelector('.to-drafts').textContent") == "Unsaved changes (1)"


def test_a_command_that_makes_a_document_is_cancelled() -> None:
    with ChildPages() as children, ThreadPoolExecutor(1) as pool:
        run = pool.submit(children.run, ["live", "test", "--to", "null"], [].append)
        while not run.done():
            children.cancel()
            wait([run], 0.05)
        with pytest.raises(UsageError, match="vidstyle live: cancelled"):
            run.result()


def test_nobody_is_cut_off_in_tiles_and_the_own_picture_stays_whole(browser: Browser, tmp_path: Path) -> None:
    """Tiles were enlarged around faces; then the picture of the user's file showed that part, too."""
    red, blue = (220, 30, 30), (30, 30, 220)
    frame = np.full((720, 1280, 3), 90, np.uint8)
    frame[104:616, 384:896] = photograph("astronaut")
    frame[:, :60], frame[:, -60:] = red, blue
    Image.fromarray(frame).save(tmp_path / "portrait.png")
    (tmp_path / "same.toml").write_text('format = 1\nname = "same"\nstrength = 0\n')
    clip = open_clip(tmp_path / "portrait.png")
    server = open_page(
        Designer(clip, tmp_path, Drafts(tmp_path / "draft.json")), 0, "cpu", FrontDoor({}, lambda file: None)
    )
    edges = """const shown = [document.getElementById("source-picture"), document.querySelector(".tile img")];
    await Promise.all(shown.map((image) => image.decode()));
    return shown.map((image) => {
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [64, 36];
      const context = canvas.getContext("2d");
      context.drawImage(image, 0, 0, 64, 36);
      return [1, 62].map((x) => [...context.getImageData(x, 18, 1, 1).data.slice(0, 3)]);
    });"""
    try:
        browser.open(server.url)
        browser.until("document.querySelector('.tile img:not(.waiting)')?.complete")
        browser.until("document.getElementById('previews').textContent === 'on portrait.png'")
        assert browser.run("return document.querySelector('.tile b').textContent") == "Same"
        for left, right in browser.run(edges):
            assert np.abs(np.subtract([left, right], [red, blue])).max() < 40
        browser.open("about:blank")
    finally:
        server.close()
