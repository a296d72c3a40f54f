"""Structure tensor features, and the selection of filters by them.

Paper, section 5.3, equations 6 to 10: gradients from differences along the diagonals of 2 x 2 pixels, the
structure tensor smoothed by a Gaussian, and its orientation, strength and coherence in uniform bins. The
Gaussian has an even number of taps, so that its window is centred on the pixel, and the bins of orientation
are centred on its multiples: a rotated or mirrored picture then selects the rotated or mirrored filters.
Beyond the paper, bins can be divided by the curvature of the lines, the change of orientation along them.
"""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from vidstyle.blade.bins import CURVE, Bins
from vidstyle.core.kernels import compiled, index_at

LANES = 8
"""Pixels that are filtered together in vector registers."""
UNROLLED = 64
"""Numbers that a compiled loop takes at a time; what is left over takes as long one by one."""
PAIRS_AT_ONCE = 5
"""The most pairs of products, equally far from the middle of a window, that are added in one go."""
EPSILON = 1e-12
"""Added to divisors: a flat picture has coherence 0."""


def window_radius(rho: float) -> int:
    """The radius of the tensor's window in pixels."""
    return max(1, math.ceil(2 * rho))


@lru_cache(maxsize=64)
def window_weights(rho: float) -> np.ndarray:
    """The weights of the even Gaussian of standard deviation rho: float32, they add up to 1.

    >>> window_weights(0.5).round(3).tolist()
    [0.5, 0.5]
    """
    radius = window_radius(rho)
    weights = np.exp(-((np.arange(2 * radius) - radius + 0.5) ** 2) / (2 * max(rho, 0.1) ** 2))
    return (weights / weights.sum()).astype(np.float32)


def half_window(rho: float, step: int) -> np.ndarray:
    """The weights of one half of the window in which filters are chosen, from its end to its middle: float32.

    Of `window_weights`, or where filters are chosen for squares of 2 x 2 pixels, of the odd Gaussian that is
    centred on the middle of a square and one tap shorter.
    """
    radius = window_radius(rho)
    if step == 1:
        return window_weights(rho)[:radius]
    weights = np.exp(-((np.arange(1 - radius, 1)) ** 2) / (2 * max(rho, 0.1) ** 2))
    return (weights / (2 * weights.sum() - 1)).astype(np.float32)


