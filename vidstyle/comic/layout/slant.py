"""Slanted gutters: the gap between panels side by side leans, which makes a page more dynamic."""

from __future__ import annotations

from collections.abc import Sequence

from vidstyle.comic.layout.paper import Paper
from vidstyle.regions.boxes import Box, Rectangle

Leans = tuple[int, int]
"""Horizontal offset of the top ends of a panel's left and right edge from their middles, to the right, in
pixels; the bottom ends are shifted to the left by the same distance."""

_LEAN_HEIGHT_RATIO, _MAX_LEAN_WIDTH_RATIO = 0.055, 0.1
"""Lean of a gutter relative to its height, and maximum relative to the narrower of its two panels."""


def slant_gutters(
    placed: Sequence[tuple[int, Rectangle]], paper: Paper, seed: int
) -> list[tuple[int, Rectangle, Leans]]:
    """Slant the gutters of rows without stacks, to either side in turn.

    Args:
        placed: page and rectangle of each panel.
        paper: of each page.
        seed: an odd one begins with the other side.

    Returns:
        Page, bounding box and leans of each panel.
    """
    leans = [[0, 0] for _ in placed]
    side = -1 if seed % 2 else 1
    by_row: dict[tuple[int, int, int], list[int]] = {}
    for number, (page, each) in enumerate(placed):
        by_row.setdefault((page, each.top, each.bottom), []).append(number)
    for _, row in sorted(by_row.items()):
        across = sorted(row, key=lambda number: placed[number][1].left)
        for number, after in zip(across, across[1:], strict=False):
            left, right = placed[number][1], placed[after][1]
            if right.left - left.right == paper.gutter:
                most = _MAX_LEAN_WIDTH_RATIO * min(left.width, right.width)
                lean = side * round(min(_LEAN_HEIGHT_RATIO * left.height, most))
                leans[number][1] = leans[after][0] = lean
        side = -side if any(leans[number] != [0, 0] for number in row) else side
    return [
        (page, each._replace(left=each.left - abs(left), right=each.right + abs(right)), (left, right))
        for (page, each), (left, right) in zip(placed, leans, strict=True)
    ]


def corners(box: Box, leans: Leans) -> list[tuple[float, float]]:
    """Return the corners of a panel in a bounding box, clockwise from the upper left."""
    left, right = box.left + abs(leans[0]), box.right - abs(leans[1])
    return [
        (left + leans[0], box.top),
        (right + leans[1], box.top),
        (right - leans[1], box.bottom),
        (left - leans[0], box.bottom),
    ]


def upright_area(box: Box, leans: Leans) -> Box:
    """Return the largest part of a bounding box with vertical edges that is inside its panel."""
    return Box(box.left + 2 * abs(leans[0]), box.top, box.right - 2 * abs(leans[1]), box.bottom)
