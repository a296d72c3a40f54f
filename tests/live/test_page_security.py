"""Access control of the page's server: only authorized browsers on this machine, and only the page."""

from __future__ import annotations

import gc
import logging
import socket
import threading
from collections.abc import Iterator
from contextlib import suppress
from urllib.parse import urlsplit

import pytest
from live import FakeClock
from live_page import Visitor, showing
from waiting import LONG, eventually
from websockets.exceptions import ConnectionClosed, InvalidStatus

from vidstyle.errors import OutputError
from vidstyle.live.control import Controls
from vidstyle.live.page import PageTarget
from vidstyle.live.page.page_target import STATIC_FOLDER
from vidstyle.live.page.viewer import Viewer
from vidstyle.style import load_style
from vidstyle.web import server


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Iterator[PageTarget]:
    """Its server gives up on a request later than a test: one that waits for anything fails."""
    monkeypatch.setattr(server, "OPEN_SECONDS", 10 * LONG)
    with showing() as (page, _, _):
        yield page


@pytest.fixture
def visitor(page: PageTarget) -> Iterator[Visitor]:
    """A server that must answer each test immediately, after any other test."""
    visitor = Visitor(page)
    yield visitor
    assert visitor.ask("/")[0] == 200


def refused_socket(visitor: Visitor, origin: str | None = "", cookie: str | None = None) -> int:
    with pytest.raises(InvalidStatus) as caught, visitor.look(origin, cookie):
        pass
    return caught.value.response.status_code


def test_it_listens_on_the_loopback_address_alone(visitor: Visitor) -> None:
    """Who listens on all addresses would answer on every one that begins with 127."""
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", visitor.port), timeout=LONG)


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:{port}", "127.evil.com:{port}", "127.0.0.1", "127.0.0.1:1",
     "0.0.0.0:{port}", "localhost.:{port}", "127.0.0.1:{port}.evil.example", "x@127.0.0.1:{port}", ""],
)  # fmt: skip
def test_other_names_for_it_are_refused(visitor: Visitor, host: str) -> None:
    """A foreign name may be made to point to this machine."""
    headers = [("Host", host.format(port=visitor.port)), ("Cookie", visitor.cookie)]
    assert visitor.ask("/", headers)[0] == 403
    assert visitor.ask(f"/?token={visitor.token}", headers)[0] == 403


def test_a_host_left_out_or_named_twice_is_refused(visitor: Visitor) -> None:
    refused = (400, 403)  # by aiohttp, or by the page with versions before 3.14
    assert visitor.ask("/", [("Cookie", visitor.cookie)])[0] in refused
    for first, second in (
        (visitor.host, visitor.host),
        (visitor.host, "evil.example"),
        ("evil.example", visitor.host),
    ):
        assert visitor.ask("/", [("Host", first), ("Host", second), ("Cookie", visitor.cookie)])[0] in refused


@pytest.mark.parametrize("address", ["127.0.0.2", server.ANY_ADDRESS])
def test_opened_to_a_network_it_answers_to_the_address_that_was_asked_and_no_other(
    address: str, caplog: pytest.LogCaptureFixture
) -> None:
    """All addresses that start with 127 are local; the first one is not a network address."""
    with showing(address=address) as (page, _, _):
        visitor = Visitor(page, "127.0.0.2")
        assert visitor.ask(f"/?token={visitor.token}", [("Host", visitor.host)])[0] == 303
        policy = visitor.ask("/")[1]["content-security-policy"]
        assert f"connect-src 'self' ws://{visitor.host}" == policy.rpartition("; ")[2]
        for host in (f"127.0.0.1:{visitor.port}", f"localhost:{visitor.port}", "evil.example"):
            assert visitor.ask("/", visitor.headers(host=host))[0] == 403
        assert visitor.ask("/", visitor.headers(cookie="none=1"))[0] == 403
        assert refused_socket(visitor, origin=f"http://127.0.0.1:{visitor.port}") == 403
        with visitor.look() as window:
            assert window.news("names")
    assert "not encrypted" in caplog.text


