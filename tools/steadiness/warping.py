"""How much a film changes besides moving: the warping error of Lai et al. 2018.

"Learning Blind Video Temporal Consistency", European Conference on Computer Vision.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np


@dataclass(frozen=True)
class Motion:
    """How the pixels of a frame move to the next one.

    Attributes:
        flow: H x W x 2 float32, pixels to the right and down.
        seen: H x W bool, which pixels are to be seen in both frames and lie on no border of motion.
    """

    flow: np.ndarray
    seen: np.ndarray


def find_motion(first: np.ndarray, second: np.ndarray) -> Motion:
    """The motion between two frames, H x W x 3 uint8 RGB, by dense inverse search both ways."""
    search: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    one, other = (cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY) for frame in (first, second))
    forward, backward = search.calc(one, other, None), search.calc(other, one, None)
    return Motion(forward, seen_in_both(forward, backward))


def seen_in_both(forward: np.ndarray, backward: np.ndarray) -> np.ndarray:
    """Which pixels of the first frame the two flows, H x W x 2, tell alike: H x W bool.

    With w the forward flow and v the backward flow where it leads, left out are covered pixels,
    |v + w|^2 > 0.01 (|v|^2 + |w|^2) + 0.5, borders of motion, |grad w|^2 > 0.01 |w|^2 + 0.002, and, as the
    original does not say what is there, pixels that leave the picture.
    """
    back = warped(backward, forward)
    strayed = _squared(back + forward) > 0.01 * (_squared(back) + _squared(forward)) + 0.5
    down = np.diff(forward, axis=0, append=forward[-1:])
    right = np.diff(forward, axis=1, append=forward[:, -1:])
    border = _squared(down) + _squared(right) > 0.01 * _squared(forward) + 0.002
    return _stays(forward) & ~strayed & ~border


def warped(picture: np.ndarray, flow: np.ndarray) -> np.ndarray:
    """The second frame's picture, fetched to where its pixels were in the first, by bilinear samples."""
    return cv2.remap(picture, *_places(flow), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def warping_error(first: np.ndarray, second: np.ndarray, motion: Motion) -> float:
    """The mean squared difference of two frames along a motion, where it is seen, of values 0..1.

    Args:
        first, second: H x W x 3 uint8, the two frames of any film, restyled or not.
        motion: that of the film as it was.

    Returns:
        NaN where nothing of the first frame is seen in the second.
    """
    if not motion.seen.any():
        return float("nan")
    one, other = (frame.astype(np.float32) / 255 for frame in (first, second))
    return float(np.square(one - warped(other, motion.flow))[motion.seen].mean(dtype=np.float64))


def _places(flow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows to which a flow leads."""
    rows, columns = np.indices(flow.shape[:2], np.float32)
    return columns + flow[..., 0], rows + flow[..., 1]


def _stays(flow: np.ndarray) -> np.ndarray:
    (columns, rows), (height, width) = _places(flow), flow.shape[:2]
    return np.asarray((columns >= 0) & (columns <= width - 1) & (rows >= 0) & (rows <= height - 1))


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.square(vectors).sum(axis=2)
