"""The schema of the messages from the page, and the methods that they call."""

from __future__ import annotations

from vidstyle.explore.generate import LOCKS
from vidstyle.explore.page import outputs
from vidstyle.explore.page.pictures import PICTURE_SIDES_PX
from vidstyle.web.messages import Fields, is_bool, is_index, is_part, is_text


def _is_side(value: object) -> bool:
    return value in PICTURE_SIDES_PX


def _is_lock(value: object) -> bool:
    return value in LOCKS


def _is_kind(value: object) -> bool:
    return value in outputs.EXPORT_KINDS


TILE_FIELD: Fields = {"tile": is_index}
POINT_FIELDS: Fields = {"tile": is_index, "x": is_part, "y": is_part}
MESSAGE_FIELDS: dict[str, Fields] = {
    kind: {"id": is_index, **fields}
    for kind, fields in {
        "like": TILE_FIELD,
        "again": {},
        "fresh": {},
        "back": {},
        "forward": {},
        "jump": {"screen": is_index},
        "near": {"part": is_part},
        "lock": {"name": _is_lock, "on": is_bool},
        "star": {"tile": is_index, "on": is_bool},
        "move": {"part": is_part},
        "plan": {"tile": is_index, "side": _is_side, "whole": is_bool},
        "pad": TILE_FIELD,
        "tune": {**POINT_FIELDS, "side": _is_side, "whole": is_bool},
        "keep": POINT_FIELDS,
        "save": {"tile": is_index, "name": is_text, "overwrite": is_bool},
        "export": {"tile": is_index, "name": is_text, "kind": _is_kind},
        "render": {"tile": is_index, "name": is_text},
        "cancel": {},
        "design": TILE_FIELD,
    }.items()
}
"""The fields of all messages; the answer to a message repeats its `id`."""

ACTIONS = {
    "like": "more_like",
    "again": "again",
    "fresh": "new_screen",
    "back": "back",
    "forward": "forward",
    "jump": "jump",
    "near": "set_near",
    "lock": "lock",
    "star": "star",
    "move": "move_to",
    "keep": "tuned",
}
"""The methods of `Exploration` that messages call; all browsers get the new state afterwards."""
