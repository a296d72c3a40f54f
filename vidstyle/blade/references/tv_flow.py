"""Total variation flow in two forms: the paper's, which is mean curvature motion, and the true flow."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from vidstyle.blade.references.rows import for_all_rows, require_positive
from vidstyle.core.kernels import compiled
from vidstyle.errors import UsageError

WHITE_LEVEL = 255
"""Both flows run on luma 0..255."""

MAX_CURVATURE_TIME_STEP = 0.25
"""Maximum time step of mean curvature motion, half of the stable limit."""

MIN_CURVATURE_GRADIENT = 1.0
"""Levels per pixel; in fainter gradients mean curvature motion becomes blurring."""

MIN_VARIATION_GRADIENT = 0.25
"""Levels per pixel; in fainter gradients true flow becomes blurring. Its time step is a quarter of this."""


def tv_flow(luma: np.ndarray, time: float = 2.0, gradient_power: int = 1) -> np.ndarray:
    """Return luma after total variation flow: u_t = |grad u|^gradient_power div(grad u / |grad u|).

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        time: duration of the flow. Power 1: in pixels^2; a disc of radius r shrinks to sqrt(r^2 - 2 time),
            independent of its contrast. Power 0: in levels of 255 times pixels; a disc of radius r keeps its
            size and loses 2 time / r levels.
        gradient_power: 1 is the form of Marquina and Osher 2000 that the paper uses (section 5.4.1, equation
            11). It equals mean curvature motion: it rounds shapes, removes small ones and keeps the contrast
            of the rest. 0 is the true flow, which lowers contrast until regions are flat.

    Returns:
        H x W float32, new.

    Raises:
        UsageError: time is not above 0, or gradient_power is neither 0 nor 1.
    """
    require_positive(time=time)
    if gradient_power not in (0, 1):
        raise UsageError("gradient_power", f"cannot be {gradient_power}", "choose 0 or 1")
    if gradient_power == 1:
        return _evolve(_move_by_curvature, luma, time, MAX_CURVATURE_TIME_STEP, MIN_CURVATURE_GRADIENT)
    return _evolve(_with_two_rows, luma, time, MIN_VARIATION_GRADIENT / 4, MIN_VARIATION_GRADIENT)


def _evolve(
    move: Callable[..., None], luma: np.ndarray, time: float, longest: float, faint: float
) -> np.ndarray:
    """Run explicit steps of equal length on pictures with a border of one pixel."""
    count = math.ceil(time / longest)
    now = np.pad(luma.astype(np.float32) * np.float32(WHITE_LEVEL), 1, mode="edge")
    then = np.empty_like(now)
    for _ in range(count):
        for_all_rows(move, luma.shape, now, np.float32(time / count), np.float32(faint**2), then)
        then[[0, -1]] = then[[1, -2]]
        then[:, [0, -1]] = then[:, [1, -2]]
        now, then = then, now
    return now[1:-1, 1:-1] / np.float32(WHITE_LEVEL)


@compiled(fastmath=True)
def _move_by_curvature(top, bottom, now, time, faint, then):  # type: ignore[no-untyped-def]
    """Add the second derivative along the level line, which equals |grad u| div(grad u / |grad u|).

    The weights of the nine pixels follow Alvarez and Morel 1994: exact for straight edges at multiples of 45
    degrees, and less smeared between these angles than with central differences. On peaks and in faint
    gradients, which have no level line, it is the mean over all directions, half the Laplacian. Curvature
    motion creates no new extremes; extremes that negative weights would create are clipped.
    """
    one, half, diagonal = np.float32(1), np.float32(0.5), np.float32(math.sqrt(0.5))
    whole = np.float32(2 + 4 * math.sqrt(0.5))
    for row in range(top + 1, bottom + 1):
        above, line, below = now[row - 1], now[row], now[row + 1]
        for x in range(1, now.shape[1] - 1):
            here, left, right, up, down = line[x], line[x - 1], line[x + 1], above[x], below[x]
            upper_left, upper_right = above[x - 1], above[x + 1]
            lower_left, lower_right = below[x - 1], below[x + 1]
            falling, rising = lower_right - upper_left, upper_right - lower_left
            slope_x = (right - left + diagonal * (falling + rising)) / whole
            slope_y = (down - up + diagonal * (falling - rising)) / whole
            scale = one / (slope_x * slope_x + slope_y * slope_y + faint)
            xx = (slope_x * slope_x + half * faint) * scale
            yy = (slope_y * slope_y + half * faint) * scale
            xy = slope_x * slope_y * scale
            mixed, twice = xy * xy, here + here
            speed = (yy - mixed - mixed) * (left + right - twice)
            speed += (xx - mixed - mixed) * (up + down - twice)
            speed += (mixed - half * xy) * (upper_left + lower_right - twice)
            speed += (mixed + half * xy) * (upper_right + lower_left - twice)
            lowest = min(min(min(left, right), min(up, down)), min(upper_left, upper_right))
            lowest = min(lowest, min(min(lower_left, lower_right), here))
            highest = max(max(max(left, right), max(up, down)), max(upper_left, upper_right))
            highest = max(highest, max(max(lower_left, lower_right), here))
            then[row, x] = min(max(here + time * speed, lowest), highest)


def _with_two_rows(top: int, bottom: int, now: np.ndarray, *arguments: object) -> None:
    _lower_variation(top, bottom, now, np.empty((2, now.shape[1] - 1), np.float32), *arguments)


@compiled(fastmath=True)
def _lower_variation(top, bottom, now, scratch, time, faint, then):  # type: ignore[no-untyped-def]
    """Descend the total variation, the sum of |grad u| over all cells of four pixels, most steeply.

    This is an exchange between neighbours, so the mean is kept and there is no overshoot.
    """
    half = np.float32(0.5)
    above, below = scratch[0], scratch[1]
    _divide_by_gradient(now[top], now[top + 1], half * time, faint, below)
    for row in range(top + 1, bottom + 1):
        above, below = below, above
        _divide_by_gradient(now[row], now[row + 1], half * time, faint, below)
        for x in range(1, now.shape[1] - 1):
            here = now[row, x]
            move = (above[x] + below[x]) * (now[row, x + 1] - here)
            move += (above[x - 1] + below[x - 1]) * (now[row, x - 1] - here)
            move += (above[x - 1] + above[x]) * (now[row - 1, x] - here)
            move += (below[x - 1] + below[x]) * (now[row + 1, x] - here)
            then[row, x] = here + move


@compiled(fastmath=True)
def _divide_by_gradient(upper, lower, factor, faint, cells):  # type: ignore[no-untyped-def]
    """Divide the factor by |grad u| in the cells between two rows; |grad u| from mean squares of slopes."""
    half = np.float32(0.5)
    for x in range(cells.shape[0]):
        across, across_lower = upper[x + 1] - upper[x], lower[x + 1] - lower[x]
        down, down_right = lower[x] - upper[x], lower[x + 1] - upper[x + 1]
        squares = across * across + across_lower * across_lower + down * down + down_right * down_right
        cells[x] = factor / np.sqrt(half * squares + faint)
