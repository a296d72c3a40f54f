"""Messages from the page; each is validated before it reaches the session."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from vidstyle.live.control import Controls

MAX_ASSIGNMENTS, MAX_TEXT = 200, 200

Check = Callable[[object], bool]


class MessageError(Exception):
    """A message that the page does not send."""


def _is_text(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= MAX_TEXT


def _is_text_list(value: object) -> bool:
    return isinstance(value, list) and 0 < len(value) <= MAX_ASSIGNMENTS and all(map(_is_text, value))


def _is_bool(value: object) -> bool:
    return isinstance(value, bool)


def _is_index(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


FIELDS: dict[str, dict[str, Check]] = {
    "shown": {"number": _is_index},
    "set": {"assignments": _is_text_list},
    "choose": {"style": _is_text},
    "next": {},
    "bypass": {"on": _is_bool},
    "record": {"on": _is_bool},
    "quit": {},
}
"""The fields of each kind of message; all of them are required, and no others are allowed."""


def read_message(text: str | bytes) -> dict[str, Any]:
    """Parse and validate a message; returns its kind, "do", and the fields that belong to it.

    Raises:
        MessageError: the text is not a valid message.

    >>> read_message('{"do": "bypass", "on": true}')
    {'do': 'bypass', 'on': True}
    >>> read_message('{"do": "bypass", "on": 1}')
    Traceback (most recent call last):
    vidstyle.live.page.messages.MessageError: bypass: on has the wrong type or range
    """
    try:
        message = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise MessageError("not a JSON object")
    do = message.get("do")
    if not isinstance(do, str) or do not in FIELDS:
        raise MessageError("unknown kind of message")
    if message.keys() != {"do", *FIELDS[do]}:
        raise MessageError(f"{do}: takes {', '.join(FIELDS[do]) or 'nothing'}")
    for name, check in FIELDS[do].items():
        if not check(message[name]):
            raise MessageError(f"{do}: {name} has the wrong type or range")
    return message


def dispatch(message: dict[str, Any], controls: Controls) -> None:
    """Apply a message other than "shown" to the session.

    Raises:
        VidstyleError: unknown style, variant or parameter, or an invalid value.
    """
    match message["do"]:
        case "set":
            controls.set(message["assignments"])
        case "choose":
            controls.choose(message["style"])
        case "next":
            controls.next_style()
        case "bypass":
            controls.bypass(message["on"])
        case "record":
            controls.record(message["on"])
        case "quit":
            controls.quit()
