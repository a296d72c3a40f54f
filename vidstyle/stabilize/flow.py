"""Dense motion between two small copies of frames."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.core.sampling import percentiles
from vidstyle.stabilize.segment import SEGMENT_SIZE

# These numbers control where motion is estimated, and which estimates are accepted.
MIN_FLOW_SIDE_PX = 32
"""Smaller pictures are padded: OpenCV's search ends the process for some of them, such as 320 x 30 pixels."""
FLOW_GRID_PX = 2
"""Pixels of the copy between two samples of the stored flow, which are at least half a `SEGMENT_SIZE`
apart."""
MAX_STILL_CHANGE = 1
"""Mean change of the copy, in 8-bit codes, below which a picture counts as still."""
NOISE_AREA_PX = 5
"""Side of the area over which changes of the copy are averaged."""
MAX_STILL_SUM = MAX_STILL_CHANGE * NOISE_AREA_PX**2
"""`MAX_STILL_CHANGE` as a sum over the area, as `_change` returns it."""
MAX_RESIDUAL_RATIO = 3, 4
"""Motion is accepted if its residual is below this fraction (numerator, denominator) of the residual without
motion."""

# These numbers control the motion of marks.
FINE_STEP_COUNT = 8
"""Steps of the search for fine motion; more improve little."""
MIN_CONTRAST = 6
"""Local contrast of the copy, in 8-bit codes, from which one sees that something is at rest."""
WIDE_FACTOR = 4
"""Size of the neighbourhood that fills even areas, relative to the usual one."""
MIN_NEAR_WEIGHT = 0.2
"""Part of the usual neighbourhood in which motion must be known."""
MIN_CAMERA_MOTION_PX = 0.2
"""Median motion of visible structure, in pixels of the copy, from which the camera moves."""
MIN_OBJECT_MOTION_PX = 0.3
"""Least motion of objects that marks follow while the camera rests: they would tremble in still areas."""
MIN_OBJECT_CHANGE = 3
"""Least change by such an object, in 8-bit codes."""
EVEN_WEIGHT = 0.3
"""Weight of even areas that seem to rest: those in an object move with it."""
MIN_MARKS_MOTION_PX = 0.1
"""Least motion of marks after smoothing, in pixels of the copy."""


def _flow_estimator(is_fine: bool) -> Any:
    """Return a dense inverse search (Kroeger 2016) without variational refinement.

    Refinement doubles the time without improving stability. Patches are compared after subtracting their
    mean: otherwise they explain more of the change, but more noise becomes motion, and still areas flicker
    more. Use it for one pair of frames only: at some sizes, its next flow depends on earlier ones.

    Args:
        is_fine: search at half the size instead of a quarter: half the error, for three times the time.
    """
    estimator = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)
    estimator.setVariationalRefinementIterations(0)
    if is_fine:
        estimator.setFinestScale(1)
        estimator.setGradientDescentIterations(FINE_STEP_COUNT)
    return estimator


def flows(
    before: np.ndarray, now: np.ndarray, width: int, follows: bool
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return both flows of a `Warp` for a picture of this width; None if nothing moves.

    Args:
        follows: whether the second one is wanted.
    """
    change = _change(now, before)
    if min(now.shape) < 16 or change.max() <= MAX_STILL_SUM:
        return None, None
    flow = dense_flow(now, before, follows)
    is_better = _is_better(flow, now, before, change)
    if not is_better.any():
        return None, None
    marks_flow = _marks_flow(flow, is_better, change, now, width) if follows else None
    scale = np.float32(width / now.shape[1])
    return _in_grid(cv2.copyTo(flow, is_better.view(np.uint8)), width) * scale, marks_flow


def _in_grid(flow: np.ndarray, width: int) -> np.ndarray:
    """Return numbers for each pixel of the copy on the grid of a `Warp`."""
    return cv2.resize(flow, flow_grid(flow.shape, width), interpolation=cv2.INTER_AREA)


def _marks_flow(
    flow: np.ndarray, moves: np.ndarray, change: np.ndarray, now: np.ndarray, width: int
) -> np.ndarray:
    """Return smooth motion for marks, taken from the nearest places where it is known; see `Warp`.

    It is known where motion explains the change, and where something is seen and does not change.

    Args:
        flow: h x w x 2 float32.
        moves: where it explains the change, h x w bool.
        change: see `_change`.
        now: the copy of the frame.
        width: of the picture.
    """
    contrast = cv2.boxFilter(cv2.morphologyEx(now, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)), -1, (5, 5))
    shows, moved = contrast >= MIN_CONTRAST, cv2.copyTo(flow, moves.view(np.uint8))
    squared_speed = np.einsum("ijk,ijk->ij", moved, moved)
    rests = change <= MAX_STILL_SUM
    if shows.any() and percentiles(squared_speed[shows], (50,))[0] >= MIN_CAMERA_MOTION_PX**2:
        unseen = 0.0  # even areas only seem to rest
    else:
        moves = squared_speed >= MIN_OBJECT_MOTION_PX**2
        moves &= change > MIN_OBJECT_CHANGE * NOISE_AREA_PX**2
        moved, unseen = cv2.copyTo(flow, moves.view(np.uint8)), EVEN_WEIGHT
    weights = np.where(moves | (rests & shows), np.float32(1), np.float32(unseen))
    known = np.dstack([_in_grid(moved, width), _in_grid(weights, width)])
    columns, rows = known.shape[1::-1]
    small = (-(-columns // WIDE_FACTOR), -(-rows // WIDE_FACTOR))
    wide = cv2.resize(known, small, interpolation=cv2.INTER_AREA)
    wide = cv2.resize(cv2.GaussianBlur(wide, (0, 0), 2), (columns, rows))
    near = cv2.GaussianBlur(known, (7, 7), 1)
    near = np.where(near[..., 2:] >= MIN_NEAR_WEIGHT, near, wide)
    smooth = near[..., :2] / (near[..., 2:] + np.float32(1e-4))
    smooth[cv2.magnitude(*cv2.split(smooth)) < MIN_MARKS_MOTION_PX] = 0
    return smooth * np.float32(width / now.shape[1])


def flow_grid(shape: tuple[int, ...], width: int) -> tuple[int, int]:
    """Return width and height of the grid of a flow.

    Args:
        shape: of the copy in which motion is estimated.
        width: of the picture.
    """
    cell = max(FLOW_GRID_PX, round(SEGMENT_SIZE / 2 * shape[1] / width))
    return max(1, shape[1] // cell), max(1, shape[0] // cell)


def dense_flow(now: np.ndarray, before: np.ndarray, is_fine: bool = False) -> np.ndarray:
    """Return where each pixel was, relative to its place: h x w x 2 float32."""
    height, width = now.shape
    below, beside = max(0, MIN_FLOW_SIDE_PX - height), max(0, MIN_FLOW_SIDE_PX - width)
    if below or beside:
        now, before = (
            cv2.copyMakeBorder(each, 0, below, 0, beside, cv2.BORDER_REPLICATE) for each in (now, before)
        )
    flow: np.ndarray = _flow_estimator(is_fine).calc(now, before, None)
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
    found = np.empty(still.shape, np.uint8)
    _mark_better(_change(now, moved), still, found)
    return found.view(np.bool_)


@compiled
def _mark_better(moved, still, found):  # type: ignore[no-untyped-def]
    part, whole = MAX_RESIDUAL_RATIO
    for y in range(found.shape[0]):
        for x in range(found.shape[1]):
            better = whole * np.int32(moved[y, x]) < part * np.int32(still[y, x])
            found[y, x] = np.uint8(better and still[y, x] > MAX_STILL_SUM)
