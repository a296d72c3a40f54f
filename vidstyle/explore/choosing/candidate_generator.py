"""Candidates for the tiles of a screen: mutants, altered and crossed styles, and wild cards."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.explore.generate import alter, cross, mutate, random_style
from vidstyle.style import Style

CANDIDATE_COUNTS = {"values": 10, "step": 8, "cross": 4, "wild": 4, "shipped": 12}
"""Number of candidates of each kind from which the tiles of a screen are selected."""
FIRST_WILD_RATIO = 4
"""Wild cards for a first screen, relative to those for other screens."""
FIRST_MUTATION_DISTANCE, WILD_MUTATION_DISTANCE = 0.25, 0.6
"""Distance of mutants from shipped styles: on a first screen, and for wild cards."""
MIN_MUTATION_DISTANCE = 0.1
"""Distance of mutants below which few differences are visible."""


@dataclass(frozen=True)
class StyleCandidate:
    """A style for a tile, which is not rendered yet; see `Tile`."""

    style: Style
    kind: str
    parents: tuple[str, ...] = ()


def generate_first(shipped: Sequence[Style], seeds: Iterator[int]) -> list[StyleCandidate]:
    """Return candidates for a first screen: mutants of shipped styles, and wild cards."""
    named = _shuffle(shipped, next(seeds))[: CANDIDATE_COUNTS["shipped"]]
    mutants = [
        StyleCandidate(mutate(each, next(seeds), FIRST_MUTATION_DISTANCE), "shipped", (each.name,))
        for each in named
    ]
    wild_count = FIRST_WILD_RATIO * CANDIDATE_COUNTS["wild"]
    return mutants + [StyleCandidate(random_style(next(seeds)), "wild") for _ in range(wild_count)]


@dataclass(frozen=True)
class CandidateGenerator:
    """Derives candidates from a chosen style.

    Attributes:
        style: the chosen style.
        shipped: known good styles.
        liked: styles that the user likes, latest first.
        locks: parts of the style to keep, of `LOCKS`.
    """

    style: Style
    shipped: Sequence[Style]
    liked: Sequence[Style]
    locks: frozenset[str]

    def generate(self, distance: float, seeds: Iterator[int]) -> list[StyleCandidate]:
        """Return candidates of all kinds.

        Args:
            distance: the mean distance of candidates with other values, 0 to 1.
        """
        style, own = self.style, (self.style.name,)
        distances = distance * np.linspace(0.5, 1.5, CANDIDATE_COUNTS["values"])
        found = [
            StyleCandidate(mutate(style, next(seeds), min(1.0, float(each)), self.locks), "values", own)
            for each in distances
        ]
        if "steps" not in self.locks:
            altered = (alter(style, next(seeds), self.locks) for _ in range(CANDIDATE_COUNTS["step"]))
            found += [StyleCandidate(each, "step", own) for each in altered]
        for other in self._partners(next(seeds)):
            crossed = cross(style, other, next(seeds), self.locks)
            found.append(StyleCandidate(crossed, "cross", (style.name, other.name)))
        wild = self._wild_cards(seeds)
        return found + [StyleCandidate(self._with_locks(each, next(seeds)), "wild") for each in wild]

    def _partners(self, seed: int) -> list[Style]:
        """Return styles for crossing: liked ones first, filled up with shipped ones."""
        named = {style.name: style for style in [*self.liked, *_shuffle(self.shipped, seed)]}
        return [style for style in named.values() if style != self.style][: CANDIDATE_COUNTS["cross"]]

    def _wild_cards(self, seeds: Iterator[int]) -> list[Style]:
        """Return random styles, of which most are rejected, and mutants of shipped ones, which rarely are."""
        wild = [random_style(next(seeds)) for _ in range(CANDIDATE_COUNTS["wild"])]
        named = _shuffle(self.shipped, next(seeds))[: CANDIDATE_COUNTS["wild"]]
        return wild + [mutate(each, next(seeds), WILD_MUTATION_DISTANCE) for each in named]

    def _with_locks(self, wild: Style, seed: int) -> Style:
        """Return a wild card with the locked parts of the chosen style."""
        if "steps" in self.locks:
            return mutate(self.style, seed, 1.0, self.locks)
        return cross(self.style, wild, seed, self.locks) if self.locks else wild


def _shuffle(styles: Sequence[Style], seed: int) -> list[Style]:
    order = np.random.default_rng(seed).permutation(len(styles))
    return [styles[each] for each in order]
