"""The words by which a search finds a look, besides its name, its aliases and its description."""

from __future__ import annotations

from collections.abc import Iterator

from vidstyle.blocks import all_blocks
from vidstyle.style.model import Style
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
