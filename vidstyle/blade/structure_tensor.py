"""Structure tensor features, and the selection of filters by them.

Paper, section 5.3, equations 6 to 10: gradients from differences along the diagonals of 2 x 2 pixels, the
structure tensor smoothed by a Gaussian, and its orientation, strength and coherence in uniform bins. The
Gaussian has an even number of taps, so that its window is centred on the pixel, and the bins of orientation
are centred on its multiples: a rotated or mirrored picture then selects the rotated or mirrored filters.
In addition to the paper, bins can be divided by the curvature of lines, the change of orientation along them.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from vidstyle.blade.bins import MIDDLE_CURVATURE, Bins
from vidstyle.core.kernels import CACHE_LINE_FLOATS, aligned_parts, compiled, index_at, round_up

MAX_STRIP_COLUMNS = 256
"""Maximum columns of pixels for which a kernel keeps products: 8 rows fill half a first-level cache."""
MAX_PAIRS_AT_ONCE = 5
"""Maximum pairs of taps, symmetric about the middle of a window, that one iteration adds."""
MIN_DIVISOR = 1e-12
"""Added to divisors, so that a flat picture has coherence 0."""


def window_radius(rho: float) -> int:
    """Return the radius of the tensor's window in pixels."""
    return max(1, math.ceil(2 * rho))


@lru_cache(maxsize=64)
def window_weights(rho: float) -> np.ndarray:
    """Return the weights of the even Gaussian of standard deviation rho: float32, they add up to 1.

    >>> window_weights(0.5).round(3).tolist()
    [0.5, 0.5]
    """
    radius = window_radius(rho)
    weights = np.exp(-((np.arange(2 * radius) - radius + 0.5) ** 2) / (2 * max(rho, 0.1) ** 2))
    return (weights / weights.sum()).astype(np.float32)


def half_window(rho: float, step: int) -> np.ndarray:
    """Return the weights of one half of the window for selection, from its end to its middle: float32.

    The window is `window_weights`; for squares of 2 x 2 pixels it is the odd Gaussian that is centred on the
    middle of a square and one tap shorter.
    """
    radius = window_radius(rho)
    if step == 1:
        return window_weights(rho)[:radius]
    weights = np.exp(-((np.arange(1 - radius, 1)) ** 2) / (2 * max(rho, 0.1) ** 2))
    return (weights / (2 * weights.sum() - 1)).astype(np.float32)


