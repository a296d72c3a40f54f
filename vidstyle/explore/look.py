"""What a style makes of a small picture, and how far two such results are apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.explore.gates import fault
from vidstyle.explore.measure import METRIC_DEVIATIONS, Original, oklab_thumbnail, reduced
from vidstyle.explore.score import score
from vidstyle.style import Style

MAX_LOOK_SIDE_PX = 200
"""The longer side of the picture on which candidates are tried, in pixels."""
LOG_ODDS_DEVIATION, COLOR_DEVIATION = 2.0, 0.1
"""By how much the logarithm of the odds of the score, and colours in Oklab, usually differ."""


@dataclass(frozen=True, eq=False)
class Look:
    """What a style makes of a small picture.

    Attributes:
        picture: H x W x 3 uint8 RGB.
        signature: as `Original.signature` gives it.
        features: what taste is learned from: first how like shipped styles it is, then the measures, and the
            mean colour and its variation.
        fault: why it is not worth showing; empty if it is.
    """

    picture: np.ndarray
    signature: np.ndarray
    features: np.ndarray
    fault: str = ""


NewLooks = Callable[[Sequence[Style]], Sequence[Look | None]]
"""What styles make of the picture; None for those that cannot be used."""


def look_of(picture: np.ndarray, style: Style) -> Look | None:
    """What a style makes of a picture, H x W x 3 uint8, at a side of `MAX_LOOK_SIDE_PX`; None if it cannot be used."""
    original = _original(picture.tobytes(), picture.shape)
    try:
        drawn = original.drawn(style)
    except VidstyleError:
        return None
    measures = original.measure(drawn)
    colors = oklab_thumbnail(drawn).reshape(-1, 3)
    chance = min(max(score(measures), 0.01), 0.99)
    features = [np.log(chance / (1 - chance)) / LOG_ODDS_DEVIATION, *np.array(measures) / METRIC_DEVIATIONS]
    features += [*colors.mean(axis=0) / COLOR_DEVIATION, *colors.std(axis=0) / COLOR_DEVIATION]
    return Look(drawn, original.signature(drawn), np.array(features), fault(measures))


@lru_cache(2)
def _original(content: bytes, shape: tuple[int, ...]) -> Original:
    return Original(reduced(np.frombuffer(content, np.uint8).reshape(shape), MAX_LOOK_SIDE_PX))


def nearest(looks: Sequence[Look], taken: Sequence[Look]) -> np.ndarray:
    """The distance of each to the nearest of those taken; infinite where none is."""
    if not taken:
        return np.full(len(looks), np.inf)
    points, others = (np.array([each.signature for each in some]) for some in (looks, taken))
    return np.linalg.norm(points[:, None] - others[None], axis=-1).min(axis=1)


def look_distance(one: Look, other: Look) -> float:
    """How far two results are apart: 1 is plainly different."""
    return float(np.linalg.norm(one.signature - other.signature))
