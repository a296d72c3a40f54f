"""Interactive search for a style: screens of nine tiles, each derived from the tile chosen before."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vidstyle.explore.generate import alter, cross, mutate, random_style
from vidstyle.explore.look import Look, NewLooks, nearest, nearest_appearance
from vidstyle.explore.taste import Taste
from vidstyle.style import Style

CHOSEN_KIND = "chosen"
SCREEN_KINDS = ("step", "values", "cross", "values", CHOSEN_KIND, "values", "wild", "values", "step")
"""How each tile of a screen is derived from the chosen tile, row by row."""
FIRST_SCREEN_KINDS = ("shipped", "wild", "shipped", "wild", "wild", "wild", "shipped", "wild", "shipped")
"""The same for a first screen."""
CANDIDATE_COUNTS = {"values": 10, "step": 8, "cross": 4, "wild": 4, "shipped": 12}
"""Number of candidates of each kind from which the tiles of a screen are selected."""
MAX_ROUNDS = 4
"""Maximum number of rounds of candidates if too few pass."""
MIN_TILE_DISTANCE = 0.3
"""Minimum `look_distance` between two tiles of a screen: the difference is visible."""
MIN_LOOK_DISTANCE = 1.0
"""Appearance distance from which two tiles are different looks: usual between two pictures in one style."""
NEAR_KINDS = ("values",)
"""The kinds of tiles that resemble the chosen one; all others are different looks if enough pass."""
MIN_FIRST_LOOKS, MIN_LOOKS = 7, 5
"""Different looks on a first and on other screens, for which a second round of candidates is tried."""
FIRST_MUTATION_DISTANCE, WILD_MUTATION_DISTANCE = 0.25, 0.6
"""Distance of mutants from shipped styles: on a first screen, and for wild cards."""
NOVELTY_WEIGHT = 0.5
"""Weight of the appearance distance to tiles already selected, relative to predicted preference."""
MAX_NOVELTY_DISTANCE = 2.0
"""Appearance distance above which novelty does not increase."""
MIN_REACH_DISTANCE, REACH_DISTANCE_RANGE = 0.2, 1.5
"""Appearance distance from the chosen tile that tiles with other values should have: for `near` = 0, and what
`near` = 1 adds."""
MAX_REACH_RATIO = 2.0
"""Multiple of this distance beyond which a tile is no longer near the chosen one."""
MIN_MUTATION_DISTANCE = 0.1
"""Distance of mutants below which few differences are visible."""
REPEAT_DISTANCE_FACTOR = 0.7
"""Factor of distances each time the same tile is chosen again, since no other was better."""
UTILITY_RANGE = 4.0
"""Utility above the mean at which the predicted preference saturates."""


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


@dataclass(frozen=True)
class Proposal:
    """A candidate that is not rendered yet."""

    style: Style
    kind: str
    parents: tuple[str, ...] = ()


@dataclass
class Chooser:
    """Screens, choices, and the taste learned from them.

    The same seed and choices give the same screens.

    Attributes:
        looks: renders styles.
        shipped: known good styles, the basis of the first screen.
        near: distance of new tiles from the chosen one, from 0 (similar) to 1 (different).
        locks: parts of the chosen tile to keep, of `LOCKS`.
        screens: all screens in chronological order.
        at: the number of the current screen.
        stars: the kept tiles.
    """

    looks: NewLooks
    shipped: Sequence[Style]
    seed: int = 0
    near: float = 0.4
    locks: frozenset[str] = frozenset()
    screens: list[TileScreen] = field(default_factory=list)
    at: int = -1
    stars: list[Tile] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._taste: Taste | None = None
        self._favourites: list[Tile] = []

    @property
    def screen(self) -> TileScreen:
        """The current screen."""
        return self.screens[self.at]

    def new_screen(self) -> TileScreen:
        """Show nine new tiles: mutants of shipped styles, and wild cards."""
        return self._show(self._fill(FIRST_SCREEN_KINDS, [], self._first_draws), None)

    def show_matches(self, styles: Sequence[tuple[Style, str]]) -> TileScreen:
        """Show the first nine styles that differ, most like a reference picture first.

        Args:
            styles: at least nine, with their likeness in words.
        """
        looks = self.looks([style for style, _ in styles])
        found = [
            Tile(style, "match", look, (), words)
            for (style, words), look in zip(styles, looks, strict=True)
            if look is not None
        ]
        chosen: list[Tile] = []
        for tile in found:
            if _is_apart(tile, chosen) and len(chosen) < len(SCREEN_KINDS):
                chosen.append(tile)
        chosen += [tile for tile in found if tile not in chosen]
        return self._show(tuple(chosen[: len(SCREEN_KINDS)]), None)

    def more_like(self, place: int) -> TileScreen:
        """Choose a tile of the screen, and show similar ones."""
        self._learn(place)
        taken = self.screen.tiles[place]
        self.screen.taken = place
        if taken not in self._favourites:
            self._favourites.append(taken)
        return self.again(taken)

    def again(self, taken: Tile | None = None) -> TileScreen:
        """Show more tiles like `taken`, by default the one in the middle."""
        middle = replace(taken or self.screen.tiles[len(SCREEN_KINDS) // 2], kind=CHOSEN_KIND)
        tiles = self._fill(SCREEN_KINDS, [middle], lambda number: self._draws(middle, number))
        return self._show(tiles, self.at)

    def likely_styles(self, place: int) -> list[Style]:
        """Return the styles that `more_like` tries first for this position."""
        return [each.style for each in self._draws(self.screen.tiles[place], 0)]

    def by_liking(self) -> list[int]:
        """Return the positions of the screen, the most likely choice first."""
        utility = self._utility([tile.look for tile in self.screen.tiles])
        return [int(place) for place in np.argsort(-utility, kind="stable")]

    def back(self) -> None:
        """Show the previous screen, if any."""
        if self.screen.before is not None:
            self.screens[self.screen.before].after = self.at
            self.at = self.screen.before

    def forward(self) -> None:
        """Show the next screen again after `back`, if any."""
        if self.screen.after is not None:
            self.at = self.screen.after

    def star(self, tile: Tile, on: bool) -> None:
        """Keep a tile, or stop keeping it; kept tiles are used for crossing."""
        self.stars = [each for each in self.stars if each is not tile] + [tile] * on

    def _show(self, tiles: tuple[Tile, ...], before: int | None) -> TileScreen:
        self.screens.append(TileScreen(tiles, before))
        if before is not None:
            self.screens[before].after = len(self.screens) - 1
        self.at = len(self.screens) - 1
        return self.screen

    # Candidates

    def _seeds(self, number: int) -> Iterator[int]:
        """Yield separate seeds for each screen and round."""
        random = np.random.default_rng((self.seed, len(self.screens), number))
        while True:
            yield int(random.integers(10**6))

    def _first_draws(self, number: int) -> list[Proposal]:
        """Return the candidates for a first screen."""
        seeds = self._seeds(number)
        order = np.random.default_rng(next(seeds)).permutation(len(self.shipped))
        named = [self.shipped[each] for each in order[: CANDIDATE_COUNTS["shipped"]]]
        made = [
            Proposal(mutate(each, next(seeds), FIRST_MUTATION_DISTANCE), "shipped", (each.name,))
            for each in named
        ]
        return made + [
            Proposal(random_style(next(seeds)), "wild") for _ in range(4 * CANDIDATE_COUNTS["wild"])
        ]

    def _draws(self, taken: Tile, number: int) -> list[Proposal]:
        """Return candidates derived from a tile, with a distance that grows each round."""
        seeds, style, own = self._seeds(number), taken.style, (taken.style.name,)
        middle = max(self._near(taken), MIN_MUTATION_DISTANCE) * (1 + number)
        made = [
            Proposal(mutate(style, next(seeds), min(1.0, float(each)), self.locks), "values", own)
            for each in middle * np.linspace(0.5, 1.5, CANDIDATE_COUNTS["values"])
        ]
        if "steps" not in self.locks:
            altered = (alter(style, next(seeds), self.locks) for _ in range(CANDIDATE_COUNTS["step"]))
            made += [Proposal(each, "step", own) for each in altered]
        for other in self._partners(taken, next(seeds)):
            crossed = cross(style, other, next(seeds), self.locks)
            made.append(Proposal(crossed, "cross", (style.name, other.name)))
        wild = [random_style(next(seeds)) for _ in range(CANDIDATE_COUNTS["wild"])]
        # Most random styles are rejected; mutants of shipped styles rarely are.
        order = np.random.default_rng(next(seeds)).permutation(len(self.shipped))
        wild += [
            mutate(self.shipped[each], next(seeds), WILD_MUTATION_DISTANCE)
            for each in order[: CANDIDATE_COUNTS["wild"]]
        ]
        return made + [Proposal(self._with_locks(each, style, next(seeds)), "wild") for each in wild]

    def _near(self, taken: Tile) -> float:
        """Return the distance of new tiles from a tile; each time it is chosen again, it is smaller."""
        return self.near * REPEAT_DISTANCE_FACTOR ** self._repeats(taken)

    def _repeats(self, taken: Tile) -> int:
        """Return the number of consecutive screens with this tile in the middle."""
        count, screen = 0, self.screen
        while screen.before is not None and screen.tiles[len(SCREEN_KINDS) // 2].style == taken.style:
            count, screen = count + 1, self.screens[screen.before]
        return count

    def _with_locks(self, wild: Style, style: Style, seed: int) -> Style:
        """Return a wild card with the locked parts of `style`."""
        if "steps" in self.locks:
            return mutate(style, seed, 1.0, self.locks)
        return cross(style, wild, seed, self.locks) if self.locks else wild

    def _partners(self, taken: Tile, seed: int) -> list[Style]:
        """Return favourites for crossing, latest first; fill up with shipped styles."""
        liked = [tile.style for tile in [*self.stars[::-1], *self._favourites[::-1]]]
        order = np.random.default_rng(seed).permutation(len(self.shipped))
        named = {style.name: style for style in [*liked, *(self.shipped[each] for each in order)]}
        return [style for style in named.values() if style != taken.style][: CANDIDATE_COUNTS["cross"]]

    # Selection

    def _fill(
        self, kinds: Sequence[str], tiles: list[Tile], draws: Callable[[int], list[Proposal]]
    ) -> tuple[Tile, ...]:
        """Select nine distinct tiles: each the best of its kind, or of any kind if none is left.

        Args:
            kinds: the kind of each position.
            tiles: tiles that are already selected.
            draws: returns the candidates of a round.
        """
        wanted = Counter(kinds) - Counter(tile.kind for tile in tiles)
        found: list[Tile] = []
        for number in range(MAX_ROUNDS):
            proposals = draws(number)
            found += self._render(proposals)
            chosen = self._select(wanted, tiles, found)
            missing = wanted.keys() & {each.kind for each in proposals} - {each.kind for each in chosen}
            is_poor = missing or not (self.locks or _is_varied([*tiles, *chosen]))
            if len(chosen) == wanted.total() and not (is_poor and number == 0):
                break
        else:
            for number in range(MAX_ROUNDS, 4 * MAX_ROUNDS):
                if len(chosen) == wanted.total() or self.locks:
                    break
                found += self._render(self._first_draws(number))  # all that is near the choice looks alike
                chosen = self._select(wanted, tiles, found)
            # Everything is locked, or nothing passes: use the most different candidates.
            chosen += self._sort_by_novelty([each for each in found if each not in chosen], [*tiles, *chosen])
        return _arrange(kinds, [*tiles, *chosen[: wanted.total()]])

    def _render(self, candidates: Sequence[Proposal]) -> list[Tile]:
        """Render candidates, and return those that are valid and pass the gates."""
        looks = self.looks([each.style for each in candidates])
        return [
            Tile(each.style, each.kind, look, each.parents)
            for each, look in zip(candidates, looks, strict=True)
            if look is not None and not look.fault
        ]

    def _select(self, wanted: Counter[str], tiles: Sequence[Tile], found: Sequence[Tile]) -> list[Tile]:
        """Select distinct tiles of the wanted kinds, then of any kind; different looks first."""
        chosen: list[Tile] = []
        left = list(found)
        apart = {kind: 0.0 if kind in NEAR_KINDS else MIN_LOOK_DISTANCE for kind in wanted}
        turns = [(kind, apart[kind]) for kind in wanted.elements()]
        turns += [("", MIN_LOOK_DISTANCE)] * wanted.total() + [("", 0.0)] * wanted.total()
        for kind, least in turns:
            if len(chosen) == wanted.total():
                break
            of_kind = [each for each in left if kind in ("", each.kind) and not _is_near_same(each, chosen)]
            # Wild cards weigh preference less, to show something unexpected.
            liking = 0.6 if kind == "wild" and tiles else 1.0
            reach = (
                MIN_REACH_DISTANCE + REACH_DISTANCE_RANGE * self._near(tiles[0])
                if kind in NEAR_KINDS
                else None
            )
            best = self._best(of_kind, [*tiles, *chosen], liking, least, reach)
            if best is not None:
                chosen.append(best)
                left.remove(best)
        return chosen

    def _best(
        self,
        candidates: Sequence[Tile],
        taken: Sequence[Tile],
        liking: float,
        least: float,
        reach: float | None = None,
    ) -> Tile | None:
        """Return the best candidate by preference and novelty; None if all are similar to `taken`.

        Args:
            liking: the weight of the predicted preference.
            least: the minimum appearance distance.
            reach: the wanted appearance distance from the first in `taken`; None: far from all.
        """
        if not candidates:
            return None
        looks, others = ([each.look for each in some] for some in (candidates, taken))
        apart = nearest_appearance(looks, others)
        is_apart = (apart >= least) & (nearest(looks, others) >= MIN_TILE_DISTANCE)
        novelty = np.minimum(apart, MAX_NOVELTY_DISTANCE)
        if reach is not None:
            ratio = nearest_appearance(looks, others[:1]) / reach
            is_apart, novelty = is_apart & (ratio <= MAX_REACH_RATIO), -np.abs(ratio - 1)
        worth = liking * self._utility(looks) + NOVELTY_WEIGHT * novelty
        return candidates[int(np.argmax(np.where(is_apart, worth, -np.inf)))] if is_apart.any() else None

    def _sort_by_novelty(self, candidates: list[Tile], taken: list[Tile]) -> list[Tile]:
        """Sort candidates so that each is farthest from all before it."""
        chosen: list[Tile] = []
        while candidates:
            apart = nearest([each.look for each in candidates], [each.look for each in [*taken, *chosen]])
            chosen.append(candidates.pop(int(np.argmax(apart))))
        return chosen

    # Learning

    def _learn(self, place: int) -> None:
        tiles = self.screen.tiles
        others = [tile.look.features for tile in tiles if tile is not tiles[place]]
        self._taste_of(others[0]).learn(tiles[place].look.features, others)

    def _utility(self, looks: Sequence[Look]) -> np.ndarray:
        """Return the predicted preference for looks, between -1 and 1."""
        features = np.array([look.features for look in looks])
        return np.tanh(self._taste_of(features[0]).utility(features - features.mean(axis=0)) / UTILITY_RANGE)

    def _taste_of(self, features: np.ndarray) -> Taste:
        """Return the learned taste, which initially prefers looks similar to shipped styles."""
        if self._taste is None:
            self._taste = Taste(np.eye(1, len(features))[0])
        return self._taste


def _is_near_same(tile: Tile, others: Sequence[Tile]) -> bool:
    """Whether a tile is near the same shipped style as one of the others."""
    return tile.kind == "shipped" and any(each.parents == tile.parents for each in others)


def _is_apart(tile: Tile, others: Sequence[Tile]) -> bool:
    return float(nearest([tile.look], [each.look for each in others])[0]) >= MIN_TILE_DISTANCE


def _is_varied(tiles: Sequence[Tile]) -> bool:
    """Whether a screen has enough different looks."""
    looks: list[Look] = []
    for tile in tiles:
        if nearest_appearance([tile.look], looks)[0] >= MIN_LOOK_DISTANCE:
            looks.append(tile.look)
    return len(looks) >= (MIN_LOOKS if any(tile.kind == CHOSEN_KIND for tile in tiles) else MIN_FIRST_LOOKS)


def _arrange(kinds: Sequence[str], tiles: Sequence[Tile]) -> tuple[Tile, ...]:
    """Place tiles at the positions for their kinds, and the others at the remaining positions."""
    left = list(tiles)
    placed: list[Tile | None] = []
    for kind in kinds:
        found = next((tile for tile in left if tile.kind == kind), None)
        placed.append(found)
        if found is not None:
            left.remove(found)
    return tuple(tile or left.pop(0) for tile in placed)
