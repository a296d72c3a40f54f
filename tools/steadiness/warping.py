"""Measure changes between frames other than motion: the warping error of Lai et al. 2018.

"Learning Blind Video Temporal Consistency", European Conference on Computer Vision.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np


@dataclass(frozen=True)
class Motion:
    """The motion from a frame to the next.

    Attributes:
        flow: H x W x 2 float32, pixels to the right and down.
        visible: H x W bool, pixels that are visible in both frames and not on a motion boundary.
    """

    flow: np.ndarray
    visible: np.ndarray


def find_motion(first: np.ndarray, second: np.ndarray) -> Motion:
    """Estimate the motion between two frames, H x W x 3 uint8 RGB, by DIS optical flow in both directions."""
    search: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    one, other = (cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY) for frame in (first, second))
    forward, backward = search.calc(one, other, None), search.calc(other, one, None)
    return Motion(forward, find_visible_pixels(forward, backward))


def find_visible_pixels(forward: np.ndarray, backward: np.ndarray) -> np.ndarray:
    """Return the pixels of the first frame where two flows agree, H x W bool.

    With w the forward flow and v the backward flow at its target, these pixels are excluded: occlusions,
    |v + w|^2 > 0.01 (|v|^2 + |w|^2) + 0.5; motion boundaries, |grad w|^2 > 0.01 |w|^2 + 0.002; and pixels
    that leave the picture, which the paper does not mention.

    Args:
        forward, backward: H x W x 2, pixels to the right and down.
    """
    back = warp(backward, forward)
    is_occluded = _squared(back + forward) > 0.01 * (_squared(back) + _squared(forward)) + 0.5
    down = np.diff(forward, axis=0, append=forward[-1:])
    right = np.diff(forward, axis=1, append=forward[:, -1:])
    is_boundary = _squared(down) + _squared(right) > 0.01 * _squared(forward) + 0.002
    return _is_inside(forward) & ~is_occluded & ~is_boundary


def warp(picture: np.ndarray, flow: np.ndarray) -> np.ndarray:
    """Warp the second frame onto the first: sample it bilinearly where the flow leads from each pixel."""
    return cv2.remap(picture, *_targets(flow), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def warping_error(first: np.ndarray, second: np.ndarray, motion: Motion) -> float:
    """Return the mean squared difference of two frames along the motion, for values 0..1.

    Args:
        first, second: H x W x 3 uint8, two successive frames, restyled or not.
        motion: the motion of the source, which is not restyled.

    Returns:
        NaN if no pixel is visible in both frames.
    """
    if not motion.visible.any():
        return float("nan")
    one, other = (frame.astype(np.float32) / 255 for frame in (first, second))
    return float(np.square(one - warp(other, motion.flow))[motion.visible].mean(dtype=np.float64))


def _targets(flow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the columns and rows where a flow leads."""
    rows, columns = np.indices(flow.shape[:2], np.float32)
    return columns + flow[..., 0], rows + flow[..., 1]


def _is_inside(flow: np.ndarray) -> np.ndarray:
    (columns, rows), (height, width) = _targets(flow), flow.shape[:2]
    return np.asarray((columns >= 0) & (columns <= width - 1) & (rows >= 0) & (rows <= height - 1))


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.square(vectors).sum(axis=2)
