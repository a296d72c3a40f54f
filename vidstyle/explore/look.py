"""Small previews of styles, and the visual distance between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.explore.crops.full_size import FullSize
from vidstyle.explore.gates import doubt, fault
from vidstyle.explore.matching.appearance import appearance_of, appearance_point
from vidstyle.explore.measure import METRIC_DEVIATIONS, Original, oklab_thumbnail
from vidstyle.explore.score import score, verdict
from vidstyle.media.resize import reduce_picture
from vidstyle.style import Style

MAX_LOOK_SIDE_PX = 200
"""Maximum longer side of the picture on which candidates are tested."""
LOG_ODDS_DEVIATION, COLOR_DEVIATION = 2.0, 0.1
"""Typical deviation of the log-odds of the score, and of colours in Oklab."""


@dataclass(frozen=True, eq=False)
class Look:
    """The result of a style on a small picture.

    Attributes:
        picture: H x W x 3 uint8 RGB.
        signature: see `Original.signature`.
        features: the features for learning taste: similarity to shipped styles, metrics, mean colour and its
            deviation.
        fault: why it is rejected, or "".
        verdict: its score, and what speaks for and against it, in a line; "" if it was not measured.
    """

    picture: np.ndarray
    signature: np.ndarray
    features: np.ndarray
    fault: str = ""
    verdict: str = ""

    @cached_property
    def appearance(self) -> np.ndarray:
        """See `appearance_point`; it takes 40 ms."""
        return appearance_point(appearance_of(self.picture))


NewLooks = Callable[[Sequence[Style]], Sequence[Look | None]]
"""Renders looks of styles; None for invalid styles."""


def look_of(picture: np.ndarray, style: Style, crops: FullSize | None = None) -> Look | None:
    """Return the look of a style on a picture, H x W x 3 uint8; None if the style is invalid.

    Args:
        crops: of the picture at its full size; by default of `picture`.
    """
    original, own_crops = _original(picture.tobytes(), picture.shape)
    crops = crops or own_crops
    try:
        drawn = original.render(style)
        measures = original.measure(drawn)
        large = None if fault(measures) else crops.measure(style)
    except VidstyleError:
        return None
    worth = score(large) if large else 0.0
    reason = (fault(large) or doubt(worth)) if large and crops.is_large else fault(measures)
    colors = oklab_thumbnail(drawn).reshape(-1, 3)
    chance = min(max(worth, 0.01), 0.99)
    features = [np.log(chance / (1 - chance)) / LOG_ODDS_DEVIATION, *np.array(measures) / METRIC_DEVIATIONS]
    features += [*colors.mean(axis=0) / COLOR_DEVIATION, *colors.std(axis=0) / COLOR_DEVIATION]
    said = verdict(large) if large else ""
    look = Look(drawn, original.signature(drawn), np.array(features), reason, said)
    if not reason:
        look.appearance  # noqa: B018 - measured here, in a worker process, not while a screen is selected
    return look


@lru_cache(2)
def _original(content: bytes, shape: tuple[int, ...]) -> tuple[Original, FullSize]:
    picture = np.frombuffer(content, np.uint8).reshape(shape)
    return Original(reduce_picture(picture, MAX_LOOK_SIDE_PX)), FullSize(picture)


def nearest(looks: Sequence[Look], taken: Sequence[Look]) -> np.ndarray:
    """Return the distance of each look to the nearest in `taken`; infinite if `taken` is empty."""
    return _nearest([each.signature for each in looks], [each.signature for each in taken])


def nearest_appearance(looks: Sequence[Look], taken: Sequence[Look]) -> np.ndarray:
    """Return the appearance distance of each look to the nearest in `taken`; infinite if it is empty."""
    return _nearest([each.appearance for each in looks], [each.appearance for each in taken])


def _nearest(points: Sequence[np.ndarray], others: Sequence[np.ndarray]) -> np.ndarray:
    if not others:
        return np.full(len(points), np.inf)
    return np.linalg.norm(np.array(points)[:, None] - np.array(others)[None], axis=-1).min(axis=1)


def look_distance(one: Look, other: Look) -> float:
    """Return the distance between two looks; 1 is clearly different."""
    return float(np.linalg.norm(one.signature - other.signature))
