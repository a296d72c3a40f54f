"""What a page asks for: each message is checked in full before it reaches the session."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from vidstyle.live.control import Controls

MAX_ASSIGNMENTS, MAX_TEXT = 200, 200

Check = Callable[[object], bool]


class MessageError(Exception):
    """A message that our page does not send."""


def _is_text(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= MAX_TEXT


def _is_texts(value: object) -> bool:
    return isinstance(value, list) and 0 < len(value) <= MAX_ASSIGNMENTS and all(map(_is_text, value))


def _is_switch(value: object) -> bool:
    return isinstance(value, bool)


def _is_number(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


FIELDS: dict[str, dict[str, Check]] = {
    "shown": {"number": _is_number},
    "set": {"assignments": _is_texts},
    "choose": {"style": _is_text},
    "next": {},
    "bypass": {"on": _is_switch},
    "record": {"on": _is_switch},
    "quit": {},
}
"""The messages there are, by what they ask for, and the fields of each: all of them and no others."""


def read_message(text: str | bytes) -> dict[str, Any]:
    """A message as an object with "do" and the fields that belong to it.

    Raises:
        MessageError: it is anything else.

    >>> read_message('{"do": "bypass", "on": true}')
    {'do': 'bypass', 'on': True}
    >>> read_message('{"do": "bypass", "on": 1}')
    Traceback (most recent call last):
    vidstyle.live.page.messages.MessageError: bypass: on is not what it should be
    """
    try:
        message = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise MessageError("not an object in JSON")
    do = message.get("do")
    if not isinstance(do, str) or do not in FIELDS:
        raise MessageError("asks for what there is not")
    if message.keys() != {"do", *FIELDS[do]}:
        raise MessageError(f"{do}: takes {', '.join(FIELDS[do]) or 'nothing'}")
    for name, check in FIELDS[do].items():
        if not check(message[name]):
            raise MessageError(f"{do}: {name} is not what it should be")
    return message


def carry_out(message: dict[str, Any], controls: Controls) -> None:
    """Pass a message other than "shown" on to the session.

    Raises:
        VidstyleError: there is no such style, variant or parameter, or its value cannot be.
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
