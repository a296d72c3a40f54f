"""Strokes: a painting in brush strokes of one colour each."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from vidstyle.block import REDRAW_RATE, FrameTime, PageRegion, SavedRef, Slider, block, drawing_at
from vidstyle.core.kernels import cached, compiled, look_up_at
from vidstyle.core.stroke_directions import stroke_directions
from vidstyle.core.white_noise import APART, PAIR_CODES, between_pair, pairs_of, white_noise

NUMBERS = 4
"""Random numbers of a stroke: its place across and down, which one it lies above, its tone."""
BRISTLE = (16.0, 1.6)
"""Length and width of the marks of bristles, in pixels."""
FIRST_MARK, MARKS, MARKS_BEFORE, MARKS_BEHIND = 64, 512, 8, 32
"""Bristles of a stroke are those around one of the points (n, n) of white noise: from which number on, how
many there are, and how much less or more than n the row of a point may be."""


GRAY_SPREAD = 0.15
"""What share of `colors` strokes of gray differ by, as against those of strong colour."""
LEAST_SHARE = 1 / 512
"""What of a pixel strokes have to leave open for those below to be drawn."""
SIDE = 8
PIXELS = SIDE * SIDE
"""Pixels of a block, which are painted together in vectors. Blocks are fixed to the page: what is left over
after whole vectors, which is rounded otherwise, does not depend on where a band begins."""
X, Y, COSINE, SINE, RED, GREEN, BLUE, SHOWN, ALONG, ACROSS, SQUARED = range(0, 11 * PIXELS, PIXELS)
"""Where in one array the numbers of these pixels lie: constants, by which the compiler sees that they do not
overlap."""
MOST_ACROSS = 5
"""Squares of the grid along a stroke, at most: a pixel has to look for strokes in all of them."""


def _radius(length: float, width: float) -> int:
    return math.ceil(max(length, width) / 2 + 1)


@block("filter", on="color", radius=_radius)
def strokes(
    picture: np.ndarray,
    place: PageRegion,
    moment: FrameTime,
    flow: Annotated[Any, SavedRef("smoothed result of `structure_tensor`")] = "source",
    under: Annotated[Any, SavedRef("picture that shows between strokes")] = "source",
    length: Annotated[float, Slider(2, 96, "length of a stroke", "px", explore=(8, 36))] = 24,
    width: Annotated[float, Slider(2, 64, "width of a stroke", "px", explore=(4, 12))] = 7,
    density: Annotated[float, Slider(0.25, 4, "strokes in each square of a stroke's width")] = 1,
    angle: Annotated[float, Slider(-90, 90, "direction where there are no edges", "degrees")] = 35,
    variation: Annotated[float, Slider(0, 1, "how much strokes differ in tone", explore=(0, 0.2))] = 0.1,
    colors: Annotated[
        float, Slider(0, 1, "how much strokes differ in colour; gray ones less", explore=(0, 0.2))
    ] = 0,
    bristles: Annotated[float, Slider(0, 1, "contrast of the marks of bristles", explore=(0, 0.5))] = 0.25,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Paint with strokes of one colour each, along the edges; with dots where they are as wide as long.

    A stroke lies at a random place in its square of a grid, has the colour of the picture in its middle, and
    bends with the flow; which of two lies above the other is random. All is fixed to the page until it is
    drawn anew. Haeberli 1990, "Paint by Numbers: Abstract Image Representations".
    """
    reach, (height, columns) = _radius(length, width), picture.shape[:2]
    pitch = np.float32(max(width / math.sqrt(density), max(length, width) / MOST_ACROSS))
    # The squares of the grid in which a stroke may lie that is seen here.
    around = math.ceil(reach / pitch) + 1
    above, left = math.floor(place.top / pitch) - around, -around
    below, right = math.ceil((place.top + height) / pitch) + around, math.ceil(columns / pitch) + around
    squares = (above, below), (left, right)
    strokes_ = _strokes_in(squares, drawing_at(moment, rate) * APART, float(pitch), place.top)
    size = np.float32(max(length - width, 0) / 2), np.float32(width / 2)
    # The first row of blocks, those of the picture, and one after them.
    rows = place.margin[0] - (place.top + place.margin[0]) % SIDE, place.margin[0], height - place.margin[1]
    blocks = -(-(rows[2] - rows[0]) // SIDE), -(-columns // SIDE)
    near = (math.ceil((SIDE + 2 * reach) / pitch) + 1) ** 2
    lists, counts = np.empty((*blocks, near), np.int32), np.zeros(blocks, np.int32)
    _sort_into_blocks(strokes_, size[0] + size[1] + np.float32(0.5), rows[0], lists, counts)
    looks = np.float32(variation), np.float32(colors), np.float32(bristles)
    scratch, out = (np.empty(11 * PIXELS, np.float32), lists, counts), np.empty(picture.shape, np.float32)
    directions, pictures = stroke_directions(flow, angle), (picture, under)
    led = (0, 0) if bristles or length > width else (0,)
    _paint(strokes_, size, looks, _bristle_marks(), directions, pictures, led, scratch, rows, out)
    return out


@cached(maxsize=64)
def _strokes_in(
    squares: tuple[tuple[int, int], tuple[int, int]], drawing: int, pitch: float, top: int
) -> np.ndarray:
    """The strokes of rows and columns of squares, the uppermost first; those of the last few bands are kept.

    Returns:
        n x NUMBERS float32: column and row of its middle, counted from row `top`; its place in the order; its
        tone.
    """
    (above, below), (left, right) = squares
    numbers = white_noise(np.arange(above, below) + drawing, np.arange(left * NUMBERS, right * NUMBERS))
    strokes_ = np.ascontiguousarray(numbers.reshape(below - above, right - left, NUMBERS))
    strokes_[..., 0] = (np.arange(left, right, dtype=np.float32) + strokes_[..., 0]) * np.float32(pitch)
    rows = np.arange(above, below, dtype=np.float32)[:, None]
    strokes_[..., 1] = (rows + strokes_[..., 1]) * np.float32(pitch) - np.float32(top)
    strokes_ = strokes_.reshape(-1, NUMBERS)
    return strokes_[np.argsort(-strokes_[:, 2], kind="stable")]


@cached(maxsize=1)
def _bristle_marks() -> np.ndarray:
    """White noise along the diagonal: for each column its rows, in pairs with the next column."""
    columns = np.arange(FIRST_MARK, FIRST_MARK + MARKS + MARKS_BEHIND + 1)
    noise = white_noise(np.arange(columns[-1] + MARKS_BEHIND), columns)
    pairs = pairs_of(noise)
    rows = columns[:-1, None] + np.arange(-MARKS_BEFORE, MARKS_BEHIND)
    return np.ascontiguousarray(pairs[rows, np.arange(len(rows))[:, None]]).reshape(-1)


@compiled
def _sort_into_blocks(strokes_, edge, top, lists, counts):  # type: ignore[no-untyped-def]
    """List, for each block of pixels, the strokes that come near it, in their order."""
    side, least, most = np.float32(SIDE), np.float32(0.5), np.float32(SIDE - 0.5)
    for i in range(strokes_.shape[0]):
        x, y = strokes_[i, 0], strokes_[i, 1] - np.float32(top)
        left, right = max(int((x - edge) / side), 0), min(int((x + edge) / side) + 1, counts.shape[1])
        upper, lower = max(int((y - edge) / side), 0), min(int((y + edge) / side) + 1, counts.shape[0])
        for row in range(upper, lower):
            down = y - np.float32(row) * side
            dy = max(least - down, down - most, np.float32(0))
            for column in range(left, right):
                across = x - np.float32(column) * side
                dx = max(least - across, across - most, np.float32(0))
                if dx * dx + dy * dy < edge * edge and counts[row, column] < lists.shape[2]:
                    lists[row, column, counts[row, column]] = i
                    counts[row, column] += 1


@compiled(fastmath=True)
def _paint(strokes_, size, looks, marks, directions, pictures, led, scratch, rows, out):  # type: ignore[no-untyped-def]
    """Block by block, from the uppermost stroke down.

    Args:
        led: a tuple of two where directions matter, of one for plain dots: the compiler knows its length.
    """
    (picture, under), (pixels, lists, counts), height, width = pictures, scratch, out.shape[0], out.shape[1]
    (variation, colors, bristles), half, edge = looks, np.float32(0.5), size[0] + size[1] + np.float32(0.5)
    for block_row in range(counts.shape[0]):
        for block_column in range(counts.shape[1]):
            place, still_open = (rows[0] + block_row * SIDE, block_column * SIDE), PIXELS
            _begin(place, directions, pixels)
            for k in range(counts[block_row, block_column]):
                stroke = strokes_[lists[block_row, block_column, k]]
                x, y, tone = stroke[0], stroke[1], stroke[3]
                down = y - np.float32(place[0])
                first, last = max(int(down - edge), 0), min(int(down + edge) + 1, SIDE)
                part, number = pixels[first * SIDE :], (last - first) * SIDE
                if _find(x, y, size, led, part, number) == 0:
                    continue
                color = picture[min(max(int(y), 0), height - 1), min(max(int(x), 0), width - 1)]
                strength = max(color[0], color[1], color[2]) - min(color[0], color[1], color[2])
                spread = colors * min(np.float32(GRAY_SPREAD) + strength, np.float32(1))
                more, less = tone * np.float32(7), tone * np.float32(13)
                more, less = spread * (more - np.floor(more) - half), spread * (less - np.floor(less) - half)
                change = variation * (tone - half)
                red, green, blue = color[0] + more, color[1] - half * (more + less), color[2] + less
                shade = red + change, green + change, blue + change
                if len(led) > 1:
                    _mark(tone * np.float32(MARKS), bristles, marks, part, number)
                still_open -= _lay(size[1], shade, led, part, number)
                if still_open == 0:
                    break
            _end(place, rows, under, pixels, out)


@compiled(fastmath=True)
def _begin(place, directions, pixels):  # type: ignore[no-untyped-def]
    """Nothing is painted yet. Pixels beyond the picture are those at its edge."""
    (cosines, sines), half, (top, left) = directions, np.float32(0.5), place
    last_row, last_column = cosines.shape[0] - 1, cosines.shape[1] - 1
    for row in range(SIDE):
        for column in range(SIDE):
            i, y, x = row * SIDE + column, min(max(top + row, 0), last_row), min(left + column, last_column)
            pixels[X + i], pixels[Y + i] = np.float32(x) + half, np.float32(top + row) + half
            pixels[COSINE + i], pixels[SINE + i], pixels[SHOWN + i] = cosines[y, x], sines[y, x], 1
            pixels[RED + i], pixels[GREEN + i], pixels[BLUE + i] = 0, 0, 0


@compiled(fastmath=True)
def _find(x, y, size, led, pixels, number):  # type: ignore[no-untyped-def]
    """Where the first pixels lie on a stroke; returns how many of them it changes."""
    (half_length, half_width), zero, found = size, np.float32(0), np.int32(0)
    edge, least_share = half_width + np.float32(0.5), np.float32(LEAST_SHARE)
    for i in range(number):
        dx, dy = pixels[X + i] - x, pixels[Y + i] - y
        squared = dx * dx + dy * dy
        if len(led) > 1:
            cosine, sine = pixels[COSINE + i], pixels[SINE + i]
            # The same for the opposite direction, which is the same direction.
            along, across = abs(dx * cosine + dy * sine), abs(dy * cosine - dx * sine)
            beyond = max(along - half_length, zero)
            squared = beyond * beyond + across * across
            pixels[ALONG + i], pixels[ACROSS + i] = along, across
        pixels[SQUARED + i] = squared
        found = np.int32(found + np.int32((squared < edge * edge) & (pixels[SHOWN + i] >= least_share)))
    return found


@compiled(fastmath=True)
def _lay(half_width, shade, led, pixels, number):  # type: ignore[no-untyped-def]
    """Add a stroke to the first pixels; returns how many of them it hides the last of what lies below."""
    (red, green, blue), zero, half, one = shade, np.float32(0), np.float32(0.5), np.float32(1)
    least_share, hidden = np.float32(LEAST_SHARE), np.int32(0)
    for i in range(number):
        shown, mark = pixels[SHOWN + i], pixels[ALONG + i] if len(led) > 1 else zero
        cover = min(max(half_width + half - np.sqrt(pixels[SQUARED + i]), zero), one)
        share = shown * cover if shown >= least_share else zero
        pixels[RED + i] += share * min(max(red + mark, zero), one)
        pixels[GREEN + i] += share * min(max(green + mark, zero), one)
        pixels[BLUE + i] += share * min(max(blue + mark, zero), one)
        pixels[SHOWN + i] = shown - share
        hidden = np.int32(hidden + np.int32((shown >= least_share) & (shown - share < least_share)))
    return hidden


@compiled(fastmath=True, noalias=True)
def _mark(own, bristles, marks, pixels, number):  # type: ignore[no-untyped-def]
    """Replace places along the stroke by the lightness of bristles: noise between its points."""
    along_scale, across_scale = np.float32(1 / BRISTLE[0]), np.float32(1 / BRISTLE[1])
    half, last = np.float32(0.5), np.int32(marks.size - 2)
    for i in range(number):
        x, y = own + pixels[ALONG + i] * along_scale, own + pixels[ACROSS + i] * across_scale
        column, row = np.int32(x), np.int32(y)
        beside, below = x - np.float32(column), y - np.float32(row)
        # Those of pixels beyond the stroke, which are not used, may lie outside.
        first = np.int32(column * np.int32(MARKS_BEFORE + MARKS_BEHIND))
        at = look_up_at(min(np.int32(first + np.int32(row - column + MARKS_BEFORE)), last))
        upper, lower = between_pair(marks[at], beside), between_pair(marks[1:][at], beside)
        mark = upper + below * (lower - upper)
        pixels[ALONG + i] = bristles * (mark * np.float32(1 / PAIR_CODES) - half)


@compiled(fastmath=True)
def _end(place, rows, under, pixels, out):  # type: ignore[no-untyped-def]
    """What strokes leave open shows the picture under them."""
    top, left = place
    for row in range(max(rows[1] - top, 0), min(rows[2] - top, SIDE)):
        for column in range(min(SIDE, out.shape[1] - left)):
            i, y, x = row * SIDE + column, top + row, left + column
            out[y, x, 0] = pixels[RED + i] + pixels[SHOWN + i] * under[y, x, 0]
            out[y, x, 1] = pixels[GREEN + i] + pixels[SHOWN + i] * under[y, x, 1]
            out[y, x, 2] = pixels[BLUE + i] + pixels[SHOWN + i] * under[y, x, 2]
