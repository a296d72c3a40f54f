"""A mask that follows a film: found in every second frame, moved in between, and smoothed over time."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.stabilize.motion import MotionEstimator

FRAMES_PER_SEARCH = 2
"""Number of frames for which the mask is found once."""
MIN_WEIGHT = 0.35
"""Weight of a found mask where it agrees with the one before; it grows with the difference."""
FULL_WEIGHT_DIFFERENCE = 0.5
"""Difference from which a found mask replaces the one before."""


class SteadyMask:
    """Returns the mask of one frame after another; the results depend only on the frames.

    A scene cut, a pause and another size start again.

    Args:
        find: returns the mask of a picture, h x w float32, 0..1; h and w are always the same. Its second
            argument is whether the picture begins a scene or stands alone.
    """

    def __init__(self, find: Callable[[Picture, bool], np.ndarray]) -> None:
        self._find = find
        self._motion = MotionEstimator(0.0, False)
        self._mask: np.ndarray | None = None
        self._age = 0

    def follow(self, picture: Picture, time: float | None, is_cut: bool) -> np.ndarray:
        """Return the mask of the next frame; `time`: in seconds, None for a picture that stands alone."""
        if time is None:
            return self._find(picture, True)
        pair = self._motion.follow(picture, time, is_cut)
        if pair is None or self._mask is None:
            self._mask, self._age = self._find(picture, True), 0
            return self._mask
        moved = _moved(self._mask, pair.warp().flow, picture.shape)
        self._age += 1
        self._mask = moved if self._age % FRAMES_PER_SEARCH else _approach(moved, self._find(picture, False))
        return self._mask


def _moved(mask: np.ndarray, flow: np.ndarray | None, shape: tuple[int, int]) -> np.ndarray:
    """Return a mask moved by a flow in pixels of a picture of this shape; see `Warp.flow`."""
    if flow is None:
        return mask
    height, width = mask.shape
    scale = np.array([width / shape[1], height / shape[0]], np.float32)
    moves = cv2.resize(flow, (width, height), interpolation=cv2.INTER_LINEAR) * scale
    relative = cv2.INTER_LINEAR | cv2.WARP_RELATIVE_MAP
    both: object = None  # coordinates are in the first map
    return cv2.remap(mask, moves, both, relative, borderMode=cv2.BORDER_REPLICATE)  # type: ignore[call-overload]


def _approach(before: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Return a mask between the one before and a found one, nearer to the latter the more they differ."""
    growth = np.float32((1 - MIN_WEIGHT) / FULL_WEIGHT_DIFFERENCE)
    weight = np.minimum(np.float32(MIN_WEIGHT) + growth * cv2.absdiff(found, before), 1)
    return before + weight * (found - before)
