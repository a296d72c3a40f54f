"""One plane of a picture, mixed with that of the picture before, which is moved along first."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from vidstyle.core.bands import in_bands
from vidstyle.core.kernels import compiled
from vidstyle.stabilize.warp import move_row

STILL = np.zeros((1, 1, 2), np.float32)
"""The flow of a film in which nothing moves."""
AROUND = 8
"""Rows of a band for each that is read beside it, so that few are worked on twice."""


@dataclass(frozen=True)
class Mix:
    """How much of the plane before is mixed in at each pixel.

    Attributes:
        share: of the plane before, 0..1.
        limit: change at which half of the share is left, in units of the result; infinite: none matters.
        guide: the weights of the luma plane, H x W float32, or None where there are none yet.
        step: luma pixels for each sample of this plane, across and down.
    """

    share: float
    limit: float = np.inf
    guide: np.ndarray | None = None
    step: tuple[int, int] = (1, 1)


def warp_and_blend(
    pool: Executor,
    plane: np.ndarray,
    scale: tuple[float, float],
    before: np.ndarray,
    flow: np.ndarray | None,
    mix: Mix,
) -> tuple[np.ndarray, np.ndarray]:
    """The plane with part of the one before in it.

    A change counts by its root mean square over 3 x 3 samples. With r for its square over that of the limit,
    the weight of the plane before is share * guide / (1 + r^2).

    Args:
        plane: H x W, of any type.
        scale: gain and offset that bring its codes to units of the result.
        before: what this function returned for the plane before, float32 or uint16, contiguous.
        flow: as in `Motion`, in luma pixels.

    Returns:
        The new plane, of the type of `before`, and the weights without share, H x W float32, 0..1.
    """
    out = np.empty(plane.shape, before.dtype)
    weights = np.empty(plane.shape, np.float32)
    flow = STILL if flow is None else flow / np.array(mix.step, np.float32)
    guide = np.ones((1, 1), np.float32) if mix.guide is None else mix.guide
    rate = np.float32(0 if np.isinf(mix.limit) else 1 / (9 * mix.limit**2))
    rounding = np.float32(0.5 if out.dtype == np.uint16 else 0)
    gain, offset = (np.float32(number) for number in scale)

    def run(top: int, bottom: int) -> None:
        _carry(
            plane, gain, offset, before, flow, np.float32(mix.share), rate, guide, *mix.step,
            rounding, weights, out, top, bottom,
        )  # fmt: skip

    in_bands(pool, (plane.shape[0], plane.shape[1]), AROUND, run)
    return out, weights


@compiled
def _carry(  # type: ignore[no-untyped-def]
    plane, gain, offset, before, flow, share, rate, guide, across, down, rounding, weights, out, top, bottom
):
    """A ring of three rows: what was before, moved along, and how much each sample has changed since."""
    height, width = plane.shape
    moved = np.empty((3, width), np.float32)
    changes = np.zeros((3, width + 2), np.float32)
    wide = np.empty((2, 2, width), np.float32)
    held = np.full(2, -1, np.int32)
    for row in range(top - 1, bottom + 1):
        y = min(max(row, 0), height - 1)
        line, change = moved[row % 3], changes[row % 3]
        move_row(before, y, flow, wide, held, line)
        if rate > 0:
            _change_of_row(plane[y], gain, offset, line, change)
        if row > top:
            done = row - 1
            _weigh_row(changes, rate, guide[min(done * down, guide.shape[0] - 1)], across, weights[done])
            _mix_row(plane[done], gain, offset, moved[done % 3], share, weights[done], rounding, out[done])


@compiled
def _change_of_row(now, gain, offset, line, change):  # type: ignore[no-untyped-def]
    for x in range(line.size):
        difference = now[x] * gain + offset - line[x]
        change[x + 1] = difference * difference
    change[0], change[line.size + 1] = change[1], change[line.size]


@compiled
def _weigh_row(changes, rate, guide, across, weights):  # type: ignore[no-untyped-def]
    one = np.float32(1)
    if rate > 0:
        first, second, third = changes[0], changes[1], changes[2]
        for x in range(weights.size):
            total = first[x] + first[x + 1] + first[x + 2]
            total += second[x] + second[x + 1] + second[x + 2]
            total += third[x] + third[x + 1] + third[x + 2]
            ratio = total * rate
            weights[x] = one / (one + ratio * ratio)
    else:
        weights[:] = one
    if guide.size > 1:
        for x in range(weights.size):
            weights[x] *= guide[min(x * across, guide.size - 1)]


@compiled
def _mix_row(now, gain, offset, line, share, weights, rounding, out):  # type: ignore[no-untyped-def]
    most = np.float32(65535)
    for x in range(out.size):
        value = now[x] * gain + offset
        value += share * weights[x] * (line[x] - value)
        out[x] = min(max(value + rounding, np.float32(0)), most) if rounding > 0 else value
