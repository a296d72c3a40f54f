"""Messages of the pages: Python declares them, JavaScript sends exactly these."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from vidstyle.design.page import design_server
from vidstyle.design.page.design_connection import DesignConnection
from vidstyle.explore.page import explore_server
from vidstyle.explore.page.explore_server import ExploreConnection
from vidstyle.export import SCRIPT_FOLDERS
from vidstyle.live.page import page_target
from vidstyle.live.page.viewer import Viewer
from vidstyle.web.messages import CHECKS, Message, MessageError, message, read_message
from vidstyle.web.server import SHARED_FOLDER

PAGES = {
    "designer": (design_server.STATIC_FOLDER, "app.js", DesignConnection),
    "explorer": (explore_server.STATIC_FOLDER, "explore.js", ExploreConnection),
    "live": (page_target.STATIC_FOLDER, "page.js", Viewer),
}
ADDED_FIELDS = {"edit": {"gesture"}, "#write": {"overwrite"}}
"""Functions of JavaScript that add fields to the messages that they send."""
SENDER = r"(?<!\w)(ask|attempt|edit|open|again|send|choose|#write|#?newest)"
CALL = re.compile(SENDER + r'\(\s*(?:[\w.]+, )?"([a-z_]+)"(\)|, \{[^{}]*\}\))?')
"""A call that sends a message: the function, the name, and the fields if they are all listed."""


def scripts_of(folder: Path, name: str) -> dict[str, str]:
    """The modules of a page by name: the first, and all that they import."""
    found: dict[str, str] = {}
    wanted = [name]
    while wanted:
        name = wanted.pop()
        if name not in found:
            path = next(
                each / name for each in (folder, SHARED_FOLDER, *SCRIPT_FOLDERS) if (each / name).exists()
            )
            found[name] = path.read_text(encoding="utf-8")
            wanted += re.findall(r'^(?:import|export) [^;]*? ?from "\./([\w.]+)";', found[name], re.M)
    return found


def sent(text: str) -> Iterator[tuple[str, set[str] | None]]:
    """The messages that a script sends: the name, and the fields, or None if they are not all listed."""
    for function, name, fields in CALL.findall(text):
        is_listed = fields and "..." not in fields
        listed = {"id", *re.findall(r"[{,]\s*(\w+)", fields)} | ADDED_FIELDS.get(function, set())
        yield name, listed if is_listed else None


@pytest.mark.parametrize("page", PAGES)
def test_a_page_sends_the_messages_that_its_connection_declares(page: str) -> None:
    folder, index, connection = PAGES[page]
    scripts = scripts_of(folder, index)
    # Shared modules may send messages that this page has no use for.
    own = {name for name in scripts if (folder / name).exists()}
    found = [
        (name, fields)
        for script, text in scripts.items()
        for name, fields in sent(text)
        if script in own or name in connection.messages
    ]
    assert {name for name, _ in found} == connection.messages.keys()
    assert sum(fields is not None for _, fields in found) > len(connection.messages) / 2
    for name, fields in found:
        assert fields is None or fields == {"id", *connection.messages[name].fields}, name


class TestDeclaration:
    """A method declares the message of its name."""

    @message(in_background=True)
    async def turn(self, angle: float, on: bool, name: str | None) -> None: ...

    def test_the_signature_is_the_schema(self) -> None:
        kinds: Mapping[str, Message] = {"turn": TestDeclaration.turn}
        text = '{"do": "turn", "id": 7, "angle": 0.5, "on": true, "name": null}'
        kind, id, fields = read_message(text, kinds)
        assert (id, fields) == (7, {"angle": 0.5, "on": True, "name": None}) and kind.in_background

    @pytest.mark.parametrize(
        ("field", "value"), [("angle", "true"), ("angle", "NaN"), ("on", "1"), ("name", '""'), ("more", "1"),
                             ("id", "-1"), ("id", "null"), ("do", '"none"')],
    )  # fmt: skip
    def test_other_types_and_fields_are_refused(self, field: str, value: str) -> None:
        fields = {"do": '"turn"', "id": "7", "angle": "0", "on": "true", "name": '"a"'}
        text = ", ".join(f'"{name}": {each}' for name, each in {**fields, field: value}.items())
        with pytest.raises(MessageError):
            read_message(f"{{{text}}}", {"turn": TestDeclaration.turn})

    def test_a_type_without_a_check_cannot_be_declared(self) -> None:
        async def wrong(self: Any, value: dict[str, int]) -> None: ...

        with pytest.raises(KeyError):
            message(wrong)
        assert float in CHECKS
