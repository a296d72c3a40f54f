"""Tests whether a picture is a mixture of two shots, as in a dissolve, a fade or a double exposure."""

from __future__ import annotations

import cv2
import numpy as np

DISSOLVE_SIZE_PX = (64, 36)
"""Width and height of the pictures that are tested."""
_TILE_SIZE_PX = (8, 6)
"""Width and height of the tiles in which mixtures are solved: in a part of them, nothing moves."""
_MIN_SHOT_DIFFERENCE = 0.03
"""Minimum root mean square difference of two shots within their tiles, 0..1."""
_SAME_SHOT_CORRELATION = 0.45
"""Pictures with a higher correlation within their tiles belong to one shot."""

# The limits were tuned on 23 dissolves of eight joined films, and on ten films without any.
_MIXED_SHARE_RANGE = (0.12, 0.88)
"""Range of the share of a shot in a mixture."""
_MAX_REST_RATIO = 0.45
"""Maximum residual of a tile as a mixture of two others, relative to their difference."""
_MIN_MIXED_ENERGY_SHARE, _MAX_MIXED_CONTRAST = 0.55, 0.95
"""Share of the difference that is in tiles with a small residual, and maximum contrast of the mixture."""
_MAX_SHARE_DEVIATION = 0.2
"""Maximum difference of a shot's share in a tile from its share in the whole picture."""
_MIN_FADED_ENERGY_SHARE, _MAX_FADED_CONTRAST = 0.6, 0.85
"""Share of one shot's contrast that is in tiles with the same share, and maximum contrast of the mixture."""

_MATCH_CORRELATION = 0.75
"""Correlation above which template matching has found a part of a picture in another: a camera move."""
_FADED_CONTRAST_RATIO = 0.6
"""Contrast of a picture, relative to another, below which it is faded."""


def dissolve_share(before: np.ndarray, picture: np.ndarray, after: np.ndarray) -> float | None:
    """Return the second shot's share in a mixture of two shots; None if the picture is no mixture.

    The mixture is solved by least squares in each tile without its mean, so that a change of light is no
    dissolve. The shares of the tiles agree in most of the picture: of both shots if little moves in them, or
    of the one that is still. Unlike a camera move, a mixture has less contrast than its shots.

    Args:
        before: H x W float32, as the others.
        picture: the one that may be a mixture.
        after: of the second shot.
    """
    first, mixed, last = (_tiles(each) for each in (before, picture, after))
    change = last - first
    strength = float(np.sqrt(np.mean(change**2)))
    if strength < _MIN_SHOT_DIFFERENCE or _correlation(first, last) > _SAME_SHOT_CORRELATION:
        return None
    share, agreeing = _solve_mixture(first, mixed, change)
    contrast = _energy(mixed) / max((1 - share) * _energy(first) + share * _energy(last), 1e-9)
    if _is_mixed(share) and agreeing > _MIN_MIXED_ENERGY_SHARE and contrast < _MAX_MIXED_CONTRAST:
        return share
    if abs(contrast) >= _MAX_FADED_CONTRAST:
        return None
    fading, rising = _faded_share(first, mixed), _faded_share(last, mixed)
    return rising if fading is None else 1 - fading


def _tiles(picture: np.ndarray) -> np.ndarray:
    """Return the tiles of a picture without their means, count x pixels."""
    width, height = _TILE_SIZE_PX
    parts = picture.reshape(picture.shape[0] // height, height, -1, width).transpose(0, 2, 1, 3)
    rows = parts.reshape(-1, width * height)
    return np.asarray(rows - rows.mean(axis=1, keepdims=True), np.float32)


def _solve_mixture(first: np.ndarray, mixed: np.ndarray, change: np.ndarray) -> tuple[float, float]:
    """Return the second shot's share, and the share of the change in tiles that agree with it."""
    energies = (change**2).sum(axis=1)
    share = _weighted_median(((mixed - first) * change).sum(axis=1) / (energies + 1e-6), energies)
    rests = ((mixed - first - share * change) ** 2).sum(axis=1)
    agrees = rests < _MAX_REST_RATIO**2 * energies
    return share, float(energies[agrees].sum() / energies.sum())


def _faded_share(shot: np.ndarray, mixed: np.ndarray) -> float | None:
    """Return the share of one shot in the mixture; None if it differs between the tiles."""
    energies = (shot**2).sum(axis=1)
    shares = (mixed * shot).sum(axis=1) / (energies + 1e-6)
    share = _weighted_median(shares, energies)
    agrees = np.abs(shares - share) < _MAX_SHARE_DEVIATION
    is_faded = float(energies[agrees].sum()) > _MIN_FADED_ENERGY_SHARE * energies.sum()
    return share if is_faded and _is_mixed(share) else None


def _is_mixed(share: float) -> bool:
    return _MIXED_SHARE_RANGE[0] < share < _MIXED_SHARE_RANGE[1]


def _weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    order = np.argsort(values)
    sums = np.cumsum(weights[order])
    return float(values[order][min(len(order) - 1, np.searchsorted(sums, sums[-1] / 2))])


def _energy(tiles: np.ndarray) -> float:
    return float((tiles**2).sum())


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Return the correlation of two pictures of mean 0; 0 if one is blank."""
    energy = float(np.sqrt(_energy(one) * _energy(other)))
    return float((one * other).sum()) / energy if energy > 1e-4 * one.size else 0.0


def is_camera_move(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether the middle of one picture is found in the other by template matching, both H x W, mean 0."""
    lower, higher = sorted((float(before.std()), float(after.std())))
    if lower < _FADED_CONTRAST_RATIO * higher:
        return False
    down, across = before.shape[0] // 4, before.shape[1] // 4
    for one, other in ((before, after), (after, before)):
        middle = np.ascontiguousarray(one[down:-down, across:-across])
        if cv2.matchTemplate(other, middle, cv2.TM_CCOEFF_NORMED).max() > _MATCH_CORRELATION:
            return True
    return False
