"""The designer's server over a real socket: what a page asks and gets."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from designing import Page, served, shown
from media import make_clip, make_picture
from pictures import picture_with_face
from waiting import LONG, eventually

from vidstyle import load_style, stylize
from vidstyle.cli import main
from vidstyle.design import working_size
from vidstyle.design.page import frames
from vidstyle.design.page.design_server import DesignServer
from vidstyle.design.restyling import Restyler
from vidstyle.design.style_list import list_styles
from vidstyle.preview.clip import open_clip
from vidstyle.style import style_names, style_text


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_clip(tmp_path_factory.mktemp("film") / "film.mp4", size=(96, 64), frames=12)


@pytest.fixture
def server(tmp_path: Path, film: Path) -> Iterator[DesignServer]:
    with served(tmp_path, open_clip(film)) as server:
        yield server


@pytest.fixture
def page(server: DesignServer) -> Iterator[Page]:
    with shown(server) as page:
        yield page


def test_a_page_is_told_of_blocks_styles_clip_and_that_nothing_is_open(page: Page) -> None:
    assert {block["name"] for block in page.told["blocks"]} > {"flow_xdog", "pattern"}
    assert sorted(style["name"] for style in page.told["styles"]) == style_names()
    assert page.told["clip"]["size"] == [96, 64] and page.told["clip"]["count"] == 12
    assert page.told["state"] is None and page.told["drafts"] == []
    assert "has no style open" in page.error("undo")


def test_an_edit_is_answered_after_the_state_and_the_plan_that_follow(page: Page) -> None:
    page.ask("new")
    step = page.ask("add", layer="lines", index=0, block="flow_xdog", gesture=1)["step"]
    assert page.order[:3] == ["state", "plan", "answer"]
    [node] = page.told["state"]["layers"]["lines"]
    assert node["step"] == step and node["block"] == "flow_xdog" and node["recipe"]
    first = page.told["plan"]
    assert "plan" in first and first["plan"]["size"] == [96, 64]
    assert page.error("set", step=step, name="p", value=30, gesture=2) == ""
    second = page.told["plan"]
    # While a value is dragged, numbers alone are sent: no shader is compiled.
    assert second["key"] == first["key"] and "plan" not in second
    assert second["values"] != first["values"]
    assert "outside" in page.error("set", step=step, name="sigma", value=999, gesture=3)
    assert page.order == ["answer"]


def test_what_leaves_a_step_is_shown_alone_and_small(page: Page) -> None:
    page.ask("open", style="sketch")
    steps = [node for nodes in page.told["state"]["layers"].values() for node in nodes]
    small = {page.picture(3).number for _ in steps}
    assert small == {node["step"] for node in steps}
    main = page.told["plan"]
    page.ask("watch", solo=steps[0]["step"], side=64, where="page")
    assert page.told["plan"]["for"] == "solo" and page.told["plan"]["key"] != main["key"]
    page.ask("watch", solo=None, side=64, where="page")
    assert page.told["plan"]["for"] == "main" and page.told["plan"]["key"] == main["key"]
    assert "plan" not in page.told["plan"]


def test_frames_come_by_number_and_are_exact(page: Page, server: DesignServer) -> None:
    page.ask("frame", number=7)
    sent = page.picture(1, 7)
    assert page.order == ["picture 1", "answer"]
    assert sent.number == 7 and (sent.pixels == server.designer.clip.frame(7)).all()
    page.ask("frame", number=10**6)
    assert page.picture(1, 11)
    page.ask("play", **{"at": 4, "first": 3, "last": 5, "fps": 30})
    numbers = [page.picture(1).number for _ in range(4)]
    assert numbers[0] == 4 and set(numbers) <= {3, 4, 5}
    page.ask("pause")
    assert page.picture(1).number in (3, 4, 5)


def test_the_server_restyles_for_a_page_that_cannot(server: DesignServer) -> None:
    with shown(server, where="server") as page:
        page.ask("open", style="comic")
        sent = page.picture(2)
        wanted = stylize(server.designer.clip.frame(0), load_style("comic"), "cpu").astype(int)
        assert sent.pixels.shape == (64, 96, 3) and sent.revision == page.told["state"]["revision"]
        assert np.abs(sent.pixels - wanted).mean() < 6  # JPEG
        page.ask("check", side=64)
        checked = page.picture(4)
        assert np.abs(checked.pixels.astype(int) - wanted).max() <= 1


def test_a_dragged_value_does_not_wait_for_the_larger_picture(
    server: DesignServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(working_size, "WORKING_SIDES_PX", (32,))
    monkeypatch.setattr(frames, "IDLE_SECONDS", 10 * LONG)
    with shown(server, where="server") as page:
        page.ask("open", style="sketch")
        page.ask("field", name="height", value=32, gesture=0)
        for number in range(3):
            page.ask("field", name="ink", value=f"#00000{number}", gesture=1)
            wanted = page.told["state"]["revision"]
            while (sent := page.picture(2)).revision < wanted:
                pass
            assert sent.pixels.shape == (32, 48, 3)


def test_a_still_preview_is_rendered_at_its_final_size(
    server: DesignServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Marks have lengths in pixels: those of a smaller picture would be coarser than what is rendered."""
    monkeypatch.setattr(working_size, "WORKING_SIDES_PX", (32,))
    monkeypatch.setattr(working_size, "MAX_SECONDS", 0.0)
    with shown(server, where="server") as page:
        page.ask("open", style="sketch")
        page.ask("field", name="height", value=32, gesture=0)
        style = replace(load_style("sketch"), height=32)
        wanted = stylize(server.designer.clip.frame(0), style, "cpu")
        revision = page.told["state"]["revision"]
        while (sent := page.picture(2)).revision < revision or sent.pixels.shape != (64, 96, 3):
            pass
        assert np.array_equal(sent.pixels, wanted), "without loss"
        page.ask("save_as", name="mine", overwrite=False)
        sent = page.picture(2)
        assert np.array_equal(sent.pixels, wanted), "saving brings no draft back"
        assert sent.revision == page.told["state"]["revision"]
        page.ask("field", name="ink", value="#000001", gesture=1)
        assert page.picture(2).pixels.shape == (32, 48, 3), "an edit does"


