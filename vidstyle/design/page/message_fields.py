"""The schema of the messages from the page: the fields of each message and their checks."""

from __future__ import annotations

from vidstyle.web.messages import Fields, is_bool, is_index, is_text

MAX_NOTE = 4000
"""Maximum length of a note in characters."""
MAX_STYLE_TEXT = 60_000
"""Maximum length of a style text in characters; smaller than the maximum message."""
MAX_UPLOAD = 2 << 30
"""Maximum size of an upload in bytes."""
PREVIEW_SIDE_RANGE = (64, 2160)
"""Minimum and maximum shorter side of the preview in pixels."""


def is_value(value: object) -> bool:
    """Whether it is a string, a number or a boolean; the parameter checks its range later."""
    return isinstance(value, str | int | float) and (not isinstance(value, str) or len(value) <= 200)


def _is_value_or_none(value: object) -> bool:
    return value is None or is_value(value)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 2**53


def _is_number_or_none(value: object) -> bool:
    return value is None or is_index(value)


def _is_line(value: object) -> bool:
    """Whether it is a string, possibly empty."""
    return value == "" or is_text(value)


def _is_note(value: object) -> bool:
    return isinstance(value, str) and len(value) <= MAX_NOTE


def _is_style_text(value: object) -> bool:
    return isinstance(value, str) and len(value) <= MAX_STYLE_TEXT


def _is_side(value: object) -> bool:
    return is_index(value) and PREVIEW_SIDE_RANGE[0] <= int(str(value)) <= PREVIEW_SIDE_RANGE[1]


def _is_rate(value: object) -> bool:
    return _is_number(value) and 0.1 <= float(str(value)) <= 240


def _is_size(value: object) -> bool:
    return is_index(value) and 0 < int(str(value)) <= MAX_UPLOAD


def _is_slot(value: object) -> bool:
    return value in ("a", "b")


def _is_place(value: object) -> bool:
    return value in ("page", "server")


def _is_export(value: object) -> bool:
    return value in ("html", "hook")


EDIT_FIELDS: dict[str, Fields] = {
    "add": {"layer": is_text, "index": is_index, "block": _is_line},
    "move": {"step": is_index, "layer": is_text, "index": is_index},
    "remove": {"step": is_index},
    "duplicate": {"step": is_index},
    "set": {"step": is_index, "name": is_text, "value": is_value},
    "field": {"name": is_text, "value": _is_value_or_none},
    "refer": {"step": is_index, "name": is_text, "value": _is_line},
    "mute": {"step": is_index, "on": is_bool},
    "expand": {"step": is_index},
    "knob": {"step": _is_number_or_none, "name": is_text, "on": is_bool},
    "variant": {"name": is_text},
    "strength": {"value": _is_number},
    "rename": {"name": is_text},
    "note": {"text": _is_note},
}
"""The fields of each edit, except `gesture`."""

_OTHER_FIELDS: dict[str, Fields] = {
    "undo": {},
    "redo": {},
    "jump": {"entry": is_index},
    "snapshot": {"slot": _is_slot},
    "restore": {"slot": _is_slot},
    "new": {},
    "open": {"style": is_text},
    "open_text": {"name": is_text, "text": _is_style_text},
    "save": {},
    "save_as": {"name": is_text, "overwrite": is_bool},
    "draft": {"accept": is_bool},
    "command": {},
    "watch": {"solo": _is_number_or_none, "side": _is_side, "where": _is_place},
    "frame": {"number": is_index},
    "play": {"at": is_index, "from": is_index, "to": is_index, "fps": _is_rate},
    "pause": {},
    "thumbnails": {},
    "start": {},
    "check": {},
    "steady": {},
    "export": {"kind": _is_export, "name": is_text, "overwrite": is_bool},
    "render": {"name": is_text, "overwrite": is_bool, "frames": _is_number_or_none},
    "cancel": {},
    "upload": {"name": is_text, "size": _is_size},
}

MESSAGE_FIELDS: dict[str, Fields] = {
    kind: {"id": is_index, **fields}
    for kind, fields in (
        *((kind, {**fields, "gesture": is_index}) for kind, fields in EDIT_FIELDS.items()),
        *_OTHER_FIELDS.items(),
    )
}
"""The fields of all messages; the answer to a message repeats its `id`."""