def select_filters(
    luma: np.ndarray, bins: Bins, rho: float, margin: tuple[int, int] = (0, 0), top: int = 0
) -> np.ndarray:
    """The index of the filter for each square of `bins.step` pixels.

    Args:
        luma: H x W float32 0..1; beyond its border the border is repeated.
        bins: the quantization of the features.
        rho: standard deviation of the window in pixels.
        margin: first and last rows that need no filter.
        top: the number of luma's first row in the whole picture, whose squares begin at multiples of `step`.

    Returns:
        int32, as many as there are squares of which luma has any pixel, part of an array whose width is that
        of a multiple of `LANES`; undefined in the margin.
    """
    step, weights, (height, width) = bins.step, half_window(rho, bins.step), luma.shape
    taps, radius, lead = 2 * len(weights) + 1 - step, len(weights), top % step
    if step == 2:
        weights = np.append(weights[:-1], weights[-1] / 2)  # as a pair, the middle counts twice
    at_once = -(-radius // -(-radius // PAIRS_AT_ONCE))
    columns = _rounded_up(width, LANES)
    wide = _rounded_up(columns + taps - 1, UNROLLED)
    taps_of_row = np.arange(taps)
    products = np.empty((taps, 3, wide), np.float32)
    tensor = np.empty((3, wide // step), np.float32)
    scratch = (
        products,
        np.empty(taps, np.uint64),
        np.empty(3 * wide + taps, np.float32),
        np.empty(3 * wide + taps, np.float32),
        (taps_of_row % step * (3 * wide // step) + taps_of_row // step).astype(np.uint64),
        tensor,
        np.empty((3, 2, columns + 2), np.float32),
    )
    selected = np.empty((-(-(height + lead) // step), columns // step), np.int32)
    _select(
        np.ascontiguousarray(luma),
        np.pad(weights, (0, -radius % at_once)),
        (0,) * at_once,
        bins.as_array,
        ((margin[0] + lead) // step, -(-(height - margin[1] + lead) // step)),
        (step - 1 - lead - radius, radius + 1 - step),
        step,
        scratch,
        products.reshape(-1),
        tensor.reshape(-1),
        selected,
    )
    return selected[:, : -(-width // step)]


def _rounded_up(number: int, multiple: int) -> int:
    return -(-number // multiple) * multiple


def pad_edges(luma: np.ndarray, margin: int, right: int = 0) -> np.ndarray:
    """Luma with its border repeated on all sides, by some more columns on the right."""
    sides = margin, margin, margin, margin + right
    return cv2.copyMakeBorder(np.ascontiguousarray(luma), *sides, cv2.BORDER_REPLICATE)


@compiled(fastmath=True)
def _select(  # type: ignore[no-untyped-def]
    luma, weights, pairs, bins, rows, first, step, scratch, flat_products, flat_sums, selected
):
    """Row by row; the products of the last rows are kept, the window is applied vertically, then across.

    The three products of a row are contiguous, so that one loop covers them all.

    Args:
        pairs: a tuple whose length is the number of pairs of taps that are added in one go.
        rows: the first row of squares, and the one after the last.
        first: the row of products with which the first window begins, and the columns in front of luma.
        scratch: the kept products, and where those of each tap begin; a row weighed vertically; its even and
            then its odd columns; where those of each tap begin; the tensor; the directions of three rows.
    """
    products, row_starts, narrow, halves, column_starts, tensor, directions = scratch
    taps, total, bottom = products.shape[0], 3 * products.shape[2], luma.shape[0] - 1
    is_curved = bins[3] > 1
    # The curvature in a row depends on those above and below it.
    start, stop = (max(rows[0] - 1, 0), min(rows[1] + 1, luma.shape[0])) if is_curved else rows
    begun = first[0] + start * step
    for row in range(start, stop):
        end = first[0] + row * step + taps
        for last in range(begun, end):
            above, below = luma[min(max(last, 0), bottom)], luma[min(max(last + 1, 0), bottom)]
            _multiply(above, above[1:], below, below[1:], first[1], products[last % taps])
        begun = end
        for tap in range(taps):
            row_starts[tap] = (end + tap) % taps * total
        for pair in range(0, weights.size, len(pairs)):
            _weigh(flat_products, row_starts, weights, pair, pairs, narrow[:total])
        if step == 2:
            _part(narrow, halves[: total // 2], halves[total // 2 :])
        for pair in range(0, weights.size, len(pairs)):
            _weigh(narrow if step == 1 else halves, column_starts, weights, pair, pairs, flat_sums)
        if bins[1] * bins[2] > 1:
            _quantize(tensor, bins, selected[row])
        else:
            _quantize_orientation(tensor, bins[0], selected[row])
        if is_curved:
            _find_directions(tensor, luma.shape[1], directions[row % 3])
            # The row before this one, and where there are no more rows, this one too.
            for middle in range(max(row - 1, rows[0]), min(row + (row + 1 == stop), rows[1])):
                above, below = directions[max(middle - 1, start) % 3], directions[min(middle + 1, row) % 3]
                _divide_by_curvature(above, directions[middle % 3], below, bins, selected[middle])


@compiled(fastmath=True, noalias=True)
def _multiply(above, above_right, below, below_right, before, products):  # type: ignore[no-untyped-def]
    """Squares and product of the differences along both diagonals, between four pixels each.

    Beyond the border, which is repeated, the differences are those between its two pixels.
    """
    half, inside = np.float32(0.5), above_right.size
    falls, mixed, rises = products[0], products[1], products[2]
    for x in range(inside):
        falling, rising = below_right[x] - above[x], above_right[x] - below[x]
        falls[before:][x] = half * falling * falling
        mixed[before:][x] = half * falling * rising
        rises[before:][x] = half * rising * rising
    for first, last, column in ((0, before, 0), (before + inside, falls.size, inside)):
        falling = below[column] - above[column]
        square = half * falling * falling
        for x in range(first, last):
            falls[x], mixed[x], rises[x] = square, -square, square


@compiled(fastmath=True, noalias=True)
def _weigh(numbers, starts, weights, pair, pairs, out):  # type: ignore[no-untyped-def]
    """Add some weighted pairs of taps to a total, or start it with the first ones.

    Args:
        starts: uint64, where the numbers of each tap begin.
    """
    one, other = starts[pair:], starts[starts.size - pair - len(pairs) :]
    for x in range(out.size):
        right = np.uint64(x)
        total = weights[pair] * (numbers[one[0] + right] + numbers[other[len(pairs) - 1] + right])
        for tap in range(1, len(pairs)):
            both = numbers[one[tap] + right] + numbers[other[len(pairs) - 1 - tap] + right]
            total += weights[pair + tap] * both
        out[x] = total if pair == 0 else out[x] + total


@compiled(fastmath=True, noalias=True)
def _part(row, even, odd):  # type: ignore[no-untyped-def]
    for x in range(even.size):
        even[x], odd[x] = row[2 * x], row[2 * x + 1]


@compiled(fastmath=True, noalias=True)
def _quantize(tensor, bins, selected):  # type: ignore[no-untyped-def]
    """The bins of a row. In the rotated axes of the differences, gx^2 - gy^2 is 2 b and 2 gx gy is a - c."""
    zero, half = np.float32(0), np.float32(0.5)
    orientations, strengths, coherences = bins[0], bins[1], bins[2]
    least, last = np.float32(EPSILON), np.int32(orientations * strengths * coherences) - 1
    for x in range(selected.shape[0]):
        a, b, c = tensor[0, x], tensor[1, x], tensor[2, x]
        right, up, total = b + b, a - c, a + c
        spread = np.sqrt(right * right + up * up)
        other = np.sqrt(max(a * c - b * b, zero))
        coherence = spread / (total + other + other + least)
        strength = np.sqrt(half * (total + spread))
        orientation = _orientation(right, up, orientations)
        level = np.floor(min(max((strength - bins[4]) * bins[5], zero), strengths - half))
        clearness = np.floor(min(max((coherence - bins[6]) * bins[7], zero), coherences - half))
        selected[x] = index_at((orientation * strengths + level) * coherences + clearness, last)


@compiled(fastmath=True)
def _orientation(right, up, orientations):  # type: ignore[no-untyped-def]
    """The bin of a doubled angle, a whole number as a float: vectors multiply floats in half the time."""
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    # The arctangent of Rajan et al. 2006, equation 10: off by 0.22 degrees at most.
    lower, higher = min(abs(right), abs(up)), max(abs(right), abs(up))
    slope = lower / (higher + np.float32(EPSILON))
    angle = slope * (np.float32(math.pi / 4) + np.float32(0.273) * (one - slope))
    angle = np.float32(math.pi / 2) - angle if abs(up) > abs(right) else angle
    angle = np.float32(math.pi) - angle if right < zero else angle
    angle = -angle if up < zero else angle
    orientation = np.floor(angle * (orientations * np.float32(1 / (2 * math.pi))) + half)
    return orientation + orientations if orientation < zero else orientation


@compiled(fastmath=True, noalias=True)
def _quantize_orientation(tensor, orientations, selected):  # type: ignore[no-untyped-def]
    """The bins of a row if there is one of strength and one of coherence."""
    last = np.int32(orientations) - 1
    for x in range(selected.shape[0]):
        a, b, c = tensor[0, x], tensor[1, x], tensor[2, x]
        selected[x] = index_at(_orientation(b + b, a - c, orientations), last)


@compiled(fastmath=True, noalias=True)
def _find_directions(tensor, width, directions):  # type: ignore[no-untyped-def]
    """Cosine and sine of the doubled angle of a row's gradients, 1 and 0 where there is none.

    Args:
        width: of the picture; the values at its ends are repeated on both sides.
        directions: 2 x N float32, starting one column to the left of the picture.
    """
    least = np.float32(EPSILON)
    cosines, sines = directions[0], directions[1]
    for x in range(width):
        a, b, c = tensor[0, x], tensor[1, x], tensor[2, x]
        right, up = b + b, a - c
        factor = np.float32(1) / (np.sqrt(right * right + up * up) + least)
        cosines[1:][x], sines[1:][x] = (right + least) * factor, up * factor
    for row in (cosines, sines):
        row[0], row[width + 1 :] = row[1], row[width]


@compiled(fastmath=True, noalias=True)
def _divide_by_curvature(above, here, below, bins, selected):  # type: ignore[no-untyped-def]
    """Divide the bins of a row by the curvature of lines: how fast their gradient's angle a turns on them.

    With c and s, the cosine and sine of 2 a, the gradient of a is (c grad s - s grad c) / 2, and the line
    runs a quarter turn further: the curvature is (cos a * down - sin a * across) / 4, with twice the gradient
    between the pixels on both sides. Of c and s only one root is needed, for 1 + c if c is positive and else
    for 1 - c, and none divides but the last. Seen from its other end a line has the other curvature: of two
    opposite angles that within half a turn from the beginning of the first bin of orientation is taken.
    """
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    curvatures, per_orientation = bins[3], np.int32(bins[1] * bins[2])
    middle, last, curve = half * curvatures, curvatures - one, np.float32(4 * math.sqrt(2) * CURVE)
    for x in range(selected.size):
        c, s = here[0, 1:][x], here[1, 1:][x]
        across = c * (here[1, 2:][x] - here[1, x]) - s * (here[0, 2:][x] - here[0, x])
        down = c * (below[1, 1:][x] - above[1, 1:][x]) - s * (below[0, 1:][x] - above[0, 1:][x])
        base = one + abs(c)
        steep = s * down - base * across
        bent = base * down - s * across if c >= zero else (steep if s >= zero else -steep)
        bent = -bent if s < zero and selected[x] >= per_orientation else bent
        share = bent / (abs(bent) + curve * np.sqrt(base))
        number = index_at(middle * (share + one), last)
        selected[x] = selected[x] * np.int32(curvatures) + number
