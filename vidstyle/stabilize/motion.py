"""Motion from frame to frame, and the level of noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.core.measured import Sampling
from vidstyle.core.picture import Picture

FLOW_SIDE = 480
"""Motion is estimated in a copy of at most this many pixels on a side."""
FLOW_GRID = 2
"""Pixels of that copy between two samples of the stored flow."""
MAX_GAP = 0.5
"""Seconds without a frame after which stabilization resets."""
MAX_WEIGHT = 0.9
"""Weight of the previous frame at `steady` 1; more would freeze slow changes."""
RESULT_FACTOR = 0.6
"""Factor on the weight for the result of a style, whose input is stabilized already."""
MIN_MOTION = 0.35
"""Minimum motion in pixels for which a result is warped, as each interpolation blurs lines a little more."""
MAX_RESIDUAL = 0.75
"""Motion is accepted where its residual is at most this multiple of the residual without motion."""
MIN_LIMIT = 2.5 / 255
"""Smallest limit of change, for a film without noise."""
NOISE_FACTOR = 2.5
"""Limit of change in standard deviations of the noise."""
NOISE_PERCENTILE = 30
"""Percentile of the local Laplacian that noise is estimated from: below that of most textures."""


@dataclass(frozen=True)
class Warp:
    """How the previous frame is warped and blended into the current one.

    Attributes:
        weight: of the previous frame where nothing has changed, 0..1.
        limit: change, as part of the way from black to white, that halves the weight.
        flow: where each pixel was, relative to where it is, in pixels of the page to the right and down:
            h x w x 2 float32 on a coarse grid over the page; None where everything stands still.
        result_weight: of the result before.
        is_fixed: whether the style makes marks that lie still on the page.
    """

    weight: float
    limit: float
    flow: np.ndarray | None
    result_weight: float
    is_fixed: bool

    @cached_property
    def result_flow(self) -> np.ndarray | None:
        """The flow that a result is warped by: none below `MIN_MOTION`, and none for marks that lie still."""
        if self.flow is None or self.is_fixed:
            return None
        moves = self._speed >= MIN_MOTION
        return self.flow * moves[..., None] if moves.any() else None

    @cached_property
    def stillness(self) -> np.ndarray | None:
        """Where marks that lie still are blended, as they may be nowhere else.

        Returns:
            h x w float32 on the grid of the flow, from 1 where nothing moves to 0 at `MIN_MOTION`; None: 1.
        """
        if self.flow is None or not self.is_fixed:
            return None
        return np.clip(1 - self._speed / MIN_MOTION, 0, 1)

    @property
    def _speed(self) -> np.ndarray:
        assert self.flow is not None
        speed: np.ndarray = np.hypot(self.flow[..., 0], self.flow[..., 1])
        return speed


class MotionEstimator:
    """Estimates motion and noise of the frames of a film.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style makes marks that lie still on the page.
    """

    def __init__(self, steady: float, is_fixed: bool) -> None:
        self.change_strength(steady, is_fixed)
        # The stubs require an initial flow, the function does not.
        self._estimator: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
        self._reduced: np.ndarray | None = None
        self._shape: tuple[int, int] | None = None
        self._time = 0.0

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        self._weight, self._is_fixed = MAX_WEIGHT * steady * (2 - steady), is_fixed

    def estimate(self, picture: Picture, time: float, scene_cut: bool) -> Warp | None:
        """The warp of the previous frame into this one; None at a scene cut.

        Args:
            time: presentation time in seconds.
            scene_cut: whether this frame begins a scene.
        """
        before, self._reduced = self._reduced, _reduced_luma(picture)
        elapsed, self._time = time - self._time, time
        continues = not scene_cut and self._shape == picture.shape
        self._shape = picture.shape
        if before is None or not continues or not 0 <= elapsed <= MAX_GAP:
            return None
        limit = float(np.hypot(MIN_LIMIT, NOISE_FACTOR * noise_level(picture)))
        flow = self._flow(before, picture.shape[1])
        return Warp(self._weight, limit, flow, RESULT_FACTOR * self._weight, self._is_fixed)

    def _flow(self, before: np.ndarray, width: int) -> np.ndarray | None:
        now = self._reduced
        assert now is not None
        if min(now.shape) < 16 or np.array_equal(now, before):
            return None
        flow: np.ndarray = self._estimator.calc(now, before, None)
        flow[~_is_better(flow, now, before)] = 0
        if not flow.any():
            return None
        grid = max(1, now.shape[1] // FLOW_GRID), max(1, now.shape[0] // FLOW_GRID)
        return cv2.resize(flow, grid, interpolation=cv2.INTER_AREA) * np.float32(width / now.shape[1])


def _is_better(flow: np.ndarray, now: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Where motion explains a change better than noise on a still picture would, h x w bool."""
    rows, columns = np.indices(now.shape, np.float32)
    moved = cv2.remap(
        before, columns + flow[..., 0], rows + flow[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    still, moving = (cv2.blur(cv2.absdiff(now, each).astype(np.float32), (5, 5)) for each in (before, moved))
    return moving < MAX_RESIDUAL * still


def _reduced_luma(picture: Picture) -> np.ndarray:
    """Luma, uint8, averaged down."""
    plane = picture.luma if picture.color is None else picture.color
    assert plane is not None
    height, width = picture.shape
    shrink = max(1.0, max(height, width) / FLOW_SIDE)
    size = max(1, round(width / shrink)), max(1, round(height / shrink))
    small = cv2.resize(plane, size, interpolation=cv2.INTER_AREA)
    if small.ndim == 3:
        small = small.astype(np.float32) @ picture.encoding.weights
    if small.dtype == np.uint8:
        return small
    most = 2**picture.encoding.depth - 1 if picture.encoding.depth else 1
    return np.clip(small * np.float32(255 / most), 0, 255).astype(np.uint8)


def noise_level(picture: Picture) -> float:
    """Standard deviation of the noise in luma, as part of the way from black to white.

    From a Laplacian that leaves no slope (Immerkaer 1996) at scattered pixels. A low percentile is taken,
    so that most of a picture may be texture.
    """
    plane = picture.luma if picture.color is None else picture.color[..., 1]
    assert plane is not None
    black, white = picture.encoding.luma_levels
    if min(plane.shape) < 3:
        return 0.0
    sampling = Sampling.of(*plane.shape)
    found = np.empty(sampling.shape, np.float32)
    _laplacian(plane, sampling.stride, *sampling.first, found)
    # The Laplacian's own gain is 6; that percentile of the size of a normal number is 0.385 deviations.
    return float(np.percentile(found, NOISE_PERCENTILE)) / (6 * 0.385 * (white - black))


@compiled
def _laplacian(plane, stride, top, left, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        y = min(max(top + row * stride, 1), plane.shape[0] - 2)
        for column in range(out.shape[1]):
            x = min(max(left + column * stride, 1), plane.shape[1] - 2)
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
