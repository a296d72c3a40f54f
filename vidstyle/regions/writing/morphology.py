"""Minima, maxima and means of squares of pixels, for kernels: the same numbers as OpenCV's.

A padded plane has `margin` rows above and below the picture and `margin` columns to the right of it, more
than the radius of a filter. So a filter is a few loops over all numbers, which need no care at borders.
"""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled

MAX_PLAIN_SUM = 5
"""Side of squares up to which sums in a row do not move."""


@compiled
def greater(one, other):  # type: ignore[no-untyped-def]
    """The pick of a dilation."""
    return max(one, other)


@compiled
def less(one, other):  # type: ignore[no-untyped-def]
    """The pick of an erosion."""
    return min(one, other)


@compiled
def filter_squares(pick, neutral, plane, size, padding, spare, out):  # type: ignore[no-untyped-def]
    """Dilate or erode a padded plane by squares: `pick` is `greater` or `less`.

    Args:
        neutral: the number that `pick` prefers to no other: 0 or 255.
        plane: padded, all numbers in a row; its margins are overwritten.
        size: side of the squares, odd.
        padding: width of a padded row, and its margin.
        spare: another plane, overwritten.
        out: the result; may be `plane`.
    """
    _fill_margins(plane, np.uint8(neutral), padding)
    source, is_second = plane, False
    for stride in (1, padding[0]):
        window = 1
        while window < size:
            step = min(window, (size - window) // 2)
            # Both directions take the same number of passes, so the last one writes to `out`.
            target = out if is_second else spare
            count = source.size - 2 * step * stride
            after, last = source[step * stride :], source[2 * step * stride :]
            _pick(pick, source[:count], after, last, target[step * stride :])
            source, window, is_second = target, window + 2 * step, not is_second


@compiled
def _fill_margins(plane, value, padding):  # type: ignore[no-untyped-def]
    width, margin = padding
    end = plane.size - margin * width
    plane[: margin * width], plane[end:] = value, value
    for row_end in range((margin + 1) * width, end + 1, width):
        plane[row_end - margin : row_end] = value


@compiled(noalias=True)
def _pick(pick, first, second, third, out):  # type: ignore[no-untyped-def]
    for place in range(first.size):
        out[place] = pick(pick(first[place], second[place]), third[place])


@compiled
def average_squares(plane, size, padding, height, lines, out):  # type: ignore[no-untyped-def]
    """Compute means of squares, rounded to the nearest level; the picture is reflected at its borders.

    Args:
        plane, size, padding: see `filter_squares`.
        height: of the picture.
        lines: 2 x (W + size - 1) uint16, overwritten.
        out: the result, another plane.
    """
    (pitch, margin), radius = padding, size // 2
    width, columns, sums = pitch - margin, lines[0], lines[1, : pitch - margin]
    for y in range(height):
        start = (margin + y) * pitch
        inner = columns[radius : radius + width]
        _copy(plane[start : start + width], inner)
        for move in range(1, radius + 1):
            above = (margin + reflected(y - move, height)) * pitch
            below = (margin + reflected(y + move, height)) * pitch
            _add_two(plane[above : above + width], plane[below : below + width], inner)
        for place in range(radius):
            columns[place] = inner[reflected(place - radius, width)]
            columns[radius + width + place] = inner[reflected(width + place, width)]
        _copy(inner, sums)
        for move in range(1, radius + 1):
            _add_two(columns[radius - move :], columns[radius + move :], sums)
        _scale(sums, np.float32(1 / (size * size)), out[start : start + width])


@compiled(noalias=True)
def _copy(numbers, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] = numbers[x]


@compiled(noalias=True)
def _add_two(one, other, sums):  # type: ignore[no-untyped-def]
    for x in range(sums.size):
        sums[x] += one[x] + other[x]


@compiled(noalias=True)
def _scale(sums, factor, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] = np.int32(np.float32(sums[x]) * factor + np.float32(0.5))


@compiled
def average_floats(plane, size, scratch, out):  # type: ignore[no-untyped-def]
    """Compute means of squares of float32; the picture is reflected at its borders.

    Sums are moving sums as in OpenCV, in the same order, so that rounding is the same.

    Args:
        plane: H x W.
        size: side of the squares, odd.
        scratch: (H + 1) x W, and at least W + size - 1, both float64, overwritten.
        out: H x W; may be `plane`.
    """
    (height, width), radius, (sums, line) = plane.shape, size // 2, scratch
    for y in range(height):
        _copy(plane[y], line[radius : radius + width])
        for place in range(radius):
            line[place] = plane[y, reflected(place - radius, width)]
            line[radius + width + place] = plane[y, reflected(width + place, width)]
        _sum_row(line, size, sums[y])
    totals, factor = sums[height], 1 / (size * size)
    totals[:] = 0
    for y in range(-radius, radius):
        _add(sums[reflected(y, height)], totals)
    for y in range(height):
        first, last = reflected(y - radius, height), reflected(y + radius, height)
        _move_sums(sums[last], sums[first], factor, totals, out[y])


@compiled
def _sum_row(line, size, sums):  # type: ignore[no-untyped-def]
    """Sum up neighbours; only long sums move, as in OpenCV."""
    if size <= MAX_PLAIN_SUM:
        sums[:] = 0
        for place in range(size):
            _add(line[place:], sums)
        return
    total = 0.0
    for place in range(size):
        total += line[place]
    sums[0] = total
    for x in range(1, sums.size):
        total += line[x + size - 1] - line[x - 1]
        sums[x] = total


@compiled(noalias=True)
def _add(numbers, sums):  # type: ignore[no-untyped-def]
    for x in range(sums.size):
        sums[x] += numbers[x]


@compiled
def _move_sums(added, removed, factor, totals, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        total = totals[x] + added[x]
        out[x] = total * factor
        totals[x] = total - removed[x]


@compiled
def reflected(place, count):  # type: ignore[no-untyped-def]
    """The place within 0..count - 1 on which a place beyond the border is reflected."""
    while count > 1 and (place < 0 or place >= count):
        place = -place if place < 0 else 2 * (count - 1) - place
    return place if count > 1 else 0
