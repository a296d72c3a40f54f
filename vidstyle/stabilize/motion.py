"""Motion between frames, and the noise level."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.core.picture import Picture
from vidstyle.stabilize.flow import flows
from vidstyle.stabilize.flow_masks import border_guide, fast_part

MAX_FLOW_SIDE_PX = 480
"""Maximum side of the copy in which motion is estimated, the picture repeatedly halved."""
MAX_JUMP_PX = 0.5
"""Maximum difference of motion between neighbours, in pixels of the copy, without a border of motion."""

# These numbers control how strongly the previous frame is blended into the current one.
MAX_GAP_SECONDS = 0.5
"""Stabilization resets after this time without a frame."""
MAX_WEIGHT = 0.9
"""Weight of the previous frame at `steady` 1; higher weights would freeze slow changes."""
RESULT_FACTOR = 0.6
"""Factor for the weight when blending the result of a style, whose input is already stabilized."""
MIN_MOTION_PX = 0.35
"""Minimum motion for which a result is warped, as each interpolation blurs lines slightly."""
MIN_LIMIT = 2.5 / 255
"""Minimum limit of change, for a film without noise."""
NOISE_FACTOR = 2.5
"""Limit of change in standard deviations of the noise."""

# These numbers control the estimation of noise.
NOISE_SAMPLE_COUNT = 160
"""Number of points along the longer side at which noise is measured."""
NOISE_PERCENTILE = 30
"""Percentile of the local Laplacian for estimating noise: low enough to exclude most textures."""


@dataclass(frozen=True)
class Warp:
    """How the previous frame is warped and blended into the current one.

    Attributes:
        weight: weight of the previous frame for unchanged pixels, 0..1.
        limit: change that halves the weight, relative to the distance from black to white.
        flow: previous position of each pixel relative to its current one, in pixels of the page to the right
            and down: h x w x 2 float32 on a coarse grid over the page; None if nothing moves.
        result_weight: weight of the previous result.
        is_fixed: whether the style draws marks that are fixed to the page.
        max_jump: maximum difference of flow between neighbours for blending a result, in pixels.
        marks_flow: `flow` for marks that move with the film: smooth, and also known in even areas.
    """

    weight: float
    limit: float
    flow: np.ndarray | None
    result_weight: float
    is_fixed: bool
    max_jump: float = np.inf
    marks_flow: np.ndarray | None = None

    @cached_property
    def result_flow(self) -> np.ndarray | None:
        """The flow by which a result is warped, 0 below `MIN_MOTION_PX`; None for 0, and for fixed marks."""
        if self.flow is None or self.is_fixed:
            return None
        return fast_part(self.flow, MIN_MOTION_PX)

    @cached_property
    def result_guide(self) -> np.ndarray:
        """Weights for blending a result, h x w x 1 float32 on the grid of the flow.

        Fixed marks are only blended where nothing moves, with weight 0 from `MIN_MOTION_PX` on. Other results
        are not blended along borders of motion, as filters mix both sides.
        """
        if self.flow is None:
            return np.ones((1, 1, 1), np.float32)
        if self.is_fixed:
            speed = cv2.magnitude(*cv2.split(self.flow))
            return np.clip(1 - speed / MIN_MOTION_PX, 0, 1)[..., None]
        return border_guide(self.flow, self.max_jump)


@dataclass(frozen=True)
class FramePair:
    """A frame and the previous one, from which `warp` estimates motion in any thread.

    Attributes:
        picture: the frame.
        before, now: reduced luma of the previous frame and of this one, uint8.
        weight: weight of the previous frame for unchanged pixels, 0..1.
        is_fixed: whether the style draws marks that are fixed to the page.
        follows: whether it draws marks that move with the film, which take finer motion.
    """

    picture: Picture
    before: np.ndarray
    now: np.ndarray
    weight: float
    is_fixed: bool
    follows: bool = False

    def warp(self) -> Warp:
        """Return the warp of the previous frame into this one."""
        width = self.picture.shape[1]
        limit = float(np.hypot(MIN_LIMIT, NOISE_FACTOR * noise_level(self.picture)))
        jump = MAX_JUMP_PX * width / self.now.shape[1]
        flow, marks_flow = flows(self.before, self.now, width, self.follows)
        return Warp(self.weight, limit, flow, RESULT_FACTOR * self.weight, self.is_fixed, jump, marks_flow)


class MotionEstimator:
    """Estimates motion and noise of the frames of a film.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style draws marks that are fixed to the page.
        follows: whether it draws marks that move with the film.
    """

    def __init__(self, steady: float, is_fixed: bool, follows: bool = False) -> None:
        self._follows = follows
        self.change_strength(steady, is_fixed)
        self._reduced: np.ndarray | None = None
        self._shape: tuple[int, int] | None = None
        self._time = 0.0

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        self._weight, self._is_fixed = MAX_WEIGHT * steady * (2 - steady), is_fixed

    def memory(self) -> list[np.ndarray]:
        """Return the reduced luma of the previous frame, if there is one."""
        return [] if self._reduced is None else [self._reduced]

    def follow(self, picture: Picture, time: float, scene_cut: bool) -> FramePair | None:
        """Return this frame with the previous one, or None at a scene cut; call it for each frame in order.

        Args:
            time: presentation time in seconds.
            scene_cut: whether this frame begins a scene.
        """
        before, self._reduced = self._reduced, reduced_luma(picture)
        elapsed, self._time = time - self._time, time
        continues = not scene_cut and self._shape == picture.shape
        self._shape = picture.shape
        if before is None or not continues or not 0 <= elapsed <= MAX_GAP_SECONDS:
            return None
        return FramePair(picture, before, self._reduced, self._weight, self._is_fixed, self._follows)


def reduced_luma(picture: Picture) -> np.ndarray:
    """Return luma, uint8, reduced by averaging."""
    plane = picture.luma if picture.color is None else picture.color
    assert plane is not None
    small = plane
    while max(small.shape[:2]) > MAX_FLOW_SIDE_PX and min(small.shape[:2]) > 1:
        height, width = small.shape[0] // 2, small.shape[1] // 2
        small = cv2.resize(small[: 2 * height, : 2 * width], (width, height), interpolation=cv2.INTER_AREA)
    if small.ndim == 3:
        small = small.astype(np.float32) @ picture.encoding.weights
    if small.dtype == np.uint8:
        return small.copy() if small is plane else small
    most = 2**picture.encoding.depth - 1 if picture.encoding.depth else 1
    return np.clip(small * np.float32(255 / most), 0, 255).astype(np.uint8)


def reduced_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return height and width of `reduced_luma` of a picture of this size."""
    height, width = shape
    while max(height, width) > MAX_FLOW_SIDE_PX and min(height, width) > 1:
        height, width = height // 2, width // 2
    return height, width


