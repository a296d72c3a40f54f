"""The explorer's page: what its server answers, and the page in a browser."""

from __future__ import annotations

import base64
import re
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from browser import Browser
from live_page import Visitor, Window
from media import make_clip, photograph
from waiting import eventually

from vidstyle.cli.explore import designer_until
from vidstyle.errors import UsageError
from vidstyle.explore.choosing import candidate_generator
from vidstyle.explore.look import MAX_LOOK_SIDE_PX
from vidstyle.explore.matching import like
from vidstyle.explore.page import exploration as exploration_file
from vidstyle.explore.page.exploration import MATCH_SIDE_PX, Exploration
from vidstyle.explore.page.explore_server import ExploreServer
from vidstyle.explore.page.saving import save_style_of_user
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.gpu.compile.es import es_plan
from vidstyle.preview.clip import open_clip
from vidstyle.style import load_style, user_styles

SIZE = (192, 108)


@pytest.fixture(scope="module")
def page(folder: Path) -> Iterator[ExploreServer]:
    """A page with a film of half a second, whose first screen is there.

    It renders less ahead, which would keep all cores busy, and fewer samples on the tuning pad.
    """
    film = make_clip(folder / "film.mp4", size=SIZE, frames=15)
    clip = open_clip(film)
    fewer = {"values": 6, "step": 3, "cross": 1, "wild": 1, "shipped": 4}
    with pytest.MonkeyPatch.context() as patch, Exploration(clip, 3) as exploration:
        patch.setattr(candidate_generator, "CANDIDATE_COUNTS", fewer)
        patch.setattr(exploration_file, "PAD_GRID_SIZE", 3)
        likeliest = exploration.chooser.by_liking
        patch.setattr(exploration.chooser, "by_liking", lambda: likeliest()[:1])
        page = ExploreServer(exploration)
        eventually(lambda: page.state()["tiles"] or page.error)
        yield page
        page.close()
        assert page.error is None
    clip.close()


def answer(window: Window, do: str, **fields: Any) -> dict[str, Any]:
    """The answer to a message."""
    return window.answer(do=do, **fields)


def picture(visitor: Visitor, address: str) -> np.ndarray:
    status, headers, data = visitor.ask(address)
    assert (status, headers["content-type"]) == (200, "image/jpeg")
    found = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert found is not None
    return found


def test_the_page_is_told_of_the_clip_and_of_nine_tiles(window: Window) -> None:
    clip, state = window.news("clip"), window.news("state")
    assert (clip["name"], clip["size"], clip["count"]) == ("film.mp4", list(SIZE), 15)
    assert len({tile["tile"] for tile in state["tiles"]}) == 9
    assert len({tile["caption"] for tile in state["tiles"]}) == 9, "no caption twice"
    assert state["locks"] == []


def test_a_tile_is_drawn_by_the_server_as_the_style_draws_it(page: ExploreServer, visitor: Visitor) -> None:
    tile = page.state()["tiles"][0]["tile"]
    frame = page.exploration.frames[0]
    drawn = picture(visitor, f"/tile.jpg?tile={tile}&frame={frame}&side=180")
    assert drawn.shape == (SIZE[1], SIZE[0], 3)
    look = page.exploration.tile(tile).look.picture
    assert look.shape[1] <= MAX_LOOK_SIDE_PX
    shown = np.ascontiguousarray(page.exploration.clip.frame(frame, 320))
    expected = restyle_picture(shown, page.exploration.tile(tile).style, seen_side=min(SIZE))[..., ::-1]
    assert np.abs(drawn.astype(float) - expected).mean() < 12, "with the marks of a film of this size"
    source = picture(visitor, f"/frame.jpg?frame={frame}&side=180")
    assert np.abs(source.astype(float) - drawn).mean() > 8
    assert picture(visitor, f"/look.jpg?tile={tile}").shape[:2] == look.shape[:2]
    assert 0 < len(page.exploration.tries) <= 9, "candidates are seen before the first screen is chosen"
    assert picture(visitor, "/tried.jpg?number=0").shape[:2] == look.shape[:2]


