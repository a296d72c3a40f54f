"""Measure whether the marks of a style stay on the page or move with the objects of a film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from tools.steadiness.clips import Clip, restyle_clip
from tools.steadiness.warping import find_motion, warp
from vidstyle.style import Style

MARK_BLUR_PX = 4
"""Standard deviation of a Gaussian blur; fine structure is the luma minus its blur."""
FRAME_DISTANCE_FRAMES, PAIR_DISTANCE_FRAMES = 2, 3
"""Distance between the two frames of a pair, and between the first frames of successive pairs."""
MIN_MOTION_PX = 3
"""Minimum motion between the two frames of a pixel that counts as moving."""
MIN_MOVING_PIXELS = 2000
"""Pairs with fewer moving pixels are discarded."""


@dataclass(frozen=True)
class FramePair:
    """Two frames of a film, and the motion between them.

    Attributes:
        first: number of the first frame.
        flow: H x W x 2 float32, pixels to the right and down, from the second frame to the first.
        moving: H x W bool, pixels that move and whose motion is reliable (see `find_visible_pixels`).
    """

    first: int
    flow: np.ndarray
    moving: np.ndarray


def find_moving_pairs(frames: Sequence[np.ndarray]) -> list[FramePair]:
    """Return the pairs of frames with at least `MIN_MOVING_PIXELS` moving pixels.

    Args:
        frames: H x W x 3 uint8 RGB each, not restyled.
    """
    firsts = range(0, len(frames) - FRAME_DISTANCE_FRAMES, PAIR_DISTANCE_FRAMES)
    motions = [(first, find_motion(frames[first + FRAME_DISTANCE_FRAMES], frames[first])) for first in firsts]
    pairs = [
        FramePair(first, motion.flow, motion.visible & (_speed(motion.flow) >= MIN_MOTION_PX))
        for first, motion in motions
    ]
    return [pair for pair in pairs if pair.moving.sum() >= MIN_MOVING_PIXELS]


def correlate_marks(frames: Sequence[np.ndarray], pairs: Sequence[FramePair]) -> tuple[float, float]:
    """Correlate the fine structure of luma between the frames of each pair, where the source moves.

    Args:
        frames: H x W x 3 uint8 RGB each, restyled or not.
        pairs: from the frames of the source; at least one.

    Returns:
        The mean correlation over the pairs, -1..1: at the same place of the page, and along the motion.
    """
    marks = [
        (_fine_structure(frames[pair.first]), _fine_structure(frames[pair.first + FRAME_DISTANCE_FRAMES]))
        for pair in pairs
    ]
    page = [_correlation(first, second, pair) for (first, second), pair in zip(marks, pairs, strict=True)]
    along = [
        _correlation(warp(first, pair.flow), second, pair)
        for (first, second), pair in zip(marks, pairs, strict=True)
    ]
    return float(np.mean(page)), float(np.mean(along))


def compare_mark_motion(styles: Sequence[Style], clip: Clip, device: str) -> list[tuple[float, float]]:
    """Return the result of `correlate_marks` for each style and, last, for the clip; NaN without motion."""
    pairs = find_moving_pairs(clip.frames)
    if not pairs:
        return [(float("nan"), float("nan"))] * (len(styles) + 1)
    films = [restyle_clip(style, clip, device) for style in styles]
    return [correlate_marks(frames, pairs) for frames in (*films, clip.frames)]


def _speed(flow: np.ndarray) -> np.ndarray:
    return np.hypot(flow[..., 0], flow[..., 1])


def _fine_structure(frame: np.ndarray) -> np.ndarray:
    luma = cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(luma - cv2.GaussianBlur(luma, (0, 0), MARK_BLUR_PX))


def _correlation(first: np.ndarray, second: np.ndarray, pair: FramePair) -> float:
    return float(np.corrcoef(first[pair.moving], second[pair.moving])[0, 1])