def noise_level(picture: Picture) -> float:
    """Estimate the standard deviation of the noise in luma, relative to the distance from black to white.

    See `plane_noise_level`.
    """
    plane = picture.luma if picture.color is None else picture.color[..., 1]
    assert plane is not None
    black, white = picture.encoding.luma_levels
    return plane_noise_level(plane) / (white - black)


def plane_noise_level(plane: np.ndarray) -> float:
    """Estimate the standard deviation of white noise in a plane, H x W, in its own units.

    Uses a Laplacian that cancels slopes (Immerkaer 1996) at scattered pixels, and a low percentile, so that
    most of a picture may be texture.
    """
    if min(plane.shape) < 3:
        return 0.0
    stride = -(-max(plane.shape) // NOISE_SAMPLE_COUNT)
    found = np.empty([-(-side // stride) for side in plane.shape], np.float32)
    _laplacian(plane, stride, found)
    # The Laplacian's gain is 6; this percentile of the size of a normal variable is 0.385 deviations.
    rank = found.size * NOISE_PERCENTILE // 100
    return float(np.partition(found, rank, axis=None)[rank]) / (6 * 0.385)


@compiled
def _laplacian(plane, stride, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        y = min(max(row * stride, 1), plane.shape[0] - 2)
        for column in range(out.shape[1]):
            x = min(max(column * stride, 1), plane.shape[1] - 2)
            corners = (
                np.float32(plane[y - 1, x - 1])
                + np.float32(plane[y - 1, x + 1])
                + np.float32(plane[y + 1, x - 1])
                + np.float32(plane[y + 1, x + 1])
            )
            sides = (
                np.float32(plane[y - 1, x])
                + np.float32(plane[y + 1, x])
                + np.float32(plane[y, x - 1])
                + np.float32(plane[y, x + 1])
            )
            out[row, column] = abs(corners - 2 * sides + 4 * np.float32(plane[y, x]))
