"""How a text is broken into lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from vidstyle.comic.lettering.fonts import Letters

LINE = 1.2
"""From one line to the next, in sizes of the letters."""

_SHAPES = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 19, 24, 30)
"""Numbers of lines that are tried."""
_WIDE = r"[\u2e80-\u9fff\uac00-\ud7af\uf900-\ufaff\uff00-\uffef]"
"""Letters between which a line may break."""
_PIECE = re.compile(rf"(\s*)({_WIDE}|(?:(?!{_WIDE})\S)+)")


@dataclass(frozen=True)
class TextBlock:
    """A text in lines; `size` is that of its letters, all lengths in pixels."""

    lines: tuple[str, ...]
    widths: tuple[float, ...]
    size: int

    @cached_property
    def width(self) -> float:
        """Of the longest line."""
        return max(self.widths)

    @cached_property
    def height(self) -> float:
        """From the top of the first line's letters to the foot of the last one's."""
        return self.size * (LINE * (len(self.lines) - 1) + 1)


def shapes(letters: Letters, text: str, size: int, widest: float) -> list[TextBlock]:
    """The text broken into few lines and into many, none wider than `widest`; none if that cannot be.

    In each, the lines are as even as their number allows.
    """
    pieces = list(_pieces(letters, text, size, widest))
    blocks: dict[int, TextBlock] = {}
    for count in _SHAPES:
        lines = _narrowest(pieces, count, widest)
        if lines is not None and len(lines) not in blocks:
            texts = tuple("".join(part for part, _ in line).strip() for line in lines)
            blocks[len(lines)] = TextBlock(texts, tuple(letters.width(each, size) for each in texts), size)
    return [block for block in blocks.values() if block.width <= widest]


def _pieces(letters: Letters, text: str, size: int, widest: float) -> Iterator[tuple[str, float]]:
    """What is not broken, with the space before it, and its width; a word that is too wide is broken."""
    for space, word in _PIECE.findall(text):
        while len(word) > 1 and letters.width(word, size) > widest:
            count = next(
                n for n in range(len(word) - 1, 0, -1) if n == 1 or letters.width(word[:n], size) <= widest
            )
            yield space + word[:count], letters.width(space + word[:count], size)
            space, word = "", word[count:]
        yield space + word, letters.width(space + word, size)


def _narrowest(
    pieces: list[tuple[str, float]], count: int, widest: float
) -> list[list[tuple[str, float]]] | None:
    """The pieces in at most so many lines that are as narrow as can be."""
    low, high = max(width for _, width in pieces), widest
    best = _filled(pieces, high)
    if len(best) > count:
        return None
    for _ in range(12):
        middle = (low + high) / 2
        tried = _filled(pieces, middle)
        if len(tried) <= count:
            best, high = tried, middle
        else:
            low = middle
    return best


def _filled(pieces: list[tuple[str, float]], width: float) -> list[list[tuple[str, float]]]:
    lines: list[list[tuple[str, float]]] = []
    used = 0.0
    for piece in pieces:
        if not lines or used + piece[1] > width:
            lines.append([])
            used = 0.0
        lines[-1].append(piece)
        used += piece[1]
    return lines
