"""What a search of looks knows of a style."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError
from vidstyle.style.model import KINDS, Style
from vidstyle.style.wiring import main_path

_LOOK_CATEGORIES = ("lines", "paint", "print", "texture", "color")
"""Categories of blocks whose aliases describe a whole look."""


def search_words(style: Style) -> Iterator[str]:
    """Yield the variants of a style, and the aliases of the blocks that its result depends on."""
    path = main_path(style.layers, style.masks)
    yield from style.variants
    for block in dict.fromkeys(step.block for index, step in enumerate(style.steps) if index in path):
        if block and all_blocks()[block].category in _LOOK_CATEGORIES:
            yield from all_blocks()[block].aliases


def describe_look(name: str, load: Callable[[], Style]) -> dict[str, Any]:
    """Return the name of a style, its description or mistake, its kinds, aliases and words, for a page."""
    try:
        style = load()
    except StyleError as error:
        return {"name": name, "note": str(error), "kinds": [], "aliases": "", "words": ""}
    kinds = [KINDS[kind] for kind in style.kinds]
    words = ", ".join(search_words(style))
    return {"name": name, "note": style.about, "kinds": kinds, "aliases": style.aliases, "words": words}
