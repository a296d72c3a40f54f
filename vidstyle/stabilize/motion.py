"""Motion between frames, and the noise level."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.core.picture import Picture
from vidstyle.stabilize.segment import SEGMENT_SIZE

# These numbers control where motion is estimated, and which estimates are accepted.
MAX_FLOW_SIDE_PX = 480
"""Maximum side of the copy in which motion is estimated, the picture repeatedly halved."""
MIN_FLOW_SIDE_PX = 32
"""Smaller pictures are padded: OpenCV's search ends the process for some of them, such as 320 x 30 pixels."""
FLOW_GRID_PX = 2
"""Pixels of the copy between two samples of the stored flow, which are at least half a `SEGMENT_SIZE`
apart."""
MAX_STILL_CHANGE = 1
"""Mean change of the copy, in 8-bit codes, below which a picture counts as still."""
NOISE_AREA_PX = 5
"""Side of the area over which changes of the copy are averaged."""
MAX_RESIDUAL_RATIO = 3, 4
"""Motion is accepted if its residual is below this fraction (numerator, denominator) of the residual without
motion."""
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
    """

    weight: float
    limit: float
    flow: np.ndarray | None
    result_weight: float
    is_fixed: bool
    max_jump: float = np.inf

    @cached_property
    def result_flow(self) -> np.ndarray | None:
        """The flow by which a result is warped, 0 below `MIN_MOTION_PX`; None for 0, and for fixed marks."""
        if self.flow is None or self.is_fixed:
            return None
        moves = self._speed >= MIN_MOTION_PX
        return cv2.copyTo(self.flow, moves.view(np.uint8)) if moves.any() else None

    @cached_property
    def result_guide(self) -> np.ndarray:
        """Weights for blending a result, h x w x 1 float32 on the grid of the flow.

        Fixed marks are only blended where nothing moves, with weight 0 from `MIN_MOTION_PX` on. Other results
        are not blended along borders of motion, as filters mix both sides.
        """
        if self.flow is None:
            return np.ones((1, 1, 1), np.float32)
        if self.is_fixed:
            return np.clip(1 - self._speed / MIN_MOTION_PX, 0, 1)[..., None]
        return np.float32(1) - _jumps(self.flow, self.max_jump)[..., None]

    @property
    def _speed(self) -> np.ndarray:
        """Motion of each cell in pixels, h x w float32."""
        assert self.flow is not None
        return cv2.magnitude(*cv2.split(self.flow))


def _jumps(flow: np.ndarray, most: float) -> np.ndarray:
    """Mark cells that differ by more than `most` pixels from a neighbour, and their neighbours.

    Returns:
        h x w float32, 1 for marked cells and 0 for others.
    """
    found = np.zeros(flow.shape[:2], np.uint8)
    for axis in range(2):
        values = np.ascontiguousarray(flow[..., axis])
        found[:, 1:] |= cv2.absdiff(values[:, 1:], values[:, :-1]) > most
        found[1:] |= cv2.absdiff(values[1:], values[:-1]) > most
    return cv2.dilate(found, np.ones((3, 3), np.uint8)).astype(np.float32)


@dataclass(frozen=True)
class FramePair:
    """A frame and the previous one, from which `warp` estimates motion in any thread.

    Attributes:
        picture: the frame.
        before, now: reduced luma of the previous frame and of this one, uint8.
        weight: weight of the previous frame for unchanged pixels, 0..1.
        is_fixed: whether the style draws marks that are fixed to the page.
    """

    picture: Picture
    before: np.ndarray
    now: np.ndarray
    weight: float
    is_fixed: bool

    def warp(self) -> Warp:
        """Return the warp of the previous frame into this one."""
        width = self.picture.shape[1]
        limit = float(np.hypot(MIN_LIMIT, NOISE_FACTOR * noise_level(self.picture)))
        jump = MAX_JUMP_PX * width / self.now.shape[1]
        flow = _flow(self.before, self.now, width)
        return Warp(self.weight, limit, flow, RESULT_FACTOR * self.weight, self.is_fixed, jump)


class MotionEstimator:
    """Estimates motion and noise of the frames of a film.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style draws marks that are fixed to the page.
    """

    def __init__(self, steady: float, is_fixed: bool) -> None:
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
        return FramePair(picture, before, self._reduced, self._weight, self._is_fixed)


def _flow_estimator() -> Any:
    """Return a dense inverse search (Kroeger 2016) without variational refinement.

    Refinement doubles the time without improving stability. Patches are compared after subtracting their
    mean: otherwise they explain more of the change, but more noise becomes motion, and still areas flicker
    more. Use it for one pair of frames only: at some sizes, its next flow depends on earlier ones.
    """
    estimator = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    estimator.setVariationalRefinementIterations(0)
    return estimator


def _flow(before: np.ndarray, now: np.ndarray, width: int) -> np.ndarray | None:
    """Return the flow of a `Warp` for a picture of this width; None if nothing moves."""
    change = _change(now, before)
    if min(now.shape) < 16 or change.max() <= MAX_STILL_CHANGE * NOISE_AREA_PX**2:
        return None
    flow = _dense_flow(now, before)
    is_better = _is_better(flow, now, before, change)
    if not is_better.any():
        return None
    flow = cv2.copyTo(flow, is_better.view(np.uint8))
    scale = width / now.shape[1]
    cell = max(FLOW_GRID_PX, round(SEGMENT_SIZE / 2 / scale))
    grid = now.shape[1] // cell, now.shape[0] // cell
    return cv2.resize(flow, grid, interpolation=cv2.INTER_AREA) * np.float32(scale)


def _dense_flow(now: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return where each pixel was, relative to its place: h x w x 2 float32."""
    height, width = now.shape
    below, beside = max(0, MIN_FLOW_SIDE_PX - height), max(0, MIN_FLOW_SIDE_PX - width)
    padded = (cv2.copyMakeBorder(each, 0, below, 0, beside, cv2.BORDER_REPLICATE) for each in (now, before))
    flow: np.ndarray = _flow_estimator().calc(*padded, None)
    return flow[:height, :width]


def _change(now: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Sum differences over a neighbourhood, h x w uint16."""
    return cv2.boxFilter(
        cv2.absdiff(now, before), cv2.CV_16U, (NOISE_AREA_PX, NOISE_AREA_PX), normalize=False
    )


def _is_better(flow: np.ndarray, now: np.ndarray, before: np.ndarray, still: np.ndarray) -> np.ndarray:
    """Return where motion explains a change better than noise on a still picture, h x w bool.

    Args:
        still: the change without motion.
    """
    both: Any = None  # coordinates are in the first map
    relative = cv2.INTER_LINEAR | cv2.WARP_RELATIVE_MAP
    moved = cv2.remap(before, flow, both, relative, borderMode=cv2.BORDER_REPLICATE)
    part, whole = MAX_RESIDUAL_RATIO
    return (still > MAX_STILL_CHANGE * NOISE_AREA_PX**2) & (whole * _change(now, moved) < part * still)


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
