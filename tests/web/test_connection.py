"""The base of all pages, over a real socket: answers, background messages, faults, browsers that leave."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from live_page import Visitor
from waiting import LONG, eventually
from websockets.exceptions import ConnectionClosed

from vidstyle.errors import OutputError, UsageError
from vidstyle.web.connection import PageConnection
from vidstyle.web.messages import Answer, message
from vidstyle.web.page_server import PageServer


class Desk(PageConnection):
    """A connection with one message of each sort."""

    MAX_TASKS = 2
    cancelled = threading.Event()

    @message
    async def double(self, number: int) -> Answer:
        return {"twice": 2 * number}

    @message
    async def refuse(self) -> None:
        raise UsageError("desk", "is closed", "come again")

    @message
    async def fail(self) -> None:
        raise ZeroDivisionError

    @message(in_background=True)
    async def fail_later(self) -> None:
        raise ZeroDivisionError

    @message(in_background=True)
    async def wait(self) -> None:
        try:
            await asyncio.sleep(10 * LONG)
        finally:
            self.cancelled.set()


@pytest.fixture
def server(tmp_path: Path) -> Iterator[PageServer[Desk]]:
    server: PageServer[Desk] = PageServer(
        "desk", lambda: Desk(server.fail), {}, tmp_path, "index.html", most=2
    )
    yield server
    server.close()


@pytest.fixture
def visitor(server: PageServer[Desk]) -> Visitor:
    return Visitor(server)  # type: ignore[arg-type]


def test_a_message_is_answered_with_its_result_or_its_error(visitor: Visitor) -> None:
    with visitor.look() as window:
        assert window.answer(do="double", number=4)["twice"] == 8
        assert window.ask(do="refuse") == "desk is closed; come again"
        window.socket.send(b"bytes")
        with pytest.raises(ConnectionClosed) as caught:
            window.news("never")
    assert caught.value.rcvd is not None and caught.value.rcvd.code == 1008


def test_background_messages_hold_up_no_other_and_are_limited(
    server: PageServer[Desk], visitor: Visitor
) -> None:
    Desk.cancelled.clear()
    with visitor.look() as window:
        for _ in range(Desk.MAX_TASKS):
            window.say(do="wait")
        assert "is busy" in window.ask(do="wait")
        assert window.answer(do="double", number=1)["twice"] == 2
        assert not Desk.cancelled.is_set()
    assert Desk.cancelled.wait(LONG), "the browser has left"
    eventually(lambda: not server.browsers)
    assert server.error is None


@pytest.mark.parametrize("kind", ["fail", "fail_later"])
def test_a_fault_of_the_program_ends_the_page(server: PageServer[Desk], visitor: Visitor, kind: str) -> None:
    with visitor.look() as window:
        window.say(do=kind)
        eventually(lambda: server.error)
    assert isinstance(server.error, ZeroDivisionError)


def test_a_port_that_is_taken_is_reported(visitor: Visitor, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=f"desk: port {visitor.port}: .*; give another with --port"):
        PageServer("desk", lambda: Desk(print), {}, tmp_path, "index.html", most=1, port=visitor.port)
