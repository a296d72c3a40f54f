"""The main colours of a film, stable over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.core.color.oklab import lab_from_rgb, rgb_from_lab
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import ExponentialSmoother, small_colors

MAX_SIDE_PX = 96
"""Largest side in pixels of the small copy that colours are taken from."""
LIGHTNESS_BINS = 24
"""Bins of OKLab along the range of lightness; non-empty bins are clustered."""
FIRST_ROUNDS, NEXT_ROUNDS = 12, 2
"""Rounds of k-means for a picture that begins a scene, and for each one after it."""
SETTLE_SECONDS = 1.0
"""Time constant in seconds by which colours follow the film."""
MIN_COLOR_DIFFERENCE = 0.008
"""A colour changes only by at least this distance in OKLab; a visible difference is about 0.02."""
CHROMA_WEIGHT = 2.0
"""Weight of a difference in hue or saturation relative to one in lightness, for clusters."""
SKIN_COLOR, SKIN_HALF_DISTANCE = (0.045, 0.05), 0.03
"""Chroma of skin of any tone, a and b of OKLab, and the distance at which a colour counts half as skin."""
SKIN_WEIGHT = 2.5
"""Weight of skin relative to other colours: faces are small, and shaded walls have nearly their colours."""
CONSTANTS = {
    "chroma": CHROMA_WEIGHT,
    "skin": [*SKIN_COLOR, SKIN_HALF_DISTANCE, SKIN_WEIGHT],
    "side": MAX_SIDE_PX,
    "bins": LIGHTNESS_BINS,
    "rounds": [FIRST_ROUNDS, NEXT_ROUNDS],
    "settle": SETTLE_SECONDS,
    "held": MIN_COLOR_DIFFERENCE,
}


class FilmTable(tuple[np.ndarray]):
    """One table, 6 x colours float32, rewritten for each picture: OKLab, then RGB 0..1."""


class FilmColors:
    """Follows the main colours of a film.

    k-means in OKLab (Lloyd 1982) over the colours of a small copy, each weighted by the square root of its
    area, so that a wide sky does not dominate, and more if it is like skin. It starts from the clusters of
    the previous picture, so each colour keeps its index; `restart` discards them. The result depends only on
    the pictures, not on threads.
    """

    def __init__(self) -> None:
        self._smoother = ExponentialSmoother()
        self._groups: np.ndarray | None = None
        self._shown: np.ndarray | None = None

    def restart(self) -> None:
        """Begin a scene: use the colours of the next picture without smoothing."""
        self._groups = self._shown = None
        self._smoother.restart()

    def follow(self, picture: Picture, time: float | None, table: np.ndarray) -> None:
        """Write the colours after this picture to a table, see `FilmTable`.

        Args:
            time: presentation time in seconds; None for a picture that stands alone.
        """
        if time is None or (self._groups is not None and len(self._groups) != table.shape[1]):
            self.restart()
        stretch = np.array([1, CHROMA_WEIGHT, CHROMA_WEIGHT])
        colors, weights = _binned(lab_from_rgb(small_colors(picture, MAX_SIDE_PX).reshape(-1, 3).T))
        colors *= stretch
        rounds = NEXT_ROUNDS
        if self._groups is None:
            self._groups, rounds = _seeds(colors, weights, table.shape[1]), FIRST_ROUNDS
        for _ in range(rounds):
            self._groups = _regrouped(colors, weights, self._groups)
        wanted = self._smoother.follow(self._groups, time, SETTLE_SECONDS) / stretch
        if self._shown is None:
            self._shown = wanted.copy()
        moved = np.square(wanted - self._shown).sum(axis=1) > MIN_COLOR_DIFFERENCE**2
        self._shown[moved] = wanted[moved]
        table[3:] = rgb_from_lab(self._shown.T)
        table[:3] = lab_from_rgb(table[3:].astype(float))


class FilmPalettes:
    """The tables of a style that hold colours of the film; false if there are none."""

    def __init__(self) -> None:
        self._tables: list[FilmTable] = []
        self._followed: list[FilmColors] = []

    def __bool__(self) -> bool:
        return bool(self._tables)

    def use(self, tables: Sequence[FilmTable]) -> None:
        """Write these tables from now on; their colours continue from the earlier tables."""
        self._tables = list(tables)
        self._followed += [FilmColors() for _ in self._tables[len(self._followed) :]]

    def follow(self, picture: Picture, time: float | None, is_cut: bool) -> None:
        """Write all tables for this picture, see `FilmColors.follow`."""
        for (table,), colors in zip(self._tables, self._followed, strict=False):
            if is_cut:
                colors.restart()
            colors.follow(picture, time, table)


def _binned(lab: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean colour of each cube of OKLab that holds any, n x 3, and its weight."""
    lightness, a, b = np.floor(lab * LIGHTNESS_BINS).astype(np.int64)  # -LIGHTNESS_BINS..LIGHTNESS_BINS
    _, cubes, counts = np.unique(
        (lightness * 3 * LIGHTNESS_BINS + a) * 3 * LIGHTNESS_BINS + b, return_inverse=True, return_counts=True
    )
    sums = np.stack([np.bincount(cubes.reshape(-1), part) for part in lab], axis=1)
    means = sums / counts[:, None]
    away = np.square((means[:, 1:] - SKIN_COLOR) / SKIN_HALF_DISTANCE).sum(axis=1)
    return means, np.sqrt(counts) * (1 + (SKIN_WEIGHT - 1) * 0.5**away)


def _seeds(colors: np.ndarray, weights: np.ndarray, count: int) -> np.ndarray:
    """Return the heaviest colour, then always the one that is heaviest and farthest from those taken."""
    taken = [int(weights.argmax())]
    away = np.full(len(colors), np.inf)
    while len(taken) < count:
        away = np.minimum(away, np.square(colors - colors[taken[-1]]).sum(axis=1))
        taken.append(int((weights * away).argmax()))
    return colors[taken]


def _regrouped(colors: np.ndarray, weights: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Return the mean of the colours that are nearest to each group.

    An empty cluster restarts with the colour that has the largest weighted distance from its cluster.
    """
    away = np.square(colors[:, None] - groups).sum(axis=2)
    nearest = away.argmin(axis=1)
    total = np.bincount(nearest, weights, len(groups))
    sums = np.stack([np.bincount(nearest, weights * part, len(groups)) for part in colors.T], axis=1)
    wrong = weights * away.min(axis=1)
    means = sums / np.maximum(total, 1e-9)[:, None]
    for empty in np.flatnonzero(total == 0):
        means[empty] = colors[wrong.argmax()]
        wrong[wrong.argmax()] = 0
    return means
