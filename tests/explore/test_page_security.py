"""The explorer's page: whom it admits, and what it answers to malformed messages."""

from __future__ import annotations

import json
import random
import re
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from live_page import Visitor
from media import make_clip
from waiting import eventually
from websockets.exceptions import ConnectionClosed

from vidstyle.explore.page import explore_server
from vidstyle.explore.page.exploration import Exploration
from vidstyle.explore.page.explore_server import STATIC_FOLDER, ExploreConnection, ExploreServer
from vidstyle.preview.clip import open_clip
from vidstyle.web import server

MESSAGES = ExploreConnection.messages


@pytest.fixture(scope="module")
def page(folder: Path) -> Iterator[ExploreServer]:
    """A page that looks for no styles: none of these tests needs a tile."""
    clip = open_clip(make_clip(folder / "film.mp4", size=(64, 36), frames=3))
    with pytest.MonkeyPatch.context() as patch, Exploration(clip, 3) as exploration:
        patch.setattr(exploration, "begin", lambda: None)
        page = ExploreServer(exploration)
        yield page
        page.close()
        assert page.error is None
    clip.close()


@pytest.mark.parametrize("path", ["/", "/explore.js", "/tile.jpg?tile=0&frame=0&side=180", "/socket"])
def test_only_who_has_the_secret_is_admitted(visitor: Visitor, path: str) -> None:
    assert visitor.ask(path, visitor.headers(cookie="none=1"))[0] == 403
    assert visitor.ask(path, visitor.headers(host="evil.example"))[0] == 403
    assert visitor.ask(path, visitor.headers(Origin="https://evil.example"))[0] == 403
    assert visitor.ask(path, visitor.headers(), "POST", b"x")[0] in (0, 400, 405)


def test_malformed_messages_end_the_socket_and_nothing_else(page: ExploreServer, visitor: Visitor) -> None:
    chance = random.Random(4)
    values = [None, True, -1, 0, 1.5, 2**60, "", "x", "x" * 300, [], {}, float("inf")]
    before = page.state()
    for number in range(60):
        kind = chance.choice([*MESSAGES, "nothing", 7])
        fields = MESSAGES[kind].fields if kind in MESSAGES else ()
        message = {"do": kind, **{name: chance.choice(values) for name in ("id", *fields)}, "more": 1}
        text = json.dumps(message) if number % 5 else json.dumps(message)[:-3]
        with visitor.look() as window:
            window.socket.send(text)
            with pytest.raises(ConnectionClosed) as caught:
                window.news("never")
        assert caught.value.rcvd is not None and caught.value.rcvd.code == 1008
    assert page.state() == before and page.error is None


def test_what_the_next_screen_is_like_may_be_set_before_the_first_one(
    page: ExploreServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures: list[object] = []
    monkeypatch.setattr(threading, "excepthook", failures.append)
    page.exploration.set_near(0.6)
    page.exploration.lock("colors", False)
    ahead = [each for each in threading.enumerate() if each.name == "vidstyle ahead"]
    for thread in ahead:
        thread.join()
    page.exploration.set_near(0.4)
    assert not failures


def test_messages_have_a_size_and_a_rate(visitor: Visitor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ExploreConnection, "MAX_MESSAGES", 5)
    for texts, code in (
        (["x" * (server.MAX_MESSAGE + 1)], 1009),
        ([json.dumps({"do": "cancel", "id": 1})] * 40, 1008),
    ):
        with visitor.look() as window, pytest.raises(ConnectionClosed) as caught:
            for text in texts:
                window.socket.send(text)
            window.news("never")
        assert caught.value.rcvd is not None and caught.value.rcvd.code == code


def test_so_many_browsers_and_no_more(visitor: Visitor, page: ExploreServer) -> None:
    eventually(lambda: not page.browsers)
    with ExitStack() as stack:
        for _ in range(explore_server.MAX_BROWSERS):
            stack.enter_context(visitor.look()).news("state")
        assert visitor.ask("/socket")[0] == 429


def test_the_page_sends_what_the_server_knows_and_loads_nothing_from_elsewhere() -> None:
    texts = {path.name: path.read_text(encoding="utf-8") for path in STATIC_FOLDER.iterdir()}
    scripts = "".join(text for name, text in texts.items() if name.endswith(".js"))
    opening = (server.SHARED_FOLDER / "opening.js").read_text(encoding="utf-8")
    ids = re.findall(r'\bid="([\w-]+)"', texts["explore.html"] + opening)
    assert len(ids) == len(set(ids)) and set(
        re.findall(r'\bget\("([\w-]+)"\)', scripts.replace("options.get(", ""))
    ) <= set(ids)
    for text in texts.values():
        assert not re.search(r"http:|https:|innerHTML|eval\(|style=|@import|onclick=\"", text)