@pytest.mark.parametrize("height, draft", [(0, 64), (64, 64), (40, 40), (1000, 64)])
def test_drafts_have_the_marks_of_the_final_picture(
    height: float, draft: int, film: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In pictures smaller than the style's height, marks would be coarser; without one, in all."""
    monkeypatch.setattr(working_size, "WORKING_SIDES_PX", (32,))
    style = replace(load_style("comic"), height=height or None)
    picture, _ = Restyler("cpu").render_preview(style, open_clip(film), 0, 64)
    assert min(picture.shape[:2]) == draft
    picture, _ = Restyler("cpu").render_playing(style, open_clip(film), 0, 64)
    assert min(picture.shape[:2]) == 32, "a playing film is rendered fast"


def test_a_style_with_mistakes_keeps_its_picture_and_is_not_saved(page: Page, tmp_path: Path) -> None:
    page.ask("new")
    page.ask("add", layer="background", index=0, block="to_color", gesture=1)
    [node] = page.told["state"]["layers"]["background"]
    assert "no step before it saves 'chroma'" in node["error"]
    assert "no step before it saves" in page.error("save_as", name="wrong", overwrite=False)
    assert not list(tmp_path.glob("*.toml"))


def test_a_style_is_saved_beside_its_file_and_never_over_another_unasked(
    page: Page, server: DesignServer, tmp_path: Path
) -> None:
    text = '# Mine.\nformat = 1\nname = "mine"\n\n# Tones.\n[[background]]\nblock = "posterize" # flat\n'
    page.upload("mine.toml", text.encode())
    assert page.told["state"]["dirty"] and page.told["state"]["file"] == ""
    assert "has no file yet" in page.error("save")
    assert page.error("save_as", name="mine", overwrite=False) == ""
    assert (tmp_path / "mine.toml").read_text() == text
    assert page.told["state"]["file"] == "mine.toml" and not page.told["state"]["dirty"]
    [node] = page.told["state"]["layers"]["background"]
    page.ask("set", step=node["step"], name="levels", value=5, gesture=1)
    assert page.error("save") == ""
    saved = (tmp_path / "mine.toml").read_text()
    assert saved.startswith("# Mine.") and "# Tones." in saved and "levels = 5" in saved
    assert "exists in that folder" in page.error("save_as", name="mine.toml", overwrite=False)
    page.ask("mute", step=node["step"], on=True, gesture=2)
    (tmp_path / "mine.toml").write_text("# Another program.\n" + saved)
    assert "changed by another program" in page.error("save")
    assert page.error("save_as", name="mine", overwrite=True) == ""
    assert load_style(tmp_path / "mine.toml").background[0].mute
    assert "--style" in page.ask("command", name="", frames=None)["text"]


def test_the_same_steps_by_hand_make_the_same_file(page: Page, tmp_path: Path) -> None:
    page.ask("new")
    add = {"layer": "background", "index": 0, "block": "luma_posterize", "gesture": 1}
    levels = page.ask("add", **add)["step"]
    lines = page.ask("add", layer="lines", index=0, block="flow_xdog", gesture=2)["step"]
    page.ask("set", step=levels, name="levels", value=5, gesture=3)
    page.ask("set", step=lines, name="sigma", value=2.5, gesture=4)
    for on in (True, False):
        page.ask("mute", step=lines, on=on, gesture=5 + on)
    for _ in range(5):
        page.ask("undo")
    for _ in range(5):
        page.ask("redo")
    page.ask("save_as", name="third", overwrite=False)
    by_hand = {
        "format": 1,
        "name": "third",
        "background": [{"block": "luma_posterize", "levels": 5}],
        "lines": [{"block": "flow_xdog", "sigma": 2.5}],
    }
    assert tomllib.loads((tmp_path / "third.toml").read_text()) == by_hand
    assert (tmp_path / "third.toml").read_text() == style_text(load_style(by_hand))


def test_a_film_is_rendered_with_progress_and_a_name_is_asked_for(page: Page, tmp_path: Path) -> None:
    page.ask("open", style="sketch")
    assert page.error("render", name="out.mp4", overwrite=False, frames=5) == ""
    assert page.progress[-1]["finished"] and page.progress[-1]["file"] == str(tmp_path / "out.mp4")
    assert page.progress[-1]["done"] == 5 and (tmp_path / "out.mp4").stat().st_size > 0
    assert "exists" in page.error("render", name="out.mp4", overwrite=False, frames=5)
    assert "unknown extension" in page.error("render", name="out.xyz", overwrite=False, frames=5)
    assert page.ask("export", kind="html", name="sketch", overwrite=False)["file"] == str(
        tmp_path / "sketch.html"
    )
    assert page.ask("command", name="", frames=None)["text"].endswith("film.mp4 output.mp4 --style sketch")
    shown = page.ask("command", name="my film.mp4", frames=5)["text"]
    assert shown.endswith("film.mp4 'my film.mp4' --style sketch --frames 5")


def test_a_second_of_film_is_steadied(page: Page) -> None:
    page.ask("open", style="sketch")
    page.ask("frame", number=6)
    page.ask("steady")
    assert [sent.number for sent in page.pictures if sent.kind == 6] == [6, 7, 8, 9, 10, 11]
    assert page.progress[-1] == {"kind": "steady", "done": 6, "total": 6, "finished": True}


def test_all_styles_are_shown_on_the_users_own_picture(page: Page) -> None:
    page.ask("start", width=240, own=False)
    shown = {sent.number: sent.pixels for sent in page.pictures if sent.kind == 5}
    assert sorted(shown) == list(range(len(style_names())))
    assert len({pixels.tobytes() for pixels in shown.values()}) == len(shown)


def test_a_dropped_file_becomes_the_clip(page: Page, tmp_path: Path) -> None:
    content = make_picture(tmp_path / "photo.png", size=(50, 40)).read_bytes()
    id = page.say("upload", name="../[my]\n50% photo.png", size=len(content))
    assert page.answer(id).get("error") is None
    for start in range(0, len(content), 1000):
        page.socket.send(content[start : start + 1000])
    assert page.answer(id).get("error") is None
    clip = page.told["clip"]
    name = "../[my]\\n50% photo.png"
    assert clip == {"name": name, "size": [50, 40], "count": 1, "fps": clip["fps"], "live": False, "start": 0}
    id = page.say("upload", name="noise.mp4", size=4)
    page.answer(id)
    page.socket.send(b"1234")
    assert page.answer(id)["error"] == "noise.mp4: not a readable video"
    style = (f"# {'x' * 100}\n" * 600 + "format = 1\n").encode()
    id = page.say("upload", name="long.toml", size=len(style))
    page.answer(id)
    for part in (style[:50_000], style[50_000:]):
        page.socket.send(part)
    assert page.answer(id).get("error") is None and page.told["state"]["name"] == "long"
    assert page.told["clip"] == clip


def test_an_edit_sends_only_what_it_changes(server: DesignServer, page: Page) -> None:
    page.ask("open", style="comic")
    last = page.told["state"]["layers"]["lines"][-1]
    step, name = last["step"], "epsilon"
    assert name in [entry["name"] for entry in last["entries"]]
    before = len(page.texts)
    edits: list[dict[str, Any]] = [
        {"do": "set", "step": step, "name": name, "value": value, "gesture": 7} for value in (40.0, 50.0)
    ]
    edits += [{"do": "undo"}, {"do": "redo"}, {"do": "remove", "step": step, "gesture": 8}]
    for edit in edits:
        page.ask(**edit)
        assert page.told["state"] == json.loads(json.dumps(server.designer.state)), edit
    sizes = [len(text) for text in page.texts[before:] if text.startswith('{"changes"')]
    assert len(sizes) == len(edits) and max(sizes[:2]) < 1500, sizes


def test_what_was_not_saved_is_offered_the_next_time(tmp_path: Path, film: Path) -> None:
    with served(tmp_path, open_clip(film)) as server, shown(server) as page:
        page.ask("open", style="ink")
        page.ask("field", name="ink", value="#112233", gesture=1)
        # Before the server is closed: a crash loses little work.
        eventually((tmp_path / "drafts" / "draft.json").exists)
    with served(tmp_path, open_clip(film)) as server, shown(server) as page:
        assert page.told["drafts"][0]["name"] == "ink"
        page.ask("draft", accept=True, place=0)
        assert page.told["state"]["dirty"]
        page.ask("save_as", name="blue", overwrite=False)
    saved = (tmp_path / "blue.toml").read_text()
    assert 'ink = "#112233"' in saved and saved.count("#") > 1  # comments of the shipped file
    with served(tmp_path, open_clip(film)) as server, shown(server) as page:
        assert page.told["drafts"] == []


def test_discarded_changes_are_not_offered_again(tmp_path: Path, film: Path) -> None:
    draft = tmp_path / "drafts" / "draft.json"
    with served(tmp_path, open_clip(film)) as server, shown(server) as page:
        page.ask("open", style="ink")
        page.ask("field", name="ink", value="#112233", gesture=1)
        page.ask("open", style="sketch")
        assert draft.exists(), "changes of a style that is left are kept"
        page.ask("draft", accept=False, place=0)
        assert not draft.exists()
        page.ask("field", name="ink", value="#112233", gesture=1)
        eventually(draft.exists)
        page.ask("undo")
        eventually(lambda: not draft.exists())
    with served(tmp_path, open_clip(film)) as server, shown(server) as page:
        assert page.told["drafts"] == []


def test_a_saved_style_is_in_the_list_at_once(server: DesignServer, page: Page, tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text("[project]\n")
    page.ask("open", style="ink")
    page.ask("save_as", name="calm", overwrite=False)
    names = [style["name"] for style in page.told["styles"]]
    assert sorted(names[:-1]) == style_names() and names[-1] == "calm"
    page.ask("start", width=240, own=True)
    assert [sent.number for sent in page.pictures if sent.kind == 5] == [len(names) - 1], "no other tile"
    page.ask("open", style="sketch")
    page.ask("open", style="calm")
    assert page.told["state"]["file"] == "calm.toml"


def test_two_pages_show_the_same_style(server: DesignServer, page: Page) -> None:
    page.ask("new")
    with shown(server) as other:
        other.ask("add", layer="lines", index=0, block="sobel", gesture=1)
        page.ask("command", name="", frames=None)
        assert page.told["state"] == other.told["state"] == json.loads(json.dumps(server.designer.state))
        # Both begin to count gestures at 1.
        step = page.told["state"]["layers"]["lines"][0]["step"]
        page.ask("remove", step=step, gesture=1)
        page.ask("undo")
        assert page.told["state"]["layers"]["lines"][0]["step"] == step


def test_what_cannot_be_opened_ends_the_command_in_a_line(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "missing.mp4", "--no-open"]) == 3
    assert "missing.mp4" in capfd.readouterr().err
    assert main(["design", "test", "--style", "inks", "--no-open"]) == 3
    assert "did you mean 'ink'" in capfd.readouterr().err


def test_a_page_that_asks_for_too_much_at_once_is_told_so(page: Page) -> None:
    page.ask("open", style="comic")
    ids = [page.say("check", side=64) for _ in range(20)]
    told = [page.answer(id).get("error", "") for id in ids]
    assert any("is busy" in each for each in told) and "" in told


def test_a_page_that_renders_gets_the_faces(tmp_path: Path) -> None:
    """In finer detail, to lay over its picture; and an empty picture once there is no focus."""
    cv2.imwrite(str(tmp_path / "face.png"), picture_with_face()[..., ::-1])
    with served(tmp_path, open_clip(tmp_path / "face.png")) as server, shown(server, 480) as page:
        page.ask("open", style="comic")
        data = np.frombuffer(page.picture(7).data, np.uint8)
        faces = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        assert faces is not None and faces.shape == (480, 640, 4) and faces[..., 3].max() == 255
        page.ask("field", name="focus", value=0, gesture=1)
        sent = page.picture(7)
        assert sent.pixels.shape == (1, 1, 3) and sent.revision == page.told["state"]["revision"]


def test_the_server_renders_a_style_with_a_network(page: Page) -> None:
    """For a page that renders the others."""
    page.ask("new")
    page.ask("add", layer="background", index=0, block="network", gesture=1)
    assert page.picture(2).pixels.shape == (64, 96, 3)
    assert "notice" not in page.told


def test_only_style_files_of_the_folder_are_listed(tmp_path: Path) -> None:
    """No pipe, whose reading would never end, no folder, and no TOML of other programs."""
    (tmp_path / "own.toml").write_text('format = 1\nname = "own"\n', encoding="utf-8")
    (tmp_path / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
    (tmp_path / "folder.toml").mkdir()
    os.mkfifo(tmp_path / "pipe.toml")
    *names, own = list_styles(tmp_path)
    assert sorted(names) == style_names() and own == "own"