def test_a_plan_is_sent_once_and_then_its_values(page: ExploreServer, visitor: Visitor) -> None:
    tile = page.state()["tiles"][0]["tile"]
    with visitor.look() as one, visitor.look() as other:
        first = answer(one, "plan", tile=tile, side=180, whole=False)
        again = answer(one, "plan", tile=tile, side=180, whole=False)
        assert first["plan"]["size"] == list(SIZE) and "plan" not in again
        assert first["key"] == again["key"] and first["values"] == again["values"]
        assert "plan" in answer(other, "plan", tile=tile, side=180, whole=False)
        assert answer(one, "plan", tile=tile, side=180, whole=True)["plan"] == first["plan"]


def test_a_click_is_answered_and_all_browsers_see_it(page: ExploreServer, visitor: Visitor) -> None:
    with visitor.look() as one, visitor.look() as other:
        before = one.news("state")
        other.news("state")
        taken = before["tiles"][2]["tile"]
        assert "error" not in answer(one, "like", tile=taken)
        state = other.news("state")
        assert state["tiles"][4]["kind"] == "chosen" and state["back"] and len(state["history"]) > 1
        assert "error" not in answer(one, "back")
        assert other.news("state")["tiles"] == before["tiles"]
        assert "error" not in answer(one, "jump", screen=0)
        assert "no screen 999" in answer(one, "jump", screen=999)["error"]
        assert "error" not in answer(one, "star", tile=taken, on=True)
        assert page.state()["stars"][0]["tile"] == taken
        assert "error" not in answer(one, "lock", name="colors", on=True)
        assert page.state()["locks"] == ["colors"]
        assert "error" not in answer(one, "lock", name="colors", on=False)
        assert "error" not in answer(one, "near", part=0.5)
        assert page.state()["near"] == 0.5


