"""Parsing and validation of messages from a page, by a schema."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from vidstyle.errors import log

MAX_TEXT_CHARACTERS = 200
"""Default maximum length of a string."""

Check = Callable[[object], bool]
"""Returns whether a field has the right type and range."""
Fields = Mapping[str, Check]
"""The fields of a message, in the order of the arguments of its action."""


class MessageError(Exception):
    """An invalid message, which no page of ours sends."""


def is_text(value: object) -> bool:
    """Whether it is a string of 1 to `MAX_TEXT_CHARACTERS` characters."""
    return isinstance(value, str) and 0 < len(value) <= MAX_TEXT_CHARACTERS


def is_bool(value: object) -> bool:
    """Whether it is true or false."""
    return isinstance(value, bool)


def is_index(value: object) -> bool:
    """Whether it is an integer from 0 that JavaScript represents exactly."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**53


def is_part(value: object) -> bool:
    """Whether it is a number from 0 to 1."""
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1


class RateLimit:
    """Limits the number of messages per second.

    >>> limit = RateLimit(1, lambda: 0.0)
    >>> limit.count()
    >>> limit.count()
    Traceback (most recent call last):
    vidstyle.web.messages.MessageError: more than 1 messages in a second
    """

    def __init__(self, most: int, now: Callable[[], float]) -> None:
        """`most`: maximum number of messages in each second of the clock `now`."""
        self._most, self._now = most, now
        self._second, self._count = int(now()), 0

    def count(self) -> None:
        """Count a message.

        Raises:
            MessageError: the limit of this second is exceeded.
        """
        second = int(self._now())
        self._count = self._count + 1 if second == self._second else 1
        self._second = second
        if self._count > self._most:
            raise MessageError(f"more than {self._most} messages in a second")


async def receive(
    socket: web.WebSocketResponse, handle: Callable[[str | bytes], Awaitable[None]]
) -> MessageError | None:
    """Handle messages until the socket closes; stop at an invalid message and return its error."""
    async for message in socket:
        if message.type is WSMsgType.ERROR:  # too large, for example; aiohttp has closed the socket
            break
        try:
            await handle(message.data)
        except MessageError as error:
            return error
    return None


async def refuse(socket: web.WebSocketResponse, mistake: MessageError) -> None:
    """Close the socket of a browser that sent an invalid message."""
    log.warning("page: a browser was disconnected: %s", mistake)
    await socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"not a message of this page")


def read_message(text: str | bytes, kinds: Mapping[str, Fields]) -> dict[str, Any]:
    """Parse and validate a message; return its kind, "do", and its fields.

    Args:
        kinds: the fields of each message. All are required, and no others are allowed.

    Raises:
        MessageError: the text is not a valid message.

    >>> read_message('{"do": "bypass", "on": true}', {"bypass": {"on": is_bool}})
    {'do': 'bypass', 'on': True}
    >>> read_message('{"do": "bypass", "on": 1}', {"bypass": {"on": is_bool}})
    Traceback (most recent call last):
    vidstyle.web.messages.MessageError: bypass: on has the wrong type or range
    """
    try:
        message = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise MessageError("not a JSON object")
    do = message.get("do")
    if not isinstance(do, str) or do not in kinds:
        raise MessageError("unknown kind of message")
    fields = kinds[do]
    if message.keys() != {"do", *fields}:
        raise MessageError(f"{do}: takes {', '.join(fields) or 'nothing'}")
    for name, check in fields.items():
        if not check(message[name]):
            raise MessageError(f"{do}: {name} has the wrong type or range")
    return message
