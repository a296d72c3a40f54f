"""Words above a picture, where there is no room in it."""

from __future__ import annotations

from collections.abc import Sequence

from vidstyle.comic.bubble import Bubble, size_of
from vidstyle.comic.font import Letters
from vidstyle.comic.moment import Box
from vidstyle.comic.paper import Rectangle
from vidstyle.comic.subtitles import Line
from vidstyle.comic.wrap import Block, shapes

_APART = 0.3
"""How much nearer to one another bands are than they need be, in sizes of the letters."""


def bands(lines: Sequence[Line], inside: Rectangle, letters: Letters, size: int) -> list[Bubble] | None:
    """The lines one below the other at the top of a panel; None if a word is too wide for it.

    Args:
        size: of the letters, in pixels.
    """
    found, top = list[Bubble](), inside.top
    for line in lines:
        block = _flattest(letters, line.text, size, inside.width - round(1.2 * size))
        if block is None:
            return None
        _, height = size_of("band", block)
        found.append(Bubble("band", Box(inside.left, top, inside.right, top + height), block))
        top += round(height - _APART * size)
    return found


def below_bands(found: Sequence[Bubble], inside: Rectangle, border: int) -> Rectangle:
    """What they and a border leave of the panel."""
    return inside._replace(top=round(found[-1].box.bottom) + border)


def _flattest(letters: Letters, text: str, size: int, widest: int) -> Block | None:
    tried = shapes(letters, letters.writable(text), size, widest) if widest > 0 else []
    return min(tried, key=lambda block: len(block.lines), default=None)