def quick_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search fewer styles for the look of a picture, and tune none."""
    names = ["poster", "noir", "ink", "paint", "neon", "riso", "sketch", "watercolor", "cartoon", "oil"]
    monkeypatch.setattr(like, "known_styles", lambda: [load_style(name) for name in names])
    for name, value in {"SEARCH_ROUNDS": 1, "PARENT_COUNT": 1, "CHILD_COUNT": 1, "TUNED_COUNT": 0}.items():
        monkeypatch.setattr(like, name, value)


def reference_in(style: str) -> bytes:
    """A picture of something else in a style, as PNG."""
    drawn = restyle_picture(photograph("coffee")[:300, :400], load_style(style))
    return bytes(cv2.imencode(".png", drawn[..., ::-1])[1])


def send_file(window: Window, name: str, content: bytes) -> dict[str, Any]:
    """Upload a file in parts; return the answer after the last one."""
    first = answer(window, "upload", name=name, size=len(content))
    assert "error" not in first
    for start in range(0, len(content), 50_000):
        window.socket.send(content[start : start + 50_000])
    return window.answer_to(first["answer"])


def test_a_reference_picture_gives_the_styles_most_like_it(
    page: ExploreServer, window: Window, visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick_search(monkeypatch)
    before = window.news("state")
    assert before["reference"] == 0 and visitor.ask("/reference.jpg?number=0")[0] == 404
    assert "error" not in send_file(window, "poster.png", reference_in("poster"))
    state = page.state()
    assert [tile["kind"] for tile in state["tiles"]] == ["match"] * 9
    assert state["tiles"][0]["name"].startswith("poster")
    found = [float(tile["likeness"].partition(",")[0]) for tile in state["tiles"]]
    assert found[0] < min(found[1:])
    assert picture(visitor, "/reference.jpg?number=0").shape == (270, MATCH_SIDE_PX, 3)
    assert "error" not in answer(window, "jump", screen=0)


def test_a_file_that_is_no_picture_is_refused_by_its_name(page: ExploreServer, window: Window) -> None:
    before = page.state()
    error = send_file(window, "notes.png", b"not a picture" * 20)["error"]
    assert error.startswith("notes.png: ")
    assert page.state() == before and page.error is None


def test_a_tuned_style_is_that_of_the_point_and_is_saved_as_it_is_shown(
    page: ExploreServer, window: Window, visitor: Visitor
) -> None:
    tile = page.state()["tiles"][2]["tile"]
    told = answer(window, "pad", tile=tile)
    assert len(told["axes"]) == 2 and all(0 <= part <= 1 for part in told["start"])
    assert answer(window, "tune", tile=tile, x=0.9, y=0.1, side=180, whole=False)["values"]
    assert picture(visitor, f"/pad.jpg?tile={tile}").shape[0] > 0
    kept = answer(window, "keep", tile=tile, x=0.9, y=0.1)["tile"]
    saved = answer(window, "save", tile=kept, name="my look", overwrite=False)["file"]
    style = load_style("my look")
    assert Path(saved) == user_styles() / "my look.toml"
    shown = page.exploration.pad(tile).style_at(0.9, 0.1)
    assert (style.layers, style.ink, style.paper) == (shown.layers, shown.ink, shown.paper)
    assert "exists" in answer(window, "save", tile=tile, name="my look", overwrite=False)["error"]
    assert "error" not in answer(window, "save", tile=tile, name="my look", overwrite=True)


def test_a_film_is_rendered_with_progress_and_exported(
    page: ExploreServer, window: Window, visitor: Visitor, folder: Path
) -> None:
    tile = page.state()["tiles"][0]["tile"]
    rendered = answer(window, "render", tile=tile, name="out")
    file = Path(rendered["file"])
    assert file == folder / "out.mp4" and file.stat().st_size > 1000
    assert visitor.ask(f"/rendered?of={rendered['number']}")[2] == file.read_bytes()
    assert visitor.ask(f"/rendered?of={rendered['number'] + 1}")[0] == 404
    assert {"frames", "fraction"} <= window.news("progress").keys()
    assert "exists" in answer(window, "render", tile=tile, name="out")["error"]
    shown: list[Path] = []
    page.reveal = shown.append
    assert "error" not in answer(window, "reveal", file=str(file))
    assert "cannot be shown" in answer(window, "reveal", file=str(Path(__file__)))["error"]
    page.reveal = None
    assert "cannot be shown" in answer(window, "reveal", file=str(file))["error"]
    assert shown == [file], "only files of the page"
    exported = answer(window, "export", tile=tile, name="out", kind="toml")["file"]
    assert load_style(Path(exported)).layers == page.exploration.tile(tile).style.layers
    assert "cannot be opened" in answer(window, "design", tile=tile)["error"]


@pytest.mark.parametrize(
    "name", ["../x", "/etc/x", "a/b", ".hidden", "..", "x\n", "x\0", "con", " ", "a" * 150, "~/x", "x:y"]
)
def test_a_name_is_a_name_and_no_path(window: Window, folder: Path, name: str) -> None:
    before = sorted(folder.rglob("*"))
    for kind, more in {"save": {"overwrite": True}, "export": {"kind": "html"}, "render": {}}.items():
        assert "is not a file name" in answer(window, kind, tile=0, name=name, **more)["error"]
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("name", ["ink", "plain"])
def test_a_shipped_style_keeps_its_name(name: str, folder: Path) -> None:
    with pytest.raises(UsageError, match="name of a shipped style"):
        save_style_of_user(load_style("sketch"), name, overwrite=True)


@pytest.mark.parametrize(
    "path",
    ["/tile.jpg", "/tile.jpg?tile=0&frame=0&side=181", "/tile.jpg?tile=0&frame=99&side=180",
     "/tile.jpg?tile=99999&frame=0&side=180", "/tile.jpg?tile=-1&frame=0&side=180",
     "/frame.jpg?frame=0&side=99999",
     "/frame.jpg?frame=1e3&side=180", "/look.jpg?tile=٣", "/look.jpg?tile=../../x", "/pad.jpg?tile=99999",
     "/tried.jpg?number=99999",
     "/tuned.jpg?tile=0&x=2&y=0&frame=0&side=180", "/tuned.jpg?tile=0&x=nan&y=0&frame=0&side=180",
     "/exploration.py", "/explore.html"],
)  # fmt: skip
def test_no_other_picture_is_to_be_had(visitor: Visitor, path: str) -> None:
    assert visitor.ask(path.encode("ascii", "backslashreplace").decode())[0] == 404


# In a browser. There is no graphics card here, so the server draws, at 180 lines.

READY = "return document.querySelectorAll('.tile:not(.waiting)').length === 9"


@pytest.fixture(scope="module")
def opened(page: ExploreServer, request: pytest.FixtureRequest) -> Browser:
    """The page in Chromium, with nine tiles."""
    found: Browser = request.getfixturevalue("browser")
    found.call(
        "Emulation.setDeviceMetricsOverride", width=1024, height=640, deviceScaleFactor=1, mobile=False
    )
    found.open(page.url)
    eventually(lambda: found.run(READY))
    return found


def press(page: Browser, key: str, code: str = "", text: str = "") -> None:
    """Press a key and let it go."""
    for kind in ("keyDown", "keyUp"):
        more = {"text": text or key} if kind == "keyDown" and len(text or key) == 1 else {}
        page.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, **more)


def focused(page: Browser) -> str:
    return str(
        page.run("return document.activeElement.getAttribute('aria-label') ?? document.activeElement.id")
    )


def test_a_page_that_is_opened_before_the_first_screen_waits_for_it(
    browser: Browser, page: ExploreServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    chooser = page.exploration.chooser
    with monkeypatch.context() as patch:
        patch.setattr(chooser, "screens", [])
        patch.setattr(page, "tried", {"step": "trying styles", "done": 0, "total": 0, "shown": 0})
        browser.open(page.url)
        browser.until("document.getElementById('clip').textContent === 'film.mp4'")
        browser.run("await new Promise((done) => setTimeout(done, 50))")
    note, bar = (
        "document.getElementById('search-note').textContent",
        "document.getElementById('screen-progress')",
    )
    parts = []
    for done, count in ((0, 0), (26, 26), (30, 30), (29, 30), (0, 30), (8, 38)):
        page.exploration.on_progress("trying styles", done, 30)
        browser.until(f"{note} === 'Trying styles: {count}'")
        parts.append(browser.run(f"return {bar}.value / {bar}.max"))
    assert parts == sorted(parts) and parts[1] > 0.4 and parts[-1] < 1, "it never runs back"
    page.submit(page.send_state)
    browser.until(
        "document.querySelectorAll('.take').length === 9 && document.getElementById('seen').children.length"
    )
    assert not [event for event in browser.events if event["method"] == "Runtime.exceptionThrown"]


def test_a_narrow_page_opens_at_its_top(browser: Browser, page: ExploreServer) -> None:
    size = {"deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, **size)
    browser.open(page.url)
    browser.until("document.getElementById('seen').children.length")
    assert browser.run("return [scrollY, document.documentElement.scrollHeight > innerHeight]") == [0, True]
    below = """const bar = document.getElementById("screen-progress");
        const words = document.getElementById("hint-more");
        document.getElementById("search").hidden = false;
        document.body.style.width = "360px";
        words.textContent = "Choose one for nine more like it. Open one to save it or to render it.";
        const gap = bar.getBoundingClientRect().top - words.getBoundingClientRect().bottom;
        document.body.style.width = "";
        return gap;"""
    assert browser.run(below) >= 0, "the bar is not drawn through the words"
    # Two columns have no middle: the chosen tile comes first.
    first = """document.querySelectorAll(".caption")[1].querySelector(".name").click();
        document.getElementById("stage").style.paddingBottom = "1px"; // it changes its size, as on a phone
        for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame);
        return document.getElementById("tiles").firstElementChild.matches(".middle");"""
    assert browser.run(first)
    browser.until("document.getElementById('tiles').firstElementChild.matches('.chosen')")
    page.exploration.back()
    page.submit(page.send_state)
    browser.until("!document.querySelector('.chosen')")


def test_nine_tiles_move_and_say_what_they_are(opened: Browser, page: ExploreServer) -> None:
    labels = opened.run("return [...document.querySelectorAll('.take')].map((each) => each.ariaLabel)")
    assert [label[:2] for label in labels] == [f"{number}:" for number in range(1, 10)]
    assert len({label for label in labels}) == 9
    opened.until("document.getElementById('search').hidden")
    assert opened.run("return document.querySelectorAll('.tile.draft').length") == 0, (
        "nothing is drawn any more"
    )
    assert opened.run("return document.getElementById('search-note').textContent") == "Drawing 9 of 9"
    said = "document.getElementById('message').textContent"
    opened.until(f"/^Screen [0-9]+: (?!Drawing)/.test({said})")
    sample = """const canvas = document.querySelector('.take canvas');
        const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        return data.reduce((sum, each, at) => (sum * 31 + each * at) % 1000003, 7);"""
    seen = {opened.run(sample)}

    def moves() -> bool:
        seen.add(opened.run(sample))
        return len(seen) > 2  # the first may be the thumbnail

    press(opened, "p")
    eventually(moves)
    press(opened, "p")
    errors = [event for event in opened.events if event["method"] == "Runtime.exceptionThrown"]
    assert not errors


def test_pictures_fill_their_tiles_and_buttons_their_rows(opened: Browser) -> None:
    size = {"deviceScaleFactor": 1, "mobile": False}
    opened.call("Emulation.setDeviceMetricsOverride", width=1280, height=620, **size)
    space = """const canvas = document.querySelector(".take canvas");
        return document.querySelector(".take").clientWidth - canvas.offsetWidth;"""
    opened.until(f"(() => {{ {space} }})() === 0")
    assert opened.run("return document.querySelector('.take').clientHeight") < 170, "pictures are low"
    opened.until("document.querySelector('#hint-more svg')")  # the sign that opens a look
    opened.run("document.querySelector('[aria-label=\"Open tile 1\"]').click()")
    ends = """const ends = ["#like", "#actions > :last-child", "#render", "#save", "#exports"]
            .map((each) => document.querySelector(each));
        return new Set(ends.map((each) => Math.round(each.getBoundingClientRect().right))).size;"""
    assert opened.run(ends) == 1
    name = """const { fileName } = await import("/lightbox.js");
        return ["Muted colours, outlines, ink lines", "Dark turquoise on pale yellow"].map(fileName);"""
    assert opened.run(name) == ["muted-colours-outlines", "dark-turquoise-on-pale"]


def test_a_render_goes_on_in_sight_when_the_look_is_closed(opened: Browser) -> None:
    opened.run("document.querySelector('[aria-label=\"Open tile 1\"]').click()")
    where = """document.getElementById('render').click(); document.getElementById('lightbox').close();
        await new Promise(requestAnimationFrame);
        const { parentElement, hidden, textContent } = document.getElementById('progress');
        return [parentElement.id, hidden, textContent];"""
    parent, hidden, text = opened.run(where)
    assert (parent, hidden) == ("rail", False) and re.fullmatch(r"Rendering: \d+ %Cancel", text)
    opened.until("document.getElementById('progress').hidden")
    opened.until("document.getElementById('message').textContent.startsWith('Rendered as')")


def test_by_keyboard_alone_a_look_is_found_kept_compared_and_saved(
    opened: Browser, page: ExploreServer
) -> None:
    chooser = page.exploration.chooser
    at = len(chooser.screens)
    press(opened, "3", "Digit3")
    name = page.state()["tiles"][2]["caption"]
    chosen = f"return document.querySelectorAll('.take')[4].ariaLabel === '5: {name}. Your choice'"
    eventually(
        lambda: len(chooser.screens) == at + 1 and opened.run(chosen) and opened.run(READY), "a digit takes"
    )
    opened.run("document.activeElement.blur()")
    press(opened, "z")
    shown = "return document.querySelector('#lightbox[open] #lightbox-name')?.textContent"
    eventually(lambda: opened.run(shown) == name, "without a focus, the one in the middle, of the same name")
    press(opened, "c")
    sides = "return [...document.querySelectorAll('#divider > .tag')].map((each) => each.textContent)"
    opened.until("document.getElementById('divider').checkVisibility()")
    assert opened.run(sides) == ["Original", name], "as on the other pages"
    for pressed in ("true", "false"):
        opened.run("document.getElementById('hold').click()")
        assert opened.run("return document.getElementById('hold').ariaPressed") == pressed
        opened.until(f"document.getElementById('divider').hidden === {pressed}")
    press(opened, "c")
    opened.run("document.getElementById('lightbox').close()")
    opened.run("document.activeElement.blur()")
    press(opened, "ArrowRight")
    assert focused(opened).startswith(f"5: {name}")
    press(opened, "ArrowRight")
    assert focused(opened).startswith("6:")
    kept = page.state()["tiles"][5]["tile"]
    press(opened, "s")
    eventually(lambda: kept in [tile["tile"] for tile in page.state()["stars"]], "S keeps")
    opened.until("""document.querySelector('[aria-label="Keep tile 6"]').ariaPressed === 'true'""")
    opened.until("""document.querySelector('[aria-label="Keep tile 6"]').dataset.said === 'Kept'""")
    press(opened, "c")
    press(opened, "ArrowUp")
    press(opened, "c")
    opened.until("document.getElementById('lightbox').open")
    assert "compared with" in opened.run("return document.getElementById('how').textContent")
    opened.run("document.getElementById('name').focus()")
    opened.call("Input.insertText", text="by-keyboard")
    press(opened, "Enter", text="\r")
    eventually((user_styles() / "by-keyboard.toml").exists, "Enter saves")
    shown = page.exploration.tile(page.state()["tiles"][2]["tile"]).style
    assert load_style("by-keyboard").layers == shown.layers
    outcome = "document.getElementById('outcome').textContent"
    opened.until(f"{outcome}.startsWith('Saved as by-keyboard.toml')")
    save = "document.getElementById('save').click()"
    assert opened.run(f"{save}; await Promise.resolve(); return {outcome}") == "Saving by-keyboard…"
    opened.until("document.getElementById('save').textContent === 'Replace'")
    question = f"Replace by-keyboard? A look of this name is in {user_styles()}."
    assert opened.run(f"return {outcome}").startswith(question)
    assert opened.run("return document.getElementById('outcome').className") == "quiet "
    opened.run(save)
    opened.until(f"{outcome}.startsWith('Saved as by-keyboard.toml')")
    opened.run("document.getElementById('lightbox').close()")
    opened.run("history.back()")
    eventually(lambda: chooser.at < at, "Back of the browser")
    opened.until("document.getElementById('tiles').ariaBusy === 'false'")
    opened.run("history.forward()")
    eventually(lambda: chooser.at == at, "Forward of the browser")
    opened.until("document.getElementById('tiles').ariaBusy === 'false'")
    press(opened, ",")
    eventually(lambda: chooser.at < at, "a comma goes back")
    opened.until("document.getElementById('tiles').ariaBusy === 'false'")
    at, count = chooser.at, len(chooser.screens)
    for cancel in ("document.getElementById('back').click()", "document.getElementById('stop').click()"):
        opened.run(f"document.querySelector('.take').click(); {cancel}")
        opened.until("document.getElementById('message').textContent === 'Cancelled.'")
        opened.until("document.getElementById('tiles').ariaBusy === 'false'")
        opened.run("document.getElementById('message').textContent = ''")
        assert (chooser.at, len(chooser.screens)) == (at, count), "the search ends, and its screen stays"
        eventually(lambda: opened.run(READY), "all tiles are shown again")
    opened.run("document.querySelector('.take').click()")
    press(opened, "n")
    eventually(lambda: len(chooser.screens) == count + 1, "a key during a search replaces it")
    assert chooser.screen.tiles[4].kind != "chosen"
    opened.until("document.getElementById('tiles').ariaBusy === 'false'")
    press(opened, "?")
    assert opened.run("return document.getElementById('help').open")
    opened.run("document.getElementById('help').close()")


def test_a_picture_that_is_dropped_on_the_page_is_matched(
    opened: Browser, page: ExploreServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick_search(monkeypatch)
    count = len(page.exploration.references)
    opened.run(
        """const bytes = Uint8Array.from(atob(content), (each) => each.charCodeAt(0));
        const dataTransfer = new DataTransfer();
        dataTransfer.items.add(new File([bytes], "wanted.png", { type: "image/png" }));
        const drop = new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true });
        document.body.dispatchEvent(drop);""",
        content=base64.b64encode(reference_in("noir")).decode(),
    )
    eventually(lambda: page.state()["tiles"][0]["kind"] == "match")
    assert page.state()["tiles"][0]["name"].startswith("noir")
    opened.until("document.querySelector('[aria-label^=\"1: Noir\"]')")
    shown = "const shown = document.getElementById('reference-picture'); return shown.naturalWidth"
    eventually(lambda: opened.run(shown) == MATCH_SIDE_PX)
    assert len(page.exploration.references) == count + 1
    press(opened, "1", "Digit1")
    opened.until("document.querySelectorAll('.take')[4].ariaLabel.endsWith('. Your choice')")


def test_the_pages_own_renderer_draws_a_tile_as_the_cpu_does(opened: Browser, page: ExploreServer) -> None:
    """One tile alone: in software each takes seconds."""
    tile = min(page.state()["tiles"], key=lambda each: len(page.exploration.tile(each["tile"]).style.steps))
    got = opened.run(
        """const { Runner } = await import("/runner.js");
        const { LoadedPlans, PagePainter } = await import("/painters.js");
        const { SourceFrames } = await import("/source_frames.js");
        const source = new SourceFrames(() => {});
        await source.open({ frames: [frame], rate: 1 }, 180);
        const painter = new PagePainter(new LoadedPlans(new Runner()), source, () => {});
        const name = String(tile);
        await painter.prepare({ name, plan: async () => plan, address: () => "" }, 180);
        const canvas = document.createElement("canvas");
        if (!painter.draw({ name }, 0, canvas)) return null;
        return [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data];""",
        tile=tile["tile"], frame=page.exploration.frames[0],
        plan=page.exploration.plan(page.exploration.tile(tile["tile"]).style, 180).result(),
    )  # fmt: skip
    drawn = np.array(got, np.uint8).reshape(SIZE[1], SIZE[0], 4)[..., :3]
    shown = np.ascontiguousarray(page.exploration.clip.frame(page.exploration.frames[0], 180))
    expected = restyle_picture(shown, page.exploration.tile(tile["tile"]).style)
    one, other = (cv2.resize(each, (48, 27), interpolation=cv2.INTER_AREA) for each in (drawn, expected))
    assert np.abs(one.astype(float) - other).mean() < 5


def test_plans_that_nothing_shows_are_freed_and_asked_for_again(opened: Browser) -> None:
    plan = es_plan(load_style({"format": 1, "base": [{"block": "to_gray"}]}), 4, 3)
    programs, whole, left = opened.run(
        """const { Runner } = await import("/runner.js");
        const { LoadedPlans } = await import("/painters.js");
        const plans = new LoadedPlans(new Runner());
        const programs = plans.runner.context.programs;
        let asked = 0;
        const subject = (key, sent) => ({
          plan: async (side, whole) => {
            asked += whole;
            const own = { ...plan, shaders: plan.shaders.map((text) => `${text}// ${key}`) };
            return { key, values: plan.values, plan: sent && !whole ? undefined : own };
          },
        });
        for (let key = 0; key < 42; key++) await plans.get(subject(key, false), 180);
        const loaded = programs.size;
        await plans.get(subject(41, true), 180);
        const { style } = await plans.get(subject(0, true), 180);
        plans.runner.unload(style);
        return [loaded, asked, programs.size];""",
        plan=plan,
    )
    shaders = len(plan["shaders"])
    assert (programs, whole, left) == (40 * shaders, 1, 39 * shaders)


@pytest.mark.thorough
def test_a_tile_is_opened_in_the_designer(
    opened: Browser, page: ExploreServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop = threading.Event()
    monkeypatch.setattr(page, "designer", designer_until(stop))
    opened.open(page.url)
    eventually(lambda: opened.run(READY))
    opened.run("globalThis.open = (address) => { globalThis.opened = address; };")
    style = page.exploration.tile(page.state()["tiles"][0]["tile"]).style
    opened.run("document.querySelector('[aria-label=\"Open tile 1\"]').click()")
    opened.until("document.getElementById('lightbox').open && !document.getElementById('design').hidden")
    opened.run("document.getElementById('design').click()")
    opened.until("globalThis.opened")
    opened.open(opened.run("return globalThis.opened"))
    opened.run("document.querySelector('.whole').click()")
    opened.until(f"document.querySelectorAll('.card').length === {len(style.steps) + 2}")
    opened.until("document.getElementById('name').value.length > 0")
    opened.until("document.getElementById('previews').textContent.includes('film.mp4')")
    opened.until("document.getElementById('picture').dataset.revision")
    stop.set()
