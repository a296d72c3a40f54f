"""Tiles, the screens that they form, and the kinds of tiles at each position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vidstyle.explore.look import Look
from vidstyle.style import Style

CHOSEN_KIND = "chosen"
SCREEN_KINDS = ("step", "values", "cross", "values", CHOSEN_KIND, "values", "wild", "values", "step")
"""How each tile of a screen is derived from the chosen tile, row by row."""
FIRST_SCREEN_KINDS = ("shipped", "wild", "shipped", "wild", "wild", "wild", "shipped", "wild", "shipped")
"""The same for a first screen."""
NEAR_KINDS = ("values",)
"""The kinds of tiles that resemble the chosen one; all others are different looks if enough pass."""


@dataclass(frozen=True, eq=False)
class Tile:
    """A style on a screen.

    Attributes:
        kind: how it was generated: "chosen", "values", "step", "cross", "wild", "shipped" or "match".
        parents: the names of the styles that it is derived from.
        likeness: the distance to a reference picture in words, or "".
    """

    style: Style
    kind: str
    look: Look
    parents: tuple[str, ...] = ()
    likeness: str = ""


@dataclass(eq=False)
class TileScreen:
    """Nine tiles.

    Attributes:
        tiles: row by row.
        before: the number of the screen that led to this one, or None.
        taken: the position of the tile chosen last, or None.
        after: the number of the next screen, or None.
    """

    tiles: tuple[Tile, ...]
    before: int | None = None
    taken: int | None = None
    after: int | None = None


def arrange(kinds: Sequence[str], tiles: Sequence[Tile]) -> tuple[Tile, ...]:
    """Place tiles at the positions for their kinds, and the others at the remaining positions."""
    left = list(tiles)
    placed: list[Tile | None] = []
    for kind in kinds:
        found = next((tile for tile in left if tile.kind == kind), None)
        placed.append(found)
        if found is not None:
            left.remove(found)
    return tuple(tile or left.pop(0) for tile in placed)
