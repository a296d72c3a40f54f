"""The designer against strangers: who may ask, what messages may be, and where files may be written."""

from __future__ import annotations

import json
import os
import random
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from designing import Page, served, shown
from live_page import Visitor
from media import make_picture
from waiting import LONG, eventually
from websockets.exceptions import ConnectionClosed, InvalidStatus

from vidstyle.design.designer import Designer
from vidstyle.design.drafts import Drafts
from vidstyle.design.page.design_connection import DesignConnection
from vidstyle.design.page.design_server import MAX_PAGES, DesignServer
from vidstyle.errors import UsageError
from vidstyle.preview.clip import open_clip
from vidstyle.preview.places import check_path
from vidstyle.web.messages import MessageError, read_message


@pytest.fixture(scope="module")
def photo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_picture(tmp_path_factory.mktemp("photo") / "photo.png", size=(48, 32))


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory, photo: Path) -> Iterator[DesignServer]:
    """The server of all tests, which must survive each of them."""
    with served(tmp_path_factory.mktemp("folder"), open_clip(photo)) as server:
        yield server


def test_nobody_else_gets_a_page_a_picture_or_a_socket(server: DesignServer) -> None:
    visitor = Visitor(server)
    paths = ("/", "/runner.js", "/block.jpg?of=hue", "/components.css", "/socket")
    for path in paths:
        assert visitor.ask(path, visitor.headers(cookie="none=1"))[0] == 403
        assert visitor.ask(path, visitor.headers(host="evil.example"))[0] == 403
        assert visitor.ask(path, visitor.headers(Origin="http://evil.example"))[0] == 403
    assert visitor.ask("/", visitor.headers(Content_Length="1"), body=b"x")[0] in (0, 400)
    for origin, cookie in (("http://evil.example", None), ("", "none=1")):
        with pytest.raises(InvalidStatus), visitor.look(origin, cookie):
            pass
    assert [visitor.ask(path)[0] for path in paths[:4]] == [200] * 4


def test_no_path_leads_out_of_the_pages_files(server: DesignServer) -> None:
    visitor = Visitor(server)
    for path in ("/../designer.py", "/%2e%2e/designer.py", "/block.jpg?of=../x", "/style.jpg?of=/etc/passwd"):
        assert visitor.ask(path)[0] == 404


def test_the_policy_allows_nothing_from_elsewhere(server: DesignServer) -> None:
    policy = Visitor(server).ask("/")[1]["content-security-policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy and "http:" not in policy


def test_only_a_few_pages_are_served(server: DesignServer) -> None:
    visitors = [shown(server) for _ in range(MAX_PAGES)]
    pages = [each.__enter__() for each in visitors]
    with pytest.raises(InvalidStatus) as caught, Visitor(server).look():
        pass
    assert caught.value.response.status_code == 429
    for each in visitors:
        each.__exit__(None, None, None)
    assert len(pages) == MAX_PAGES


def is_closed(page: Page) -> int:
    """The code with which the server closes the socket."""
    with pytest.raises(ConnectionClosed) as caught:
        while True:
            page.take(LONG)
    return caught.value.rcvd.code if caught.value.rcvd else 0


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", 1008),
        ("[]", 1008),
        ('{"do": "eval", "id": 1}', 1008),
        ('{"do": "save"}', 1008),
        ('{"do": "save", "id": 1, "path": "/etc/passwd"}', 1008),
        ('{"do": "set", "id": 1, "gesture": 1, "step": 1, "name": "sigma", "value": [1]}', 1008),
        ('{"do": "play", "id": 1, "at": 0, "first": 0, "last": 1, "fps": NaN}', 1008),
        ('{"do": "watch", "id": 1, "solo": null, "side": 99999, "where": "page"}', 1008),
        ("[" * 5000, 1008),
        ("x" * 70_000, 1009),
    ],
)
def test_a_message_that_the_page_does_not_send_ends_the_connection(
    server: DesignServer, text: str, code: int
) -> None:
    with shown(server) as page:
        page.socket.send(text)
        assert is_closed(page) == code
    with shown(server) as page:
        assert page.error("new") == ""


def test_parts_of_no_file_and_more_than_was_announced_end_the_connection(server: DesignServer) -> None:
    with shown(server) as page:
        page.socket.send(b"part")
        assert is_closed(page) == 1008
    with shown(server) as page:
        page.ask("upload", name="a.png", size=3)
        page.socket.send(b"part")
        assert is_closed(page) == 1008


