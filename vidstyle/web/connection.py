"""The connection to one browser: it sends to the page, and dispatches the messages of the page."""

from __future__ import annotations

import asyncio
import json
import struct
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from typing import Any, ClassVar

from aiohttp import WSCloseCode, WSMsgType, web

from vidstyle.errors import UsageError, VidstyleError, log
from vidstyle.web.background_tasks import BackgroundTasks
from vidstyle.web.messages import Answer, Message, MessageError, RateLimit, read_message

PICTURE_HEADER = struct.Struct(">B3xIQ")
"""Header of a picture: its type, a number, and the revision of what it shows; `socket.js` reads it."""


class PageConnection:
    """Serves one WebSocket until it closes. A subclass declares the messages of its page with `message`.

    Attributes:
        messages: the messages that the page may send, by name.
        MAX_MESSAGES: maximum number of messages per second; binary messages are not counted.
        MAX_TASKS: maximum number of background tasks; further messages of this kind are refused.
        tasks: background tasks, which end when the browser disconnects.
    """

    messages: ClassVar[Mapping[str, Message]] = {}
    MAX_MESSAGES: ClassVar[int] = 250
    MAX_TASKS: ClassVar[int] = 40

    def __init_subclass__(cls) -> None:
        own = {name: each for name, each in vars(cls).items() if isinstance(each, Message)}
        assert not own.keys() & cls.messages.keys(), "two messages have one name"
        cls.messages = {**cls.messages, **own}

    def __init__(self, fail: Callable[[BaseException], None], now: Callable[[], float] | None = None) -> None:
        """Prepare a connection, within the event loop of the server.

        Args:
            fail: reports an exception in a background task, which is a bug in this program.
            now: the clock for the message rate limit, in seconds; None: the event loop's clock.
        """
        self.tasks = BackgroundTasks(fail)
        self._limit = RateLimit(self.MAX_MESSAGES, now or asyncio.get_running_loop().time)

    async def serve(self, socket: web.WebSocketResponse) -> None:
        """Greet the browser, then dispatch its messages until the socket closes or a message is invalid."""
        self._socket = socket
        invalid = None
        try:
            await self.greet()
            invalid = await self._receive()
        finally:
            await self.tasks.cancel()
            self.leave()
        if invalid is not None:
            log.warning("page: a browser was disconnected: %s", invalid)
            await socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"not a message of this page")

    async def greet(self) -> None:
        """Send the initial messages."""

    def leave(self) -> None:
        """Release the resources of the connection, which has ended."""

    async def take_bytes(self, data: bytes) -> None:
        """Handle a binary message; a page sends none unless a subclass allows it."""
        raise MessageError("not a JSON object")

    async def tell(self, message: dict[str, Any]) -> None:
        """Send a message, unless the browser has disconnected."""
        with suppress(ConnectionError):
            await self._socket.send_str(json.dumps(message))

    async def send_picture(self, kind: int, number: int, revision: int, data: bytes) -> None:
        """Send a picture, encoded as PNG or JPEG, unless the browser has disconnected."""
        with suppress(ConnectionError):
            await self._socket.send_bytes(PICTURE_HEADER.pack(kind, number, revision) + data)

    async def answer(self, id: int, work: Callable[[], Awaitable[Answer]]) -> None:
        """Answer a message with the result of `work`, or with its error message."""
        try:
            answer = await work() or {}
        except VidstyleError as error:
            answer = {"error": self.error_text(error)}
        await self.tell({"answer": id} | answer)

    def error_text(self, error: VidstyleError) -> str:
        """Return the error as one sentence."""
        return str(error)

    async def _receive(self) -> MessageError | None:
        """Handle messages until the socket closes; stop at an invalid message and return its error."""
        async for data in self._socket:
            if data.type is WSMsgType.ERROR:  # too large, for example; aiohttp has closed the socket
                break
            try:
                await self._handle(data.data)
            except MessageError as error:
                return error
        return None

    async def _handle(self, data: str | bytes) -> None:
        if isinstance(data, bytes):
            return await self.take_bytes(data)
        self._limit.count()
        kind, id, fields = read_message(data, self.messages)
        if not kind.in_background:
            await self.answer(id, lambda: kind.handle(self, **fields))
        elif len(self.tasks) >= self.MAX_TASKS:
            await self.answer(id, _refuse)
        else:
            self.tasks.begin(self.answer(id, lambda: kind.handle(self, **fields)))


async def _refuse() -> Answer:
    raise UsageError("the page", "is busy", "wait for the running requests")
