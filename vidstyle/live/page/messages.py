"""Messages from the page; each is validated before it reaches the session."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from vidstyle.live.control import Controls

MAX_VALUES, MAX_TEXT = 200, 200

Check = Callable[[object], bool]


class MessageError(Exception):
    """A message that the page does not send."""


def _is_text(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= MAX_TEXT


def _is_bool(value: object) -> bool:
    return isinstance(value, bool)


def _is_index(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _are_values(value: object) -> bool:
    """Whether it is an object of texts, numbers and truth values; whether they fit is checked later."""
    return (
        isinstance(value, dict)
        and 0 < len(value) <= MAX_VALUES
        and all(_is_text(path) and isinstance(each, str | int | float) for path, each in value.items())
    )


KINDS: dict[str, tuple[Callable[..., None] | None, dict[str, Check]]] = {
    "shown": (None, {"number": _is_index}),
    "set": (Controls.set_values, {"values": _are_values}),
    "choose": (Controls.choose, {"style": _is_text}),
    "next": (Controls.next_style, {}),
    "bypass": (Controls.bypass, {"on": _is_bool}),
    "record": (Controls.record, {"on": _is_bool}),
    "quit": (Controls.quit, {}),
}
"""What each kind of message but "shown" does, and its fields, which are the arguments.

All fields are required, and no others are allowed."""


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
    if not isinstance(do, str) or do not in KINDS:
        raise MessageError("unknown kind of message")
    _, fields = KINDS[do]
    if message.keys() != {"do", *fields}:
        raise MessageError(f"{do}: takes {', '.join(fields) or 'nothing'}")
    for name, check in fields.items():
        if not check(message[name]):
            raise MessageError(f"{do}: {name} has the wrong type or range")
    return message


def dispatch(message: dict[str, Any], controls: Controls) -> None:
    """Apply a message other than "shown" to the session.

    Raises:
        VidstyleError: unknown style, variant or parameter, or an invalid value.
    """
    action, fields = KINDS[message["do"]]
    assert action is not None
    action(controls, *(message[name] for name in fields))