def test_an_address_of_another_machine_is_refused() -> None:
    with pytest.raises(OutputError, match="page: 203.0.113.1 is not an address of this machine; give one"):
        PageTarget(Controls(load_style("plain")), address="203.0.113.1")


def test_localhost_is_its_name_too(visitor: Visitor) -> None:
    name = f"localhost:{visitor.port}"
    assert visitor.ask("/", visitor.headers(host=name))[0] == 200
    assert visitor.ask("/", visitor.headers(host=name, Origin=f"http://{name}"))[0] == 200


@pytest.mark.parametrize(
    "origin",
    ["null", "https://evil.example", "http://127.0.0.1", "http://127.0.0.1:1", "https://{host}",
     "http://localhost:{port}", "http://{host}.evil.example", "HTTP://{host}"],
)  # fmt: skip
def test_requests_of_other_sites_are_refused(visitor: Visitor, origin: str) -> None:
    origin = origin.format(host=visitor.host, port=visitor.port)
    assert visitor.ask("/", visitor.headers(Origin=origin))[0] == 403
    assert refused_socket(visitor, origin=origin) == 403


def test_only_a_socket_of_its_own_page_is_accepted(visitor: Visitor) -> None:
    assert refused_socket(visitor, origin=None) == 403
    with visitor.look() as window:
        assert window.news("names")


def test_what_other_sites_load_is_refused_but_links_to_the_page_are_followed(visitor: Visitor) -> None:
    for site in ("cross-site", "same-site"):
        embedded = visitor.headers(Sec_Fetch_Site=site, Sec_Fetch_Mode="no-cors", Sec_Fetch_Dest="image")
        framed = visitor.headers(Sec_Fetch_Site=site, Sec_Fetch_Mode="navigate", Sec_Fetch_Dest="iframe")
        visit = visitor.headers(Sec_Fetch_Site=site, Sec_Fetch_Mode="navigate", Sec_Fetch_Dest="document")
        assert [visitor.ask("/picture.png", embedded)[0], visitor.ask("/", framed)[0]] == [403, 403]
        assert visitor.ask("/picture.png", visit)[0] == 403
        assert visitor.ask(f"/?token={visitor.token}", visit)[0] == 303


@pytest.mark.parametrize("path", ["/", "/page.js", "/picture.png", "/nothing", "/?token=wrong", "/?token="])
def test_without_the_secret_there_is_nothing(visitor: Visitor, path: str) -> None:
    name = f"vidstyle-{visitor.port}"
    for cookie in (
        "none=1",
        f"{name}=wrong",
        f"vidstyle-1={visitor.token}",
        f"{name}=\xe9",
        name,
        f"{name}=",
        "=",
    ):
        assert visitor.ask(path, visitor.headers(cookie=cookie))[0] == 403
    twice = f"{visitor.cookie}; {visitor.cookie}"
    assert visitor.ask("/", visitor.headers(cookie=twice))[0] == 403


def test_a_socket_wants_the_secret_in_a_cookie(visitor: Visitor) -> None:
    assert refused_socket(visitor, cookie=f"vidstyle-{visitor.port}=wrong") == 403
    assert refused_socket(visitor, cookie="") == 403


def test_the_address_is_exchanged_for_a_cookie_that_scripts_cannot_read(visitor: Visitor) -> None:
    status, headers, _ = visitor.ask(f"/?token={visitor.token}", [("Host", visitor.host)])
    assert (status, headers["location"]) == (303, "/")
    value, *attributes = headers["set-cookie"].split("; ")
    assert value == visitor.cookie
    assert set(attributes) == {"HttpOnly", "SameSite=Strict", "Path=/"}