def test_too_many_messages_end_the_connection(server: DesignServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(DesignConnection, "MAX_MESSAGES", 20)
    with shown(server) as page:
        for _ in range(60):
            page.say("command", name="", frames=None)
        assert is_closed(page) == 1008


NAMES = [
    "../up", "a/b", "/etc/x", ".hidden", "a\\b", "", "-", "a\nb", "c:x", "con", "nul.toml", "a\0", "~",
    "%05d", "*", "a?", "x" * 200, "a..b", " a", "link",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_files_are_written_under_plain_names_in_one_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / "link.toml").symlink_to(tmp_path.parent / "elsewhere.toml")
    with pytest.raises(UsageError):
        check_path(tmp_path, name, ".toml")
    with pytest.raises(UsageError):
        check_path(tmp_path, name)


@pytest.mark.parametrize("name", ["ink", "My style (2)", "été-1.v2", "a.toml"])
def test_usual_names_are_taken(tmp_path: Path, name: str) -> None:
    path = check_path(tmp_path, name, ".toml")
    assert path.parent == tmp_path and path.suffix == ".toml" and path.name.count(".toml") == 1


def test_nothing_but_a_style_is_written_over(server: DesignServer) -> None:
    folder = server.designer.folder
    (folder / "notes.toml").mkdir()
    with shown(server) as page:
        page.ask("new")
        assert "is not a file" in page.error("save_as", name="notes", overwrite=True)
        for name in NAMES:
            if 0 < len(name) <= 200 and name != "link":
                for kind in ("save_as", "render", "export"):
                    more = {"frames": 1} if kind == "render" else {}
                    more |= {"kind": "html"} if kind == "export" else {}
                    assert page.error(kind, name=name, overwrite=True, **more)
    assert set(os.listdir(folder)) - {"drafts"} == {"notes.toml"}


def test_a_page_opens_styles_of_the_list_alone(server: DesignServer, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text('format = 1\n[[base]]\nblock = "hue"\n')
    with shown(server) as page:
        for name in (str(tmp_path / "own.toml"), "own.toml", "../ink", "ink:dark-blue"):
            assert "is not in the list of styles" in page.error("open", style=name)


def test_a_style_from_a_stranger_reads_no_file_and_holds_no_code(
    server: DesignServer, tmp_path: Path
) -> None:
    (tmp_path / "secret.npz").write_bytes(b"x")
    with shown(server) as page:
        page.ask("new")
        for path in ("secret.npz", "../secret.npz", "/etc/passwd"):
            text = f'format = 1\n[[base]]\nblock = "learned"\nbank = "{path}"\n'
            told = page.upload("x.toml", text.encode())["error"]
            assert "bank" in told and not page.told["state"]["layers"]["base"]
        assert "is not TOML" in page.upload("x.toml", b"import os")["error"]
        hostile = b'format = 1\n[[base]]\nblock = "os.system"\n'
        assert "is not a block" in page.upload("x.toml", hostile)["error"]
        page.upload("\x07../x.toml", b"format = 1\n")
        assert page.told["state"]["name"] == "x"


def test_a_draft_that_somebody_has_written_is_no_draft(tmp_path: Path, photo: Path) -> None:
    for content in ("", "[]", "{}", '{"table": 1, "text": null, "file": "", "when": ""}', "{" * 10**5):
        (tmp_path / "draft.json").write_text(content)
        assert Drafts(tmp_path / "draft.json").offered == []
    draft = {"table": {"format": 1, "base": 5}, "text": None, "file": "", "when": "now"}
    (tmp_path / "draft.json").write_text(json.dumps(draft))
    designer = Designer(open_clip(photo), tmp_path, Drafts(tmp_path / "draft.json"))
    with pytest.raises(ValueError, match="is not a list of steps"):
        designer.open_draft(True)
    designer.open_draft(False)
    assert not (tmp_path / "draft.json").exists(), "it can be discarded"
    designer.clip.close()


VALUES = [
    None,
    True,
    -1,
    0,
    1,
    7,
    0.5,
    1e300,
    2**60,
    "",
    "lines",
    "hue",
    "a" * 300,
    "\ud800",
    [],
    {},
    "ink",
    "page",
]


def malformed(choose: random.Random) -> str:
    """A message of the page with something wrong, or with values that make no sense."""
    kind = choose.choice([*DesignConnection.messages, "nothing"])
    fields = ["id", *DesignConnection.messages[kind].fields] if kind != "nothing" else ["id"]
    message = {"do": kind} | {name: choose.choice(VALUES) for name in fields}
    if choose.random() < 0.7:
        message["id"] = 1
        if "gesture" in message:
            message["gesture"] = 1
    if choose.random() < 0.1:
        message.pop(choose.choice(list(message)))
    text = json.dumps(message)
    if choose.random() < 0.1:
        text = text[: choose.randrange(len(text))]
    return text


def test_the_last_page_may_close_while_a_draft_is_kept(
    photo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, done = threading.Event(), threading.Event()

    def keep_draft() -> None:
        begun.set()
        eventually(lambda: not server.browsers)
        done.set()

    with served(tmp_path, open_clip(photo)) as server:
        with shown(server) as page:
            page.ask("new")
            # Opening a style keeps a draft too, before it answers.
            monkeypatch.setattr(server.designer, "keep_draft", keep_draft)
            page.ask("add", layer="base", index=0, block="gaussian", gesture=1)
            assert begun.wait(LONG)
        assert done.wait(LONG)
        eventually(lambda: not server.tasks)


@pytest.mark.parametrize("count", [60, pytest.param(1000, marks=pytest.mark.thorough)])
def test_malformed_messages_never_raise(
    server: DesignServer, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each is refused by the table, or answered; the first that is refused ends the connection."""
    monkeypatch.setattr(DesignConnection, "MAX_MESSAGES", 10**6)
    choose = random.Random(random.randrange(2**32))
    refused = []
    with shown(server) as page:
        page.ask("new")
        for text in (malformed(choose) for _ in range(count)):
            try:
                read_message(text, DesignConnection.messages)
                kind = json.loads(text)["do"]
            except MessageError:
                refused.append(text)
                continue
            if kind in ("upload", "start", "steady", "render"):  # begun for good, and long
                continue
            page.socket.send(text)
            page.say("command", name="", frames=None)
            page.answer(json.loads(text)["id"])
    assert len(refused) > count / 4
    for text in refused[:3]:
        with shown(server) as page:
            page.socket.send(text)
            assert is_closed(page) == 1008
    eventually(lambda: not server.browsers)
    assert server.error is None
