"""What the marks of a style follow: the page, or what moves on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from tools.steadiness.clips import Clip, restyled
from tools.steadiness.warping import find_motion, warped
from vidstyle.style import Style

FINE = 4
"""Structure that a Gaussian blur of so many pixels leaves is none of the marks."""
APART, EVERY = 2, 3
"""How many frames lie between the two of a pair, and from one pair to the next."""
MOVING = 3
"""The least way between the two, in pixels, of what counts as moving."""
LEAST = 2000
"""A pair with fewer moving pixels does not count."""


@dataclass(frozen=True)
class Way:
    """Where what moves in the second frame of a pair was in the first.

    Attributes:
        first: the number of the first frame.
        flow: H x W x 2 float32, pixels to the right and down, from the second frame to the first.
        moving: H x W bool, where it moves and `seen_in_both` knows how.
    """

    first: int
    flow: np.ndarray
    moving: np.ndarray


def ways_of(frames: Sequence[np.ndarray]) -> list[Way]:
    """The pairs of a film, H x W x 3 uint8 RGB, in which enough moves."""
    firsts = range(0, len(frames) - APART, EVERY)
    motions = [(first, find_motion(frames[first + APART], frames[first])) for first in firsts]
    ways = [Way(first, each.flow, each.seen & (_speed(each.flow) >= MOVING)) for first, each in motions]
    return [way for way in ways if way.moving.sum() >= LEAST]


def followed(frames: Sequence[np.ndarray], ways: Sequence[Way]) -> tuple[float, float]:
    """The correlation of the fine structure of luma with that of an earlier frame, where the film moves.

    Args:
        frames: H x W x 3 uint8 RGB each, restyled or not.
        ways: those of the film as it was, at least one.

    Returns:
        The mean over the pairs, as both frames lie on the page, and along the motion of the film.
    """
    pairs = [(_marks(frames[way.first]), _marks(frames[way.first + APART]), way) for way in ways]
    page = [_correlation(first, second, way) for first, second, way in pairs]
    along = [_correlation(warped(first, way.flow), second, way) for first, second, way in pairs]
    return float(np.mean(page)), float(np.mean(along))


def correlations(styles: Sequence[Style], clip: Clip, device: str) -> list[tuple[float, float]]:
    """What `followed` gives for each style on a clip, and last for the clip; NaN where too little moves."""
    ways = ways_of(clip.frames)
    if not ways:
        return [(float("nan"), float("nan"))] * (len(styles) + 1)
    films = [restyled(style, clip, device) for style in styles]
    return [followed(frames, ways) for frames in (*films, clip.frames)]


def _speed(flow: np.ndarray) -> np.ndarray:
    return np.hypot(flow[..., 0], flow[..., 1])


def _marks(frame: np.ndarray) -> np.ndarray:
    luma = cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(luma - cv2.GaussianBlur(luma, (0, 0), FINE))


def _correlation(first: np.ndarray, second: np.ndarray, way: Way) -> float:
    return float(np.corrcoef(first[way.moving], second[way.moving])[0, 1])
