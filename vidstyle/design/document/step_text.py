"""Steps as text: copied from one style and pasted into another one, in this or another designer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from vidstyle.core.file_checks import parse_toml
from vidstyle.design.document.content import Content
from vidstyle.errors import UsageError
from vidstyle.style import LAYERS
from vidstyle.style.check import StepReader
from vidstyle.style.edit import new_text
from vidstyle.style.files import MAX_FILE

CLIPBOARD = "the clipboard"
"""The subject of errors."""


def text_of_step(content: Content, step: int, whole: bool) -> str:
    """Return a step as in a style file.

    Args:
        step: its number.
        whole: whether to return all steps of its layer.
    """
    layer, _, placed = content.place_of(step)
    steps = content.layers[layer] if whole else (placed,)
    return new_text({layer: [dict(each.table) for each in steps]})


def steps_in_text(content: Content, text: str) -> list[dict[str, Any]]:
    """Return the tables of the steps in a text, such as a part of a style file, in running order.

    A step does not save its output if a step of the style already saves one under this name.

    Raises:
        UsageError: there are no steps in it, or they have mistakes.
    """
    steps = list(_steps_in(text))
    if not steps:
        raise UsageError(CLIPBOARD, "holds no steps of a style", "copy a step first")
    mistakes: list[str] = []
    reader = StepReader(None, mistakes)
    for layer, table in steps:
        reader.read_step(layer, 1, table)
    if mistakes:
        raise UsageError(CLIPBOARD, f"holds a mistake: {mistakes[0]}")
    taken = {step.table.get("save") for _, _, step in content.steps}
    return [
        {key: value for key, value in table.items() if key != "save" or value not in taken}
        for _, table in steps
    ]


def _steps_in(text: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    try:
        table = parse_toml(text) if len(text) <= MAX_FILE else {}
    except ValueError:
        return
    for layer in LAYERS:
        found = table.get(layer, [])
        for step in found if isinstance(found, list) else []:
            if isinstance(step, Mapping):
                yield layer, step
