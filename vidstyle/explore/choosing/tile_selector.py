"""Selects the tiles of a screen from rendered candidates, by preference, novelty and distance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.blocks import all_blocks
from vidstyle.explore.choosing.tile_screen import CHOSEN_KIND, NEAR_KINDS, Tile
from vidstyle.explore.look import Look, nearest, nearest_appearance

MIN_TILE_DISTANCE = 0.3
"""Minimum `look_distance` between two tiles of a screen: the difference is visible."""
MIN_LOOK_DISTANCE = 1.0
"""Appearance distance from which two tiles are different looks: usual between two pictures in one style."""
MIN_FIRST_LOOKS, MIN_LOOKS = 7, 5
"""Different looks on a first and on other screens, for which a second round of candidates is tried."""
NOVELTY_WEIGHT = 0.5
"""Weight of the appearance distance to tiles already selected, relative to predicted preference."""
MAX_NOVELTY_DISTANCE = 2.0
"""Appearance distance above which novelty does not increase."""
MIN_REACH_DISTANCE, REACH_DISTANCE_RANGE = 0.2, 1.5
"""Appearance distance from the chosen tile that tiles with other values should have: for `near` = 0, and what
`near` = 1 adds."""
MAX_REACH_RATIO = 2.0
"""Multiple of this distance beyond which a tile is no longer near the chosen one."""
MAX_EQUAL_RASTERS = 2
"""Maximum number of tiles of a first screen with the raster of one block, if enough others pass: dots, lines
and squares that fill the picture are seen before anything else of a look."""
WILD_LIKING_WEIGHT = 0.6
"""Weight of the predicted preference for wild cards on a screen with a chosen tile, to surprise."""


@dataclass(frozen=True)
class TileSelector:
    """Selects tiles that differ from one another.

    Attributes:
        utility: returns the predicted preference for looks, between -1 and 1.
        near: distance of tiles with other values from the chosen one, from 0 (similar) to 1 (different).
    """

    utility: Callable[[Sequence[Look]], np.ndarray]
    near: float

    def select(self, wanted: Counter[str], tiles: Sequence[Tile], found: Sequence[Tile]) -> list[Tile]:
        """Select distinct tiles of the wanted kinds, then of any kind; different looks first.

        Tiles near the chosen one are different looks, too, as long as `near` reaches that far.

        Args:
            tiles: tiles that are already selected, the chosen one first.
            found: the tiles to select from.

        Returns:
            The wanted number of tiles, or fewer if the others are too similar.
        """
        chosen: list[Tile] = []
        left = list(found)
        kinds, any_kind, is_first = list(wanted.elements()), [""] * wanted.total(), not tiles
        turns = [(kind, MIN_LOOK_DISTANCE, is_first) for kind in kinds]
        turns += [(kind, 0.0, is_first) for kind in kinds if kind in NEAR_KINDS]
        turns += [(kind, MIN_LOOK_DISTANCE, is_first) for kind in any_kind]
        turns += [(kind, 0.0, is_limited) for is_limited in (is_first, False) for kind in any_kind]
        for kind, least, is_limited in turns:
            if len(chosen) == wanted.total():
                break
            if kind and sum(each.kind == kind for each in chosen) == wanted[kind]:
                continue
            of_kind = [each for each in left if kind in ("", each.kind) and not _is_near_same(each, chosen)]
            if is_limited:
                of_kind = [each for each in of_kind if not _has_frequent_raster(each, chosen)]
            best = self._best(of_kind, kind, [*tiles, *chosen], least) if of_kind else None
            if best is not None:
                chosen.append(best)
                left.remove(best)
        return chosen

    def _best(self, found: Sequence[Tile], kind: str, taken: Sequence[Tile], least: float) -> Tile | None:
        """Return the best of `found` for a kind of tile; None if all are similar to `taken`.

        Args:
            least: the minimum appearance distance.
        """
        looks, others = ([each.look for each in some] for some in (found, taken))
        apart = nearest_appearance(looks, others)
        is_apart = (apart >= least) & (nearest(looks, others) >= MIN_TILE_DISTANCE)
        novelty = np.minimum(apart, MAX_NOVELTY_DISTANCE)
        if kind in NEAR_KINDS:
            reach = MIN_REACH_DISTANCE + REACH_DISTANCE_RANGE * self.near
            ratio = nearest_appearance(looks, others[:1]) / reach
            is_apart, novelty = is_apart & (ratio <= MAX_REACH_RATIO), -np.abs(ratio - 1)
        is_unexpected = kind == "wild" and any(tile.kind == CHOSEN_KIND for tile in taken)
        liking = WILD_LIKING_WEIGHT if is_unexpected else 1.0
        worth = liking * self.utility(looks) + NOVELTY_WEIGHT * novelty
        return found[int(np.argmax(np.where(is_apart, worth, -np.inf)))] if is_apart.any() else None


def sort_by_novelty(candidates: Sequence[Tile], taken: Sequence[Tile]) -> list[Tile]:
    """Sort candidates so that each is farthest from `taken` and from all before it."""
    left, chosen = list(candidates), list[Tile]()
    while left:
        apart = nearest([each.look for each in left], [each.look for each in [*taken, *chosen]])
        chosen.append(left.pop(int(np.argmax(apart))))
    return chosen


def is_distinct(tile: Tile, others: Sequence[Tile]) -> bool:
    """Whether a tile is visibly different from all others."""
    return float(nearest([tile.look], [each.look for each in others])[0]) >= MIN_TILE_DISTANCE


def is_varied(tiles: Sequence[Tile]) -> bool:
    """Whether a screen has enough different looks."""
    looks: list[Look] = []
    for tile in tiles:
        if nearest_appearance([tile.look], looks)[0] >= MIN_LOOK_DISTANCE:
            looks.append(tile.look)
    return len(looks) >= (MIN_LOOKS if any(tile.kind == CHOSEN_KIND for tile in tiles) else MIN_FIRST_LOOKS)


def _is_near_same(tile: Tile, others: Sequence[Tile]) -> bool:
    """Whether a tile is near the same shipped style as one of the others."""
    return tile.kind == "shipped" and any(each.parents == tile.parents for each in others)


def _has_frequent_raster(tile: Tile, others: Sequence[Tile]) -> bool:
    """Whether enough of the others have the raster of one of its blocks."""
    counts = Counter(block for each in others for block in _raster_blocks(each))
    return any(counts[block] >= MAX_EQUAL_RASTERS for block in _raster_blocks(tile))


def _raster_blocks(tile: Tile) -> set[str]:
    blocks = {step.block for step in tile.style.steps if step.block and not step.mute}
    return {name for name in blocks if all_blocks()[name].raster is not None}
