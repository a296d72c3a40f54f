"""The schema and the actions of the messages from the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from vidstyle.live.control import Controls
from vidstyle.web.messages import Fields, is_bool, is_index, is_text

MAX_VALUES = 200


def _are_values(value: object) -> bool:
    """Whether it is an object of strings, numbers and booleans; parameters check their ranges later."""
    return (
        isinstance(value, dict)
        and 0 < len(value) <= MAX_VALUES
        and all(is_text(path) and isinstance(each, str | int | float) for path, each in value.items())
    )


_MESSAGE_KINDS: dict[str, tuple[Callable[..., None] | None, Fields]] = {
    "shown": (None, {"number": is_index}),
    "set": (Controls.set_values, {"values": _are_values}),
    "choose": (Controls.choose, {"style": is_text}),
    "next": (Controls.next_style, {}),
    "bypass": (Controls.bypass, {"on": is_bool}),
    "record": (Controls.record, {"on": is_bool}),
    "quit": (Controls.quit, {}),
}
"""The action of each message except "shown", and its fields, which are the arguments."""

MESSAGE_FIELDS = {kind: fields for kind, (_, fields) in _MESSAGE_KINDS.items()}
"""The fields of all messages."""


def dispatch(message: dict[str, Any], controls: Controls) -> None:
    """Apply a message other than "shown" to the session.

    Raises:
        VidstyleError: unknown style, variant or parameter, or an invalid value.
    """
    action, fields = _MESSAGE_KINDS[message["do"]]
    assert action is not None
    action(controls, *(message[name] for name in fields))
