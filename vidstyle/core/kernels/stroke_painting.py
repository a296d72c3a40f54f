"""Paints brush strokes, from the uppermost down, with the marks of bristles."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import aligned_empty, cached, compiled, look_up_at
from vidstyle.core.white_noise import white_noise

TILE_SIZE = 8
"""Side of a tile in pixels: for each there is a list of the strokes that come near it. Tiles are fixed to
the page, and places are counted from their corners: rounding does not depend on where a band begins."""
QUARTER_SIZE = TILE_SIZE // 2
QUARTER_PIXELS = QUARTER_SIZE * QUARTER_SIZE
"""Pixels of a quarter of a tile, which are painted together. A constant, so that loops over them become a few
vectors without a rest, which would be rounded otherwise."""
MAX_BATCH_STROKES = 16
"""Strokes of which those are found that change a quarter, before these are painted: a pixel that strokes have
hidden by then needs no other."""
COSINE, SINE, ALONG, ACROSS, RED, GREEN, BLUE, SHOWN, OPEN = range(0, 9 * QUARTER_PIXELS, QUARTER_PIXELS)
"""Where in one array the numbers of these pixels lie: constants, by which the compiler sees that they do not
overlap. Of each pixel its place along and across its direction; `SHOWN` is the visible share of the
layers below, `OPEN` the same, but 0 if that share is too small to continue."""
MIN_OPEN_SHARE = 1 / 512
"""Minimum visible share of a pixel for which the strokes below are drawn."""
BRISTLE_SIZE = (16.0, 1.6)
"""Length and width of the marks of bristles, in pixels."""
FIRST_MARK_COLUMN, MARK_COLUMNS, MARK_LINES_BEFORE, MARK_LINES_BEHIND = 64, 512, 8, 32
"""Bristles of a stroke are those around one of the points (n, n) of white noise: from which number on, how
many there are, and how much less or more than n the row of a point may be."""
MAX_MARK_CODE = 255
"""The highest code of a mark."""


def paint_strokes(
    strokes: tuple[np.ndarray, np.ndarray],
    tiles: tuple[np.ndarray, np.ndarray],
    size: tuple[np.float32, np.float32],
    bristles: np.float32,
    pictures: tuple[np.ndarray, tuple[np.ndarray, np.ndarray] | None],
    page_row: int,
    out: np.ndarray,
) -> None:
    """Paint strokes over a picture.

    Args:
        strokes: columns and rows on the page of their middles, and more that is not read, 2 x n or larger;
            red, green and blue without the marks of bristles, and where these begin, 0 to
            `MARK_COLUMNS`, 4 x n.
        tiles: for each tile, from the one of `page_row` on, the numbers of the strokes that come near it, the
            uppermost first, rows x columns x most int32, and how many these are, rows x columns int32.
        size: half the length of a stroke's straight sides, and half its width.
        bristles: contrast of their marks.
        pictures: the picture to paint over, and the unit vectors that strokes follow, from
            `stroke_directions`; None for plain dots.
        page_row: the row of the page that is the first one of `out`.
        out: written.
    """
    most, (under, directions) = tiles[0].shape[2], pictures
    near, found, flags = np.empty((2, most), np.float32), np.empty(most, np.uint32), np.empty(most, np.uint32)
    scratch = aligned_empty((9 * QUARTER_PIXELS,)), near, found, flags
    scratch[0].fill(0)
    followed = (under,) if directions is None else (under, *directions)
    _paint(strokes, tiles, (*size, bristles), _bristle_marks(), followed, page_row, scratch, out)


@cached(maxsize=1)
def _bristle_marks() -> np.ndarray:
    """White noise along the diagonal: for each column its rows, in fours with the next row and column."""
    columns = np.arange(FIRST_MARK_COLUMN, FIRST_MARK_COLUMN + MARK_COLUMNS + MARK_LINES_BEHIND + 1)
    noise = white_noise(np.arange(columns[-1] + MARK_LINES_BEHIND + 1), columns)
    codes = np.rint(noise * np.float32(MAX_MARK_CODE)).astype(np.uint32)
    fours = codes[:-1, :-1] | codes[:-1, 1:] << 8 | codes[1:, :-1] << 16 | codes[1:, 1:] << 24
    rows = columns[:-1, None] + np.arange(-MARK_LINES_BEFORE, MARK_LINES_BEHIND)
    # No stroke uses the rows above the first point.
    return fours.view(np.int32)[rows, np.arange(len(rows))[:, None]].reshape(-1)[MARK_LINES_BEFORE:].copy()


@compiled(fastmath=True)
def _paint(strokes, tiles, looks, marks, pictures, page_row, scratch, out):  # type: ignore[no-untyped-def]
    """Quarter by quarter.

    Args:
        pictures: the picture to paint over, and directions unless strokes are plain dots: the compiler knows
            the length of a tuple.
    """
    (places, _), (lists, counts), near = strokes, tiles, scratch[1]
    for tile_row in range(counts.shape[0]):
        for tile_column in range(counts.shape[1]):
            number, listed = counts[tile_row, tile_column], lists[tile_row, tile_column]
            page_top, left = (page_row // TILE_SIZE + tile_row) * TILE_SIZE, tile_column * TILE_SIZE
            for k in range(number):
                i = np.uint32(listed[k])
                near[0, k], near[1, k] = places[0, i] - np.float32(left), places[1, i] - np.float32(page_top)
            for quarter in range(4):
                corner = quarter // 2 * QUARTER_SIZE, quarter % 2 * QUARTER_SIZE
                place = page_top - page_row + corner[0], left + corner[1]
                upper, lower = max(-place[0], 0), min(out.shape[0] - place[0], QUARTER_SIZE)
                shape = upper, lower, min(out.shape[1] - place[1], QUARTER_SIZE)
                if upper < lower and shape[2] > 0:
                    _begin(place, corner, shape, pictures, scratch[0])
                    _paint_quarter(strokes[1], listed, number, corner, looks, marks, pictures, scratch)
                    _end(place, shape, pictures[0], scratch[0], out)


@compiled(fastmath=True)
def _begin(place, corner, shape, pictures, pixels):  # type: ignore[no-untyped-def]
    """Begin a quarter without paint. Pixels outside the picture have the directions of earlier ones."""
    (upper, lower, width), half = shape, np.float32(0.5)
    if len(pictures) > 1:
        for row in range(upper, lower):
            for column in range(width):
                i, y, x = row * QUARTER_SIZE + column, place[0] + row, place[1] + column
                pixels[COSINE + i], pixels[SINE + i] = pictures[1][y, x], pictures[2][y, x]
    for i in range(QUARTER_PIXELS):
        x, y = (
            np.float32(corner[1] + i % QUARTER_SIZE) + half,
            np.float32(corner[0] + i // QUARTER_SIZE) + half,
        )
        pixels[ALONG + i], pixels[ACROSS + i] = x, y
        if len(pictures) > 1:
            cosine, sine = pixels[COSINE + i], pixels[SINE + i]
            pixels[ALONG + i], pixels[ACROSS + i] = x * cosine + y * sine, y * cosine - x * sine
        pixels[RED + i], pixels[GREEN + i], pixels[BLUE + i] = 0, 0, 0
        pixels[SHOWN + i], pixels[OPEN + i] = 1, 1


@compiled(fastmath=True)
def _paint_quarter(paints, listed, number, corner, looks, marks, pictures, scratch):  # type: ignore[no-untyped-def]
    (half_length, half_width, bristles), (pixels, near, found, flags) = looks, scratch
    edge, first, is_open = half_width + np.float32(0.5), 0, np.int32(1)
    while first < number and is_open:
        if len(pictures) > 1:
            end = min(first + MAX_BATCH_STROKES, number)
            count = _find_strokes(near, first, end, half_length, edge, pixels, found)
        else:
            end = number
            count = _find_dots(near, number, corner, edge, flags, found)
        for k in range(count):
            j = found[k]
            i = np.uint32(listed[j])
            x, y, red, green, blue = near[0, j], near[1, j], paints[0, i], paints[1, i], paints[2, i]
            if len(pictures) > 1:
                color = red, green, blue, paints[3, i]
                is_open = _lay_stroke(x, y, half_length, edge, color, bristles, marks, pixels)
            else:
                is_open = _lay_dot(x, y, edge, red, green, blue, pixels)
        first = end


@compiled(fastmath=True)
def _find_strokes(near, first, end, half_length, edge, pixels, found):  # type: ignore[no-untyped-def]
    """List the strokes that change a pixel; returns how many they are."""
    count, zero = np.uint32(0), np.float32(0)
    for k in range(first, end):
        x, y, changes = near[0, np.uint32(k)], near[1, np.uint32(k)], np.int32(0)
        for i in range(QUARTER_PIXELS):
            cosine, sine = pixels[COSINE + i], pixels[SINE + i]
            along, across = (
                pixels[ALONG + i] - x * cosine - y * sine,
                pixels[ACROSS + i] - y * cosine + x * sine,
            )
            beyond = max(abs(along) - half_length, zero)
            is_inside = beyond * beyond + across * across < edge * edge
            changes = np.int32(changes | np.int32(is_inside & (pixels[OPEN + i] > zero)))
        found[count] = k
        count = np.uint32(count + np.uint32(changes))
    return count


@compiled(fastmath=True)
def _find_dots(near, number, corner, edge, flags, found):  # type: ignore[no-untyped-def]
    """List the dots that come near; returns how many they are."""
    middle, reach, zero, count = (
        np.float32(QUARTER_SIZE / 2),
        np.float32((QUARTER_SIZE - 1) / 2),
        np.float32(0),
        np.uint32(0),
    )
    x, y = np.float32(corner[1]) + middle, np.float32(corner[0]) + middle
    for k in range(number):
        dx, dy = max(abs(near[0, k] - x) - reach, zero), max(abs(near[1, k] - y) - reach, zero)
        flags[k] = np.uint32(dx * dx + dy * dy < edge * edge)
    for k in range(number):
        found[count] = k
        count = np.uint32(count + flags[k])
    return count


@compiled(fastmath=True)
def _lay_dot(x, y, edge, red, green, blue, pixels):  # type: ignore[no-untyped-def]
    """Add a dot; returns whether anything below it can still be seen."""
    zero, one, least_share, is_open = np.float32(0), np.float32(1), np.float32(MIN_OPEN_SHARE), np.int32(0)
    red, green, blue = min(max(red, zero), one), min(max(green, zero), one), min(max(blue, zero), one)
    for i in range(QUARTER_PIXELS):
        dx, dy, visible = pixels[ALONG + i] - x, pixels[ACROSS + i] - y, pixels[OPEN + i]
        share = min(visible * max(edge - np.sqrt(dx * dx + dy * dy), zero), visible)
        pixels[RED + i] += share * red
        pixels[GREEN + i] += share * green
        pixels[BLUE + i] += share * blue
        shown = pixels[SHOWN + i] - share
        pixels[SHOWN + i], pixels[OPEN + i] = shown, shown if shown >= least_share else zero
        is_open = np.int32(is_open | np.int32(shown >= least_share))
    return is_open


@compiled(fastmath=True, noalias=True)
def _lay_stroke(x, y, half_length, edge, color, bristles, marks, pixels):  # type: ignore[no-untyped-def]
    """`_lay_dot` for a stroke, with the lightness of bristles: noise between its points."""
    zero, one, least_share, is_open = np.float32(0), np.float32(1), np.float32(MIN_OPEN_SHARE), np.int32(0)
    (red, green, blue, own), contrast = color, bristles * np.float32(1 / MAX_MARK_CODE)
    along_scale, across_scale = np.float32(1 / BRISTLE_SIZE[0]), np.float32(1 / BRISTLE_SIZE[1])
    per_column, last = np.float32(MARK_LINES_BEFORE + MARK_LINES_BEHIND - 1), np.int32(marks.size - 1)
    code = np.int32(MAX_MARK_CODE)
    for i in range(QUARTER_PIXELS):
        cosine, sine, visible = pixels[COSINE + i], pixels[SINE + i], pixels[OPEN + i]
        # The same for the opposite direction, which is the same direction.
        along = abs(pixels[ALONG + i] - x * cosine - y * sine)
        across = abs(pixels[ACROSS + i] - y * cosine + x * sine)
        beyond = max(along - half_length, zero)
        share = min(visible * max(edge - np.sqrt(beyond * beyond + across * across), zero), visible)
        right, down = own + along * along_scale, own + across * across_scale
        column, row = np.floor(right), np.floor(down)
        beside, below = right - column, down - row
        # Marks of pixels beyond the stroke, which are not used, may be outside.
        four = marks[look_up_at(min(np.int32(column * per_column + row), last))]
        upper, other = np.int32(four & code), np.int32((four >> np.int32(8)) & code)
        lower, another = np.int32((four >> np.int32(16)) & code), np.int32((four >> np.int32(24)) & code)
        high = np.float32(upper) + beside * np.float32(np.int32(other - upper))
        low = np.float32(lower) + beside * np.float32(np.int32(another - lower))
        mark = high + below * (low - high)
        pixels[RED + i] += share * min(max(red + contrast * mark, zero), one)
        pixels[GREEN + i] += share * min(max(green + contrast * mark, zero), one)
        pixels[BLUE + i] += share * min(max(blue + contrast * mark, zero), one)
        shown = pixels[SHOWN + i] - share
        pixels[SHOWN + i], pixels[OPEN + i] = shown, shown if shown >= least_share else zero
        is_open = np.int32(is_open | np.int32(shown >= least_share))
    return is_open


@compiled(fastmath=True)
def _end(place, shape, under, pixels, out):  # type: ignore[no-untyped-def]
    """What strokes leave open shows the picture under them."""
    upper, lower, width = shape
    for row in range(upper, lower):
        for column in range(width):
            i, y, x = row * QUARTER_SIZE + column, place[0] + row, place[1] + column
            out[y, x, 0] = pixels[RED + i] + pixels[SHOWN + i] * under[y, x, 0]
            out[y, x, 1] = pixels[GREEN + i] + pixels[SHOWN + i] * under[y, x, 1]
            out[y, x, 2] = pixels[BLUE + i] + pixels[SHOWN + i] * under[y, x, 2]
