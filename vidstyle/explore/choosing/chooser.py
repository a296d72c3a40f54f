"""Interactive search for a style: screens of nine tiles, each derived from the tile chosen before."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vidstyle.explore.choosing.candidate_generator import (
    MIN_MUTATION_DISTANCE,
    CandidateGenerator,
    StyleCandidate,
    generate_first,
)
from vidstyle.explore.choosing.taste import Taste
from vidstyle.explore.choosing.tile_screen import (
    CHOSEN_KIND,
    FIRST_SCREEN_KINDS,
    SCREEN_KINDS,
    Tile,
    TileScreen,
    arrange,
)
from vidstyle.explore.choosing.tile_selector import TileSelector, is_distinct, is_varied, sort_by_novelty
from vidstyle.explore.look import Look, NewLooks
from vidstyle.style import Style

MAX_ROUNDS = 4
"""Maximum number of rounds of candidates if too few pass."""
MAX_OTHER_ROUNDS = 12
"""Maximum number of further rounds, of candidates for a first screen, if all that is near looks alike."""
REPEAT_DISTANCE_FACTOR = 0.7
"""Factor of distances each time the same tile is chosen again, since no other was better."""
FAILED_COUNT = 27
"""Number of candidates with a fault, the most liked ones, from which tiles are selected if too few pass."""
UTILITY_RANGE = 4.0
"""Utility above the mean at which the predicted preference saturates."""


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
        return self._show(self._fill(FIRST_SCREEN_KINDS, [], self._generate_first), None)

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
            if is_distinct(tile, chosen) and len(chosen) < len(SCREEN_KINDS):
                chosen.append(tile)
        chosen += [tile for tile in found if tile not in chosen]
        return self._show(tuple(chosen[: len(SCREEN_KINDS)]), None)

    def more_like(self, place: int) -> TileScreen:
        """Choose a tile of the screen, and show similar ones."""
        self._learn(place)
        screen, taken = self.screen, self.screen.tiles[place]
        if taken not in self._favourites:
            self._favourites.append(taken)
        made = self.again(taken)
        screen.taken = place
        return made

    def again(self, taken: Tile | None = None) -> TileScreen:
        """Show more tiles like `taken`, by default the one in the middle."""
        middle = replace(taken or self.screen.tiles[len(SCREEN_KINDS) // 2], kind=CHOSEN_KIND)
        tiles = self._fill(SCREEN_KINDS, [middle], lambda number: self._generate(middle, number))
        return self._show(tiles, self.at)

    def likely_styles(self, place: int) -> list[Style]:
        """Return the styles that `more_like` tries first for this position."""
        return [each.style for each in self._generate(self.screen.tiles[place], 0)]

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

    def _generate_first(self, number: int) -> list[StyleCandidate]:
        """Return the candidates of a round for a first screen."""
        return generate_first(self.shipped, self._seeds(number))

    def _generate(self, taken: Tile, number: int) -> list[StyleCandidate]:
        """Return candidates derived from a tile, with a distance that grows each round."""
        liked = [tile.style for tile in [*self.stars[::-1], *self._favourites[::-1]]]
        generator = CandidateGenerator(taken.style, self.shipped, liked, self.locks)
        distance = max(self._near(taken), MIN_MUTATION_DISTANCE) * (1 + number)
        return generator.generate(distance, self._seeds(number))

    def _near(self, taken: Tile) -> float:
        """Return the distance of new tiles from a tile; each time it is chosen again, it is smaller."""
        return self.near * REPEAT_DISTANCE_FACTOR ** self._repeats(taken)

    def _repeats(self, taken: Tile) -> int:
        """Return the number of consecutive screens with this tile in the middle."""
        count, screen = 0, self.screen
        while screen.before is not None and screen.tiles[len(SCREEN_KINDS) // 2].style == taken.style:
            count, screen = count + 1, self.screens[screen.before]
        return count

    # Selection

    def _fill(
        self, kinds: Sequence[str], tiles: list[Tile], generate: Callable[[int], list[StyleCandidate]]
    ) -> tuple[Tile, ...]:
        """Select nine distinct tiles: each the best of its kind, or of any kind if too few pass.

        If fewer than nine pass at all, as of a plain picture, the others have a fault.

        Args:
            kinds: the kind of each position.
            tiles: tiles that are already selected.
            generate: returns the candidates of a round.
        """
        wanted = Counter(kinds) - Counter(tile.kind for tile in tiles)
        selector = TileSelector(self._utility, self._near(tiles[0]) if tiles else self.near)
        found, failed = list[Tile](), list[Tile]()
        for number in range(MAX_ROUNDS):
            candidates = generate(number)
            self._render(candidates, found, failed)
            chosen = selector.select(wanted, tiles, found)
            missing = wanted.keys() & {each.kind for each in candidates} - {each.kind for each in chosen}
            is_poor = missing or not (self.locks or is_varied([*tiles, *chosen]))
            if len(chosen) == wanted.total() and not (is_poor and number == 0):
                break
        for number in range(MAX_ROUNDS, MAX_ROUNDS + MAX_OTHER_ROUNDS):
            if len(chosen) == wanted.total() or self.locks:
                break
            self._render(self._generate_first(number), found, failed)
            chosen = selector.select(wanted, tiles, found)
        if len(chosen) < wanted.total():  # all is locked, or too few pass
            chosen += sort_by_novelty([each for each in found if each not in chosen], [*tiles, *chosen])
        if len(chosen) < wanted.total():
            likeliest = self._most_liked(failed, FAILED_COUNT)
            chosen += selector.select(wanted, [*tiles, *chosen], likeliest)
            chosen += [each for each in likeliest if each not in chosen]
        return arrange(kinds, [*tiles, *chosen[: wanted.total()]])

    def _render(self, candidates: Sequence[StyleCandidate], found: list[Tile], failed: list[Tile]) -> None:
        """Render candidates; add those that pass the gates to `found`, and other valid ones to `failed`."""
        looks = self.looks([each.style for each in candidates])
        for each, look in zip(candidates, looks, strict=True):
            if look is not None:
                into = failed if look.fault else found
                into.append(Tile(each.style, each.kind, look, each.parents))

    def _most_liked(self, tiles: Sequence[Tile], count: int) -> list[Tile]:
        """Return the tiles with the highest predicted preference, highest first."""
        utility = self._utility([each.look for each in tiles])
        return [tiles[place] for place in np.argsort(-utility, kind="stable")[:count]]

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
