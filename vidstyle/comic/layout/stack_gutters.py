"""Gutters next to stacks: as wide as the gutters inside them, so that a stack is read to its end first."""

from __future__ import annotations

from collections.abc import Sequence

from vidstyle.comic.layout.paper import Paper
from vidstyle.regions.boxes import Rectangle


def widen_stack_gutters(placed: Sequence[tuple[int, Rectangle]], paper: Paper) -> list[tuple[int, Rectangle]]:
    """Return page and rectangle of each panel, narrowed next to a stack and in it.

    Args:
        placed: page and rectangle of each panel; those next to each other are `paper.gutter` apart.
        paper: of each page.
    """
    extra = paper.row_gutter - paper.gutter
    found = []
    for page, each in placed:
        others = [other for at, other in placed if at == page]
        is_before = any(_is_stack_gutter(each, other, paper) for other in others)
        is_after = any(_is_stack_gutter(other, each, paper) for other in others)
        left = each.left + is_after * (extra // 2)
        right = each.right - is_before * (extra - extra // 2)
        found.append((page, each._replace(left=left, right=right)))
    return found


def _is_stack_gutter(left: Rectangle, right: Rectangle, paper: Paper) -> bool:
    """Whether two panels are next to each other and one of them is part of a stack."""
    is_in_row = left.top < right.bottom and right.top < left.bottom
    is_stack = (left.top, left.bottom) != (right.top, right.bottom)
    return right.left - left.right == paper.gutter and is_in_row and is_stack