def test_the_address_for_the_browser_that_is_started_admits_once() -> None:
    """Others see it in the list of processes."""
    opened: list[str] = []
    with showing(browse=opened.append) as (page, _, visitor):
        path = opened[0].removeprefix(f"http://{visitor.host}")
        assert visitor.token not in opened[0] and opened[0].startswith(f"http://{visitor.host}/?token=")
        status, headers, _ = visitor.ask(path, [("Host", visitor.host)])
        assert (status, headers["set-cookie"].partition(";")[0]) == (303, visitor.cookie)
        assert visitor.ask(path, [("Host", visitor.host)])[0] == 403


def test_the_secret_is_long_and_each_session_has_its_own(visitor: Visitor) -> None:
    with showing() as (_, _, other):
        assert other.token != visitor.token
        assert min(len(other.token), len(visitor.token)) >= 22  # 128 bits at 6 bits a character
        stolen = f"vidstyle-{visitor.port}={other.token}"
        assert visitor.ask("/", visitor.headers(cookie=stolen))[0] == 403


@pytest.mark.parametrize("path", ["/", "/page.css", "/picture.png", "/nothing", "/?token={token}"])
def test_every_answer_keeps_the_browser_careful(visitor: Visitor, path: str) -> None:
    _, headers, _ = visitor.ask(path.format(token=visitor.token))
    assert not [name for name in headers if name.startswith("access-control")]
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["x-frame-options"] == "DENY"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cache-control"] == "no-store"
    assert headers["cross-origin-resource-policy"] == "same-origin"
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy and "*" not in policy


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "HEAD"])
def test_nothing_is_changed_by_plain_requests(visitor: Visitor, method: str) -> None:
    body = b'{"do": "quit"}'
    headers = visitor.headers(Content_Type="application/json", Content_Length=str(len(body)))
    assert visitor.ask("/socket", headers, method, body)[0] in (0, 400, 405)


def test_nothing_can_be_uploaded(visitor: Visitor) -> None:
    headers = visitor.headers(Content_Length=str(3 << 30))
    assert visitor.ask("/", headers, "POST", bytes(1 << 20))[0] in (0, 400, 413)
    assert visitor.ask("/", headers, "GET", bytes(1 << 20))[0] in (0, 400, 413)


@pytest.mark.parametrize(
    "path",
    ["/page.py", "/../page.py", "/..%2fpage.py", "/..%2f..%2f..%2fetc/passwd", "/%2e%2e/page.py", "//[", "//",
     "//etc/passwd", "/etc/passwd", "/C:%5Cwindows%5Cwin.ini", "/./page.js", "/page.js/", "/page.js%00",
     "/static/", "/page.html", "http://{host}/page.js", "/%"],
)  # fmt: skip
def test_no_other_file_is_to_be_had(visitor: Visitor, path: str) -> None:
    status, _, body = visitor.ask(path.format(host=visitor.host))
    assert (status, b"import" in body, b"root:" in body) == (404, False, False)


def test_a_socket_is_at_its_own_address_and_nothing_else_is_there(visitor: Visitor) -> None:
    assert visitor.ask("/socket")[0] == 426
    for path in ("/", "/page.js", "/picture.png", "/socket/", "/nothing"):
        with pytest.raises(InvalidStatus), visitor.look(path=path):
            pass


def test_a_picture_is_for_keeping_under_a_name_that_is_ours(visitor: Visitor) -> None:
    status, headers, body = visitor.ask("/picture.png?name=../../x.svg")
    assert (status, headers["content-type"], body[:4]) == (200, "image/png", b"\x89PNG")
    assert headers["content-disposition"] == 'attachment; filename="vidstyle-ink-0.png"'


def test_a_page_sets_no_path_beyond_the_style() -> None:
    with showing("crayon") as (_, controls, visitor), visitor.look() as window:
        before = controls.style
        for path in ("../../../etc/passwd", "/etc/passwd", "x" * 150):
            assert window.ask(do="set", values={"pattern#1.tile": path})
            assert window.ask(do="choose", style=path)
        assert controls.style is before


