"""Finding a look by choosing: screens of nine, each made from the tile that was taken on the one before."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vidstyle.explore.generate import alter, cross, mutate, random_style
from vidstyle.explore.look import Look, NewLooks, nearest
from vidstyle.explore.taste import Taste
from vidstyle.style import Style

CHOSEN_KIND = "chosen"
SCREEN_KINDS = ("step", "values", "cross", "values", CHOSEN_KIND, "values", "wild", "values", "step")
"""How the tile at each place of a screen is made from the one that was taken, row by row."""
FIRST_SCREEN_KINDS = ("shipped", "wild", "shipped", "wild", "wild", "wild", "shipped", "wild", "shipped")
"""The same for a screen that follows none."""
CANDIDATE_COUNTS = {"values": 10, "step": 6, "cross": 4, "wild": 3, "shipped": 6}
"""How many of each kind are tried for a screen; those that are shown are chosen among them."""
MAX_ROUNDS = 4
"""How often others are tried where too few pass."""
MIN_TILE_DISTANCE = 0.3
"""Distance below which two tiles would look alike."""
FIRST_MUTATION_DISTANCE, WILD_MUTATION_DISTANCE = 0.25, 0.6
"""How far mutants of shipped styles are from them: on a first screen, and as wild cards."""
NOVELTY_WEIGHT = 0.8
"""What it counts that a tile is unlike those chosen before it, beside liking."""
MAX_NOVELTY_DISTANCE = 0.7
"""Distance above which more counts no more."""
REPEAT_DISTANCE_FACTOR = 0.7
"""Factor of distances each time that the same tile is taken again: nothing was better."""
UTILITY_RANGE = 4.0
"""Utility above the mean at which liking is nearly certain."""


@dataclass(frozen=True, eq=False)
class Tile:
    """A style on a screen.

    Attributes:
        kind: how it came about: "chosen", "values", "step", "cross", "wild" or "shipped".
        parents: the names of the styles that it is made from.
    """

    style: Style
    kind: str
    look: Look
    parents: tuple[str, ...] = ()


@dataclass(eq=False)
class TileScreen:
    """Nine tiles.

    Attributes:
        tiles: row by row.
        before: the number of the screen on which a tile was taken for this one, or None.
        taken: the place of the tile taken last, or None.
        after: the screen that followed.
    """

    tiles: tuple[Tile, ...]
    before: int | None = None
    taken: int | None = None
    after: int | None = None


@dataclass(frozen=True)
class Proposal:
    """A style that is not tried yet."""

    style: Style
    kind: str
    parents: tuple[str, ...] = ()


@dataclass
class Chooser:
    """Screens, what was chosen on them, and what is learned from it.

    The same seed and the same choices give the same screens.

    Attributes:
        looks: tries styles.
        shipped: styles that are known to be good; the first screen is made of them.
        near: how far tiles are from the one taken, from 0 (near) to 1 (far).
        locks: what of the tile taken stays: some of `LOCKS`.
        screens: all screens in the order in which they were made.
        at: the number of the one that is shown.
        stars: tiles that are kept.
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
        """The screen that is shown."""
        return self.screens[self.at]

    def new_screen(self) -> TileScreen:
        """Show nine tiles that follow from none: mutants of shipped styles, and wild cards."""
        return self._show(self._filled(FIRST_SCREEN_KINDS, [], self._first_draws), None)

    def more_like(self, place: int) -> TileScreen:
        """Take a tile of the screen, and show others like it."""
        self._learn(place)
        taken = self.screen.tiles[place]
        self.screen.taken = place
        if taken not in self._favourites:
            self._favourites.append(taken)
        return self.again(taken)

    def again(self, taken: Tile | None = None) -> TileScreen:
        """Show other tiles like the one in the middle, or like this one."""
        middle = replace(taken or self.screen.tiles[len(SCREEN_KINDS) // 2], kind=CHOSEN_KIND)
        tiles = self._filled(SCREEN_KINDS, [middle], lambda number: self._draws(middle, number))
        return self._show(tiles, self.at)

    def likely_styles(self, place: int) -> list[Style]:
        """The styles that `more_like` will try first for this place."""
        return [each.style for each in self._draws(self.screen.tiles[place], 0)]

    def by_liking(self) -> list[int]:
        """The places of the screen, the likeliest choice first."""
        utility = self._utility([tile.look for tile in self.screen.tiles])
        return [int(place) for place in np.argsort(-utility, kind="stable")]

    def back(self) -> None:
        """Show the screen before, if there is one."""
        if self.screen.before is not None:
            self.screens[self.screen.before].after = self.at
            self.at = self.screen.before

    def forward(self) -> None:
        """Show again the screen from which one went back."""
        if self.screen.after is not None:
            self.at = self.screen.after

    def star(self, tile: Tile, on: bool) -> None:
        """Keep a tile, or no longer; later tiles are crossed with those that are kept."""
        self.stars = [each for each in self.stars if each is not tile] + [tile] * on

    def _show(self, tiles: tuple[Tile, ...], before: int | None) -> TileScreen:
        self.screens.append(TileScreen(tiles, before))
        if before is not None:
            self.screens[before].after = len(self.screens) - 1
        self.at = len(self.screens) - 1
        return self.screen

    # What is tried

    def _seeds(self, number: int) -> Iterator[int]:
        """Seeds of their own for each screen and round."""
        random = np.random.default_rng((self.seed, len(self.screens), number))
        while True:
            yield int(random.integers(10**6))

    def _first_draws(self, number: int) -> list[Proposal]:
        """Candidates for a screen that follows none."""
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
        """Candidates made from a tile; farther from it with each round."""
        seeds, style, own = self._seeds(number), taken.style, (taken.style.name,)
        middle = self.near * REPEAT_DISTANCE_FACTOR ** self._repeats(taken) * (1 + number)
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
        # Most random styles fail somewhere; these rarely do.
        order = np.random.default_rng(next(seeds)).permutation(len(self.shipped))
        wild += [
            mutate(self.shipped[each], next(seeds), WILD_MUTATION_DISTANCE)
            for each in order[: CANDIDATE_COUNTS["wild"]]
        ]
        return made + [Proposal(self._with_locks(each, style, next(seeds)), "wild") for each in wild]

    def _repeats(self, taken: Tile) -> int:
        """How many screens in a row have had this tile in the middle."""
        count, screen = 0, self.screen
        while screen.before is not None and screen.tiles[len(SCREEN_KINDS) // 2].style == taken.style:
            count, screen = count + 1, self.screens[screen.before]
        return count

    def _with_locks(self, wild: Style, style: Style, seed: int) -> Style:
        """A wild card that has what is locked."""
        if "steps" in self.locks:
            return mutate(style, seed, 1.0, self.locks)
        return cross(style, wild, seed, self.locks) if self.locks else wild

    def _partners(self, taken: Tile, seed: int) -> list[Style]:
        """Favourites to be crossed with, the latest first; shipped styles where there are too few."""
        liked = [tile.style for tile in [*self.stars[::-1], *self._favourites[::-1]]]
        order = np.random.default_rng(seed).permutation(len(self.shipped))
        named = {style.name: style for style in [*liked, *(self.shipped[each] for each in order)]}
        return [style for style in named.values() if style != taken.style][: CANDIDATE_COUNTS["cross"]]

    # What is shown

    def _filled(
        self, kinds: Sequence[str], tiles: list[Tile], draws: Callable[[int], list[Proposal]]
    ) -> tuple[Tile, ...]:
        """Nine tiles, no two alike: each the best of its kind, or of any kind where none is left.

        Args:
            kinds: what each place is for.
            tiles: those that are shown anyway.
            draws: the candidates of a round.
        """
        wanted = Counter(kinds) - Counter(tile.kind for tile in tiles)
        found: list[Tile] = []
        for number in range(MAX_ROUNDS):
            proposals = draws(number)
            found += self._tried(proposals)
            chosen = self._chosen(wanted, tiles, found)
            missing = wanted.keys() & {each.kind for each in proposals} - {each.kind for each in chosen}
            if len(chosen) == wanted.total() and not (missing and number == 0):
                break
        else:  # all is locked, or nothing passes: whatever differs most
            chosen += self._farthest([each for each in found if each not in chosen], [*tiles, *chosen])
        return _placed(kinds, [*tiles, *chosen[: wanted.total()]])

    def _tried(self, candidates: Sequence[Proposal]) -> list[Tile]:
        """Those that can be used and pass the gates."""
        looks = self.looks([each.style for each in candidates])
        return [
            Tile(each.style, each.kind, look, each.parents)
            for each, look in zip(candidates, looks, strict=True)
            if look is not None and not look.fault
        ]

    def _chosen(self, wanted: Counter[str], tiles: Sequence[Tile], found: Sequence[Tile]) -> list[Tile]:
        """So many of each kind as are wanted, then of any kind, as far as there are any unlike the others."""
        chosen: list[Tile] = []
        left = list(found)
        for kind in [*wanted.elements(), *[""] * wanted.total()]:
            if len(chosen) == wanted.total():
                break
            of_kind = [each for each in left if kind in ("", each.kind)]
            # A wild card shows what one would not have asked for.
            best = self._best(of_kind, [*tiles, *chosen], 0.6 if kind == "wild" and tiles else 1.0)
            if best is not None:
                chosen.append(best)
                left.remove(best)
        return chosen

    def _best(self, candidates: Sequence[Tile], taken: Sequence[Tile], liking: float) -> Tile | None:
        """The candidate that is liked and unlike those taken; None if all are like one of them.

        Args:
            liking: how much it counts that it is liked.
        """
        if not candidates:
            return None
        apart = nearest([each.look for each in candidates], [each.look for each in taken])
        worth = liking * self._utility([each.look for each in candidates]) + NOVELTY_WEIGHT * np.minimum(
            apart, MAX_NOVELTY_DISTANCE
        )
        best = int(np.argmax(np.where(apart >= MIN_TILE_DISTANCE, worth, -np.inf)))
        return candidates[best] if apart[best] >= MIN_TILE_DISTANCE else None

    def _farthest(self, candidates: list[Tile], taken: list[Tile]) -> list[Tile]:
        """The candidates in the order in which each is farthest from all before it."""
        chosen: list[Tile] = []
        while candidates:
            apart = nearest([each.look for each in candidates], [each.look for each in [*taken, *chosen]])
            chosen.append(candidates.pop(int(np.argmax(apart))))
        return chosen

    # What is learned

    def _learn(self, place: int) -> None:
        tiles = self.screen.tiles
        others = [tile.look.features for tile in tiles if tile is not tiles[place]]
        self._taste_of(others[0]).learn(tiles[place].look.features, others)

    def _utility(self, looks: Sequence[Look]) -> np.ndarray:
        """What looks are worth by what was learned, between -1 and 1."""
        features = np.array([look.features for look in looks])
        return np.tanh(self._taste_of(features[0]).utility(features - features.mean(axis=0)) / UTILITY_RANGE)

    def _taste_of(self, features: np.ndarray) -> Taste:
        """Before the first choice, what is like the shipped styles is liked."""
        if self._taste is None:
            self._taste = Taste(np.eye(1, len(features))[0])
        return self._taste


def _placed(kinds: Sequence[str], tiles: Sequence[Tile]) -> tuple[Tile, ...]:
    """The tiles at the places for their kinds, the others where places are left."""
    left = list(tiles)
    placed: list[Tile | None] = []
    for kind in kinds:
        found = next((tile for tile in left if tile.kind == kind), None)
        placed.append(found)
        if found is not None:
            left.remove(found)
    return tuple(tile or left.pop(0) for tile in placed)
