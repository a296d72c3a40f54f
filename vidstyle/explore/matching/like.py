"""`vidstyle styles --like PICTURE`: find the styles whose results look like a given picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import inf

import numpy as np

from vidstyle.core.machine.cores import available_cores
from vidstyle.errors import StyleError
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.generate import alter, cross, mutate
from vidstyle.explore.matching.appearance import appearance_distance, appearance_of
from vidstyle.explore.matching.kept_subject import KeptSubject
from vidstyle.explore.matching.tune import tune_style
from vidstyle.gallery.preview import read_still
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.gallery.thumbnail import THUMBNAIL_FOLDER
from vidstyle.media.resize import reduce_picture
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.style import PLAIN, Style, load_style

MAX_NEAR_DISTANCE, MIN_FAR_DISTANCE = 1.25, 2.0
"""Distances up to which two looks are near, and from which they are far; 1 is usual within one style."""
MAX_PHOTOGRAPH_SIDE_PX = 720
"""Maximum longer side of the photograph on which styles are compared."""
SEARCH_ROUNDS = 6
"""Number of search rounds, each from the best styles so far."""
PARENT_COUNT, CHILD_COUNT = 4, 3
"""Number of styles kept in each round, and of variations of each kind per style."""
TUNED_COUNT = 2
"""Number of styles whose values are tuned one by one after the search."""


@dataclass(frozen=True)
class Likeness:
    """A style, and the distance of its rendering of the photograph to the wanted look."""

    style: Style
    distance: float

    @property
    def is_near(self) -> bool:
        """Whether the look is reached."""
        return self.distance <= MAX_NEAR_DISTANCE

    @property
    def words(self) -> str:
        """The distance in words: "0.93, near"."""
        word = "near" if self.is_near else "far" if self.distance >= MIN_FAR_DISTANCE else "not near"
        return f"{self.distance:.2f}, {word}"


def known_styles() -> list[Style]:
    """Return the shipped styles and their variants."""
    return [
        variant
        for style in shipped_styles()
        for variant in (style, *(load_style(f"{style.name}:{name}") for name in style.variants))
    ]


def photograph_for(source: str | None) -> np.ndarray:
    """Return the photograph for comparing styles, H x W x 3 uint8: from `source`, or from the gallery."""
    return reduce_picture(read_still(source or THUMBNAIL_FOLDER / f"{PLAIN}.webp"), MAX_PHOTOGRAPH_SIDE_PX)


def rank_styles(
    wanted: np.ndarray,
    photograph: np.ndarray,
    styles: Iterable[Style],
    on_step: ProgressCallback = ignore_progress,
    subject: KeptSubject | None = None,
) -> list[Likeness]:
    """Return styles sorted by the distance of their rendering of `photograph` to `wanted`, nearest first.

    Styles that cannot render the photograph come last, with an infinite distance.

    Args:
        wanted, photograph: H x W x 3 uint8.
        subject: of the photograph, if styles that lose it come last, too.
    """
    target, styles = appearance_of(wanted), list(styles)
    found: list[Likeness] = []
    for style, distance in zip(styles, _distances(photograph, target, styles, subject), strict=True):
        found.append(Likeness(style, distance))
        on_step("comparing looks", len(found), len(styles))
    return sorted(found, key=lambda each: each.distance)


def _distances(
    photograph: np.ndarray, target: np.ndarray, styles: Iterable[Style], subject: KeptSubject | None = None
) -> Iterator[float]:
    """Yield the distance of each style's rendering to an appearance, using all cores.

    Args:
        subject: of the photograph, if renderings that lose it count as infinitely far.
    """

    def distance(style: Style) -> float:
        try:
            rendering = restyle_picture(photograph, style)
        except StyleError:  # a variation that needs too large a working size for this photograph
            return inf
        if subject is not None and subject.is_lost(rendering):
            return inf
        return appearance_distance(appearance_of(rendering), target)

    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-explore") as pool:
        yield from pool.map(distance, styles)


def search_styles(
    wanted: np.ndarray,
    photograph: np.ndarray,
    known: list[Likeness],
    on_step: ProgressCallback = ignore_progress,
) -> list[Likeness]:
    """Search variations of known styles for nearer ones, and tune the values of the nearest.

    Each round starts from the best styles so far.

    Args:
        known: from `rank_styles`.

    Returns:
        The best styles, at most `PARENT_COUNT + TUNED_COUNT`, nearest first.
    """
    best = known[:PARENT_COUNT]
    subject = KeptSubject(photograph, restyle_picture(photograph, best[0].style))
    for turn in range(SEARCH_ROUNDS):
        reach = 0.5 / (1 + turn / 2)
        children = [
            child
            for number, parent in enumerate(best)
            for child in _children(parent.style, best[0].style, f"{turn}-{number}", reach)
        ]
        best += rank_styles(wanted, photograph, children, subject=subject)
        best = sorted(best, key=lambda each: each.distance)[:PARENT_COUNT]
        on_step("searching", turn + 1, SEARCH_ROUNDS)
    target = appearance_of(wanted)

    def distances(styles: Sequence[Style]) -> list[float]:
        return list(_distances(photograph, target, styles, subject))

    tuned = [Likeness(*tune_style(each.style, distances, on_step=on_step)) for each in best[:TUNED_COUNT]]
    return sorted([*tuned, *best], key=lambda each: each.distance)


def match_styles(
    wanted: np.ndarray, photograph: np.ndarray, on_step: ProgressCallback = ignore_progress
) -> list[Likeness]:
    """Return known styles and variations found by `search_styles`, nearest first."""
    known = rank_styles(wanted, photograph, known_styles(), on_step)
    found = [*search_styles(wanted, photograph, known, on_step), *known]
    return sorted({repr(each.style): each for each in found}.values(), key=lambda each: each.distance)


def _children(style: Style, best: Style, seed: str, reach: float) -> list[Style]:
    seeds = [f"{seed}-{number}" for number in range(CHILD_COUNT)]
    mutants = [mutate(style, each, reach) for each in seeds]
    altered = [alter(style, each) for each in seeds[:1]]
    return mutants + altered + ([cross(style, best, seed)] if style != best else [])