def test_messages_have_a_limit(visitor: Visitor) -> None:
    with visitor.look() as window:
        window.socket.send("x" * (server.MAX_MESSAGE + 1))
        with pytest.raises(ConnectionClosed) as caught:
            window.news("never")
    assert caught.value.rcvd is not None and caught.value.rcvd.code == 1009


def test_a_flood_of_messages_ends_the_socket(monkeypatch: pytest.MonkeyPatch) -> None:
    """N messages per second are answered; the count restarts with the next second."""
    monkeypatch.setattr(Viewer, "MAX_MESSAGES", 20)
    clock = FakeClock()
    with showing(clock=clock) as (page, _, visitor), visitor.look() as window:
        for _ in range(2):
            clock.advance(1)
            for _ in range(20):
                assert window.ask(do="bypass", on=True) == ""
        with pytest.raises(ConnectionClosed) as caught:
            window.ask(do="bypass", on=True)
        eventually(lambda: page.state == "no browser")
    assert caught.value.rcvd is not None and caught.value.rcvd.code == 1008


def test_long_headers_are_refused(visitor: Visitor) -> None:
    assert visitor.ask("/", visitor.headers(X_Long="x" * 100_000))[0] in (0, 400, 431)
    assert visitor.ask("/" + "x" * 100_000)[0] in (0, 400, 414, 431)


def test_so_many_browsers_and_no_more(visitor: Visitor, page: PageTarget) -> None:
    with visitor.look(), visitor.look(), visitor.look(), visitor.look() as last:
        assert last.news("status")
        assert refused_socket(visitor) == 429
    eventually(lambda: page.state == "no browser")
    with visitor.look() as window:
        assert window.news("status")


def test_who_says_nothing_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "OPEN_SECONDS", 0.2)
    with showing() as (_, _, visitor), socket.create_connection(("127.0.0.1", visitor.port)) as silent:
        silent.sendall(b"GET / HTTP/1.1\r\nHost: ")
        silent.settimeout(LONG)
        while silent.recv(1024):
            pass


def test_who_connects_while_it_closes_leaves_nothing_open() -> None:
    """An open connection causes a ResourceWarning of asyncio, which fails this test."""

    def connect(port: int, has_connected: threading.Event) -> None:
        with suppress(OSError):
            while True:
                socket.create_connection(("127.0.0.1", port), timeout=LONG).close()
                has_connected.set()

    for _ in range(12):
        closing, has_connected = server.WebServer("page", {}, [], "nothing"), threading.Event()
        visitor = threading.Thread(target=connect, args=(urlsplit(closing.url).port, has_connected))
        visitor.start()
        has_connected.wait(LONG)
        closing.close()
        visitor.join()
        gc.collect()


def test_what_a_stranger_sends_plays_no_tricks_on_the_terminal(
    visitor: Visitor, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    with caplog.at_level(logging.DEBUG, "vidstyle"):
        visitor.ask("/\x1b[31m%0a")
        visitor.ask("/", visitor.headers(Origin="\x1b]0;x"))
        with visitor.look() as window:
            assert "\\x1b" in window.ask(do="choose", style="\x1b[31m\nink")
            window.say(do="\x1b[31m\n")
            with pytest.raises(ConnectionClosed):
                window.news("never")
    said = "".join(record.getMessage() for record in caplog.records) + "".join(capfd.readouterr())
    assert "\x1b" not in said and "disconnected" in said


def test_a_port_that_is_taken_is_said(visitor: Visitor) -> None:
    with pytest.raises(OutputError, match=f"page: port {visitor.port}: .*in use; give another with --port"):
        PageTarget(Controls(load_style("plain")), visitor.port)


def test_the_files_of_the_page_load_nothing_from_elsewhere() -> None:
    for path in STATIC_FOLDER.glob("*.[hcj]*"):
        text = path.read_text(encoding="utf-8")
        assert (
            "http" not in text and "innerHTML" not in text and "style=" not in text and "@import" not in text
        )