def select_filters(
    luma: np.ndarray, bins: Bins, rho: float, margin: tuple[int, int] = (0, 0), top: int = 0
) -> np.ndarray:
    """Return the index of the filter for each square of `bins.pitch` pixels.

    Args:
        luma: H x W float32 0..1; beyond its border the border is repeated.
        bins: the quantization of the features.
        rho: standard deviation of the window in pixels.
        margin: numbers of first and last rows that need no filter.
        top: the number of luma's first row in the whole picture, whose squares begin at multiples of the
            pitch.

    Returns:
        int32, one for each square with any pixel in luma; a view of an array whose width is a multiple of
        `CACHE_LINE_FLOATS`. Undefined in the margin.
    """
    (height, width), step = luma.shape, bins.pitch
    lead, columns = top % step, round_up(width, CACHE_LINE_FLOATS) // step
    radius, edge = window_radius(rho), int(bins.curvatures > 1)
    strip = round_up(-(-columns // -(-columns * step // MAX_STRIP_COLUMNS)), CACHE_LINE_FLOATS)
    planes = 2 if bins.strengths * bins.coherences == 1 else 3
    wide = round_up((strip + 2 * edge + 1) * step + 2 * (radius - step), CACHE_LINE_FLOATS)
    window = _window(rho, step, planes * wide)
    taps = window[2].size
    products, narrow, halves, tensor, directions = aligned_parts(
        (taps, planes, wide),
        *[(planes * wide + taps,)] * 2,
        (planes, wide // step),
        (3, 2, strip + 2),
    )
    selected = np.empty((-(-(height + lead) // step), columns), np.int32)
    _select(
        np.ascontiguousarray(luma),
        window,
        bins.as_array,
        ((margin[0] + lead) // step, -(-(height - margin[1] + lead) // step)),
        (step - 1 - lead - radius, radius + 1 - step),
        (step, strip),
        (products, np.empty(taps, np.uint64), narrow, halves, tensor, directions),
        (products.reshape(-1), tensor.reshape(-1)),
        selected,
    )
    return selected[:, : -(-width // step)]


@lru_cache(maxsize=64)
def _window(rho: float, step: int, total: int) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    """Return arguments of `_weigh`: weights, pairs, and the start of the columns of each tap.

    Pairs are a tuple whose length is the number of pairs of taps that one iteration adds.
    """
    weights = half_window(rho, step)
    radius = len(weights)
    if step == 2:
        weights = np.append(weights[:-1], weights[-1] / 2)  # as a pair, the middle counts twice
    at_once = -(-radius // -(-radius // MAX_PAIRS_AT_ONCE))
    taps = np.arange(2 * radius + 1 - step)
    starts = (taps % step * (total // step) + taps // step).astype(np.uint64)
    return np.pad(weights, (0, -radius % at_once)), (0,) * at_once, starts


@compiled(fastmath=True)
def _select(luma, window, bins, rows, first, sides, scratch, flat, selected):  # type: ignore[no-untyped-def]
    """Select filters strip by strip, so that products of the last rows stay in the first-level cache.

    Args:
        window: from `_window`.
        rows: the first row of squares, and the row after the last.
        first: the first row of products of the first window, and the number of columns before luma.
        sides: side of a square in pixels, and of a strip in squares.
        scratch: the products of the last rows, and the start of the products of each tap; a row weighted
            vertically; its even, then its odd columns; the tensor; the directions of three rows.
        flat: the products and the tensor as one row each.
    """
    step, strip = sides
    for left in range(0, (luma.shape[1] + step - 1) // step, strip):
        columns = left, min(left + strip, selected.shape[1])
        _select_strip(luma, window, bins, rows, columns, first, step, scratch, flat, selected)


@compiled(fastmath=True)
def _select_strip(  # type: ignore[no-untyped-def]
    luma, window, bins, rows, columns, first, step, scratch, flat, selected
):
    """Select row by row: keep the products of the last rows, apply the window vertically, then horizontally.

    The products of a row are contiguous, so that one loop covers them all.
    """
    weights, pairs, column_starts = window
    products, row_starts, narrow, halves, tensor, directions = scratch
    taps, total = products.shape[0], products.shape[1] * products.shape[2]
    bottom, is_oriented_only = luma.shape[0] - 1, products.shape[1] == 2
    (left, right), (start, stop), width, is_curved = columns, rows, luma.shape[1], bins[3] > 1
    if is_curved:  # curvature depends on the directions around a pixel
        start, stop = max(start - 1, 0), min(stop + 1, luma.shape[0])
    lead = 1 if is_curved and left > 0 else 0
    # The columns of luma below the products; columns outside of luma have the products of its border.
    before = (left - lead) * step - first[1]
    outside, before = max(-before, 0), max(before, 0)
    behind = min(before + products.shape[2] - outside + 1, width)
    begun = first[0] + start * step
    for row in range(start, stop):
        end = first[0] + row * step + taps
        for last in range(begun, end):
            above = luma[min(max(last, 0), bottom)][before:behind]
            below = luma[min(max(last + 1, 0), bottom)][before:behind]
            _multiply(above, above[1:], below, below[1:], outside, products[last % taps])
        begun = end
        for tap in range(taps):
            row_starts[tap] = (end + tap) % taps * total
        for pair in range(0, weights.size, len(pairs)):
            _weigh(flat[0], row_starts, weights, pair, pairs, narrow[:total])
        if step == 2:
            _part(narrow, halves[: total // 2], halves[total // 2 :])
        for pair in range(0, weights.size, len(pairs)):
            _weigh(narrow if step == 1 else halves, column_starts, weights, pair, pairs, flat[1])
        right_part, up_part, chosen = tensor[0][lead:], tensor[1][lead:], selected[row][left:right]
        if is_oriented_only:
            _quantize_orientation(right_part, up_part, bins[0], chosen)
        else:
            _quantize(right_part, up_part, tensor[2][lead:], bins, chosen)
        if is_curved:
            inside = min(right + 1, width) - left + lead
            _find_directions(tensor[0], tensor[1], 1 - lead, inside, directions[row % 3])
            # The previous row, and also this row if it is the last.
            for middle in range(max(row - 1, rows[0]), min(row + (row + 1 == stop), rows[1])):
                above, below = directions[max(middle - 1, start) % 3], directions[min(middle + 1, row) % 3]
                chosen = selected[middle][left:right]
                _divide_by_curvature(above, directions[middle % 3], below, bins, chosen)


@compiled(fastmath=True, noalias=True)
def _multiply(above, above_right, below, below_right, before, products):  # type: ignore[no-untyped-def]
    """Compute products of the differences along both diagonals, between four pixels each.

    In the rotated axes of the differences the products are gx^2 - gy^2, 2 gx gy, and optionally gx^2 + gy^2,
    which only strength and coherence need. Beyond the border, the differences are between its two repeated
    pixels.
    """
    half, inside = np.float32(0.5), above_right.size
    # Rows are sliced before the loops: inside, the compiler would scatter their numbers one by one.
    rights, ups = products[0][before:], products[1][before:]
    if products.shape[0] == 2:
        for x in range(inside):
            falling, rising = below_right[x] - above[x], above_right[x] - below[x]
            rights[x] = falling * rising
            ups[x] = half * (falling - rising) * (falling + rising)
    else:
        totals = products[2][before:]
        for x in range(inside):
            falling, rising = below_right[x] - above[x], above_right[x] - below[x]
            rights[x] = falling * rising
            ups[x] = half * (falling - rising) * (falling + rising)
            totals[x] = half * (falling * falling + rising * rising)
    for first, last, column in ((0, before, 0), (before + inside, products.shape[1], inside)):
        falling = below[column] - above[column]
        for x in range(first, last):
            products[0][x], products[1][x] = -falling * falling, np.float32(0)
            if products.shape[0] > 2:
                products[2][x] = falling * falling


@compiled(fastmath=True, noalias=True)
def _weigh(numbers, starts, weights, pair, pairs, out):  # type: ignore[no-untyped-def]
    """Add some weighted pairs of taps to a total, or start it with the first ones.

    Args:
        starts: uint64, the index of the first number of each tap.
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
def _quantize(rights, ups, totals, bins, selected):  # type: ignore[no-untyped-def]
    """Quantize the weighted sums of the products of `_multiply` to the bins of a row."""
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    orientations, strengths, coherences = bins[0], bins[1], bins[2]
    least, last = np.float32(MIN_DIVISOR), np.int32(orientations * strengths * coherences) - 1
    for x in range(selected.shape[0]):
        right, up, total = rights[x], ups[x], totals[x]
        squared = right * right + up * up
        spread, other = np.sqrt(squared), np.sqrt(max(total * total - squared, zero))
        coherence = spread / (total + other + least)
        strength = np.sqrt(half * (total + spread))
        # With only one bin, the angle of half a turn would be in a second one.
        orientation = min(_orientation(right, up, orientations), orientations - one)
        level = np.floor(min(max((strength - bins[4]) * bins[5], zero), strengths - half))
        clearness = np.floor(min(max((coherence - bins[6]) * bins[7], zero), coherences - half))
        selected[x] = index_at((orientation * strengths + level) * coherences + clearness, last)


@compiled(fastmath=True)
def _orientation(right, up, orientations):  # type: ignore[no-untyped-def]
    """Return the bin of a doubled angle as a float: vectors multiply floats in half the time of integers."""
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    # The arctangent of Rajan et al. 2006, equation 10: off by 0.22 degrees at most.
    lower, higher = min(abs(right), abs(up)), max(abs(right), abs(up))
    slope = lower / (higher + np.float32(MIN_DIVISOR))
    angle = slope * (np.float32(math.pi / 4) + np.float32(0.273) * (one - slope))
    angle = np.float32(math.pi / 2) - angle if abs(up) > abs(right) else angle
    angle = np.float32(math.pi) - angle if right < zero else angle
    angle = -angle if up < zero else angle
    orientation = np.floor(angle * (orientations * np.float32(1 / (2 * math.pi))) + half)
    return orientation + orientations if orientation < zero else orientation


@compiled(fastmath=True, noalias=True)
def _quantize_orientation(rights, ups, orientations, selected):  # type: ignore[no-untyped-def]
    """Quantize a row if there is only one bin of strength and of coherence."""
    last = np.int32(orientations) - 1
    for x in range(selected.shape[0]):
        selected[x] = index_at(_orientation(rights[x], ups[x], orientations), last)


@compiled(fastmath=True, noalias=True)
def _find_directions(rights, ups, outside, inside, directions):  # type: ignore[no-untyped-def]
    """Compute cosine and sine of the doubled angle of a row's gradients; 1 and 0 without gradient.

    Args:
        outside: columns before the picture, 1 or 0; beyond the border its directions are repeated.
        inside: columns of the tensor within the picture.
        directions: 2 x N float32.
    """
    least = np.float32(MIN_DIVISOR)
    cosines, sines = directions[0][outside:], directions[1][outside:]
    for x in range(inside):
        right, up = rights[x], ups[x]
        factor = np.float32(1) / (np.sqrt(right * right + up * up) + least)
        cosines[x], sines[x] = (right + least) * factor, up * factor
    for row in (directions[0], directions[1]):
        row[0], row[outside + inside :] = row[outside], row[outside + inside - 1]


@compiled(fastmath=True, noalias=True)
def _divide_by_curvature(above, here, below, bins, selected):  # type: ignore[no-untyped-def]
    """Divide the bins of a row by the curvature of lines: the change of the gradient's angle a along them.

    With c and s, the cosine and sine of 2 a, the gradient of a is (c grad s - s grad c) / 2, and the line
    is perpendicular to it: the curvature is (cos a * down - sin a * across) / 4, with twice the gradient
    between the pixels on both sides. From c and s only one root is needed, for 1 + c if c is positive and
    otherwise for 1 - c, and there is only one division, at the end. Seen from its other end a line has the
    opposite curvature: of two opposite angles, the one within half a turn from the beginning of the first bin
    of orientation is used.
    """
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    curvatures, per_orientation = bins[3], np.int32(bins[1] * bins[2])
    middle, last, curve = half * curvatures, curvatures - one, np.float32(4 * math.sqrt(2) * MIDDLE_CURVATURE)
    # Rows are sliced before the loop: inside, the compiler would gather their numbers one by one.
    cosines, c_left, c_right = here[0, 1:], here[0], here[0, 2:]
    sines, s_left, s_right = here[1, 1:], here[1], here[1, 2:]
    c_above, s_above, c_below, s_below = above[0, 1:], above[1, 1:], below[0, 1:], below[1, 1:]
    for x in range(selected.size):
        c, s = cosines[x], sines[x]
        across = c * (s_right[x] - s_left[x]) - s * (c_right[x] - c_left[x])
        down = c * (s_below[x] - s_above[x]) - s * (c_below[x] - c_above[x])
        base = one + abs(c)
        steep = s * down - base * across
        bent = base * down - s * across if c >= zero else (steep if s >= zero else -steep)
        bent = -bent if s < zero and selected[x] >= per_orientation else bent
        share = bent / (abs(bent) + curve * np.sqrt(base))
        number = index_at(middle * (share + one), last)
        selected[x] = selected[x] * np.int32(curvatures) + number
