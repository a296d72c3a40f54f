"""The edits of a style: pure functions that return new content.

An edit with invalid arguments is refused. An edit that makes the style invalid, such as by removing a picture
that another step reads, is accepted; the document then lists the mistakes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from vidstyle.design.document import step_edits, style_edits
from vidstyle.design.document.edit_values import EditResult

EDITS: Mapping[str, Callable[..., EditResult]] = {
    "add": step_edits.add,
    "show_behind_lines": step_edits.show_behind_lines,
    "move": step_edits.move,
    "remove": step_edits.remove,
    "duplicate": step_edits.duplicate,
    "paste": step_edits.paste,
    "set": step_edits.set_value,
    "field": style_edits.set_field,
    "refer": step_edits.refer,
    "mute": step_edits.mute,
    "expand": step_edits.expand,
    "knob": style_edits.knob,
    "label": style_edits.label,
    "variant": style_edits.variant,
    "rename": style_edits.rename,
    "note": style_edits.note,
}
"""All edits by name. Each is a message of the page, whose fields are the parameters after `new`."""
