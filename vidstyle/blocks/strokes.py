"""Strokes: a painting in brush strokes of one colour each."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from vidstyle.block import (
    REDRAW_RATE,
    Drift,
    FrameTime,
    PageRegion,
    ResultRows,
    SavedRef,
    Slider,
    block,
    drawing_at,
)
from vidstyle.core.drift import drifted_noise
from vidstyle.core.kernels import cached, compiled, interleaved, look_up_at
from vidstyle.core.kernels.stroke_painting import MARK_COLUMNS, TILE_SIZE, paint_strokes
from vidstyle.core.marks.stroke_directions import DEFAULT_ANGLE_STRENGTH, stroke_directions
from vidstyle.core.white_noise import LATTICE_PART_SIZE

RANDOM_COUNT = 4
"""Random numbers per stroke: position across and down, order, and tone."""
GRAY_SPREAD_RATIO = 0.15
"""Colour variation of gray strokes, relative to strokes of strong colour."""
MAX_CELLS_ALONG = 5
"""Maximum squares of the grid along a stroke: a pixel searches all of them for strokes."""
KEPT_BYTES = 64 << 20
"""Memory for strokes that are cached for the next frame."""


def _radius(length: float, width: float) -> int:
    return math.ceil(max(length, width) / 2 + 1)


@block(
    "filter",
    on="color",
    radius=_radius,
    label="Brush strokes",
    category="paint",
    aliases=(
        "painting, brush, impressionist, pointillism, points, dots, van gogh, painterly, stippling, "
        "crayon, pastel, oil painting, daubs, wax, acrylic, gouache, monet, seurat"
    ),
)
def strokes(
    picture: np.ndarray,
    place: PageRegion,
    moment: FrameTime,
    drift: Drift,
    out: ResultRows,
    flow: Annotated[Any, SavedRef("smoothed edge directions", label="Direction from")] = "source",
    under: Annotated[
        Any, SavedRef("picture that is visible between strokes", label="Picture underneath")
    ] = "source",
    length: Annotated[
        float,
        Slider(2, 96, "length of a stroke", "px", explore=(8, 36), label="Stroke length", max_detail=2),
    ] = 24,
    width: Annotated[
        float, Slider(2, 64, "width of a stroke", "px", explore=(4, 12), label="Stroke width", max_detail=2)
    ] = 7,
    density: Annotated[
        float,
        Slider(0.25, 4, "number of strokes per square of the stroke's width", label="Number of strokes"),
    ] = 1,
    angle: Annotated[
        float, Slider(-90, 90, "direction of strokes far from edges", "degrees", label="Stroke direction")
    ] = 35,
    angle_strength: Annotated[
        float,
        Slider(0.01, 1, "strength of that direction near weak edges", label="Direction strength"),
    ] = DEFAULT_ANGLE_STRENGTH,
    variation: Annotated[
        float, Slider(0, 1, "variation of tone between strokes", explore=(0, 0.2), label="Tone variation")
    ] = 0.1,
    colors: Annotated[
        float,
        Slider(
            0,
            1,
            "variation of colour between strokes; gray strokes vary less",
            explore=(0, 0.2),
            label="Colour variation",
        ),
    ] = 0,
    bristles: Annotated[
        float, Slider(0, 1, "contrast of the bristle marks", explore=(0, 0.5), label="Bristle marks")
    ] = 0.25,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Paint with brush strokes along the edges, or with dots.

    Each stroke has one colour; strokes are dots if width equals length. A stroke has a random position in
    its square of a grid and the picture's colour in its middle, and bends with the flow. The order of
    overlapping strokes is random. In films strokes move with the objects, and change only at `rate`. Haeberli
    1990, "Paint by Numbers: Abstract Image Representations".
    """
    pitch = np.float32(max(width / math.sqrt(density), max(length, width) / MAX_CELLS_ALONG))
    size = np.float32(max(length - width, 0) / 2), np.float32(width / 2)
    grid, drawing = (float(pitch), _radius(length, width)), drawing_at(moment, rate) * LATTICE_PART_SIZE
    around, half_size = (place, picture.shape[:2], grid), float(size[0] + size[1])
    strokes_, lists, counts = (
        _strokes_at_rest(*around, half_size, drawing)
        if drift is None
        else _strokes_in(*around, half_size, drawing, drift)
    )
    looks, shape = (np.float32(variation), np.float32(colors), np.float32(bristles)), picture.shape[:2]
    painted, samples = np.empty((4, strokes_.shape[1]), np.float32), interleaved(picture).reshape(-1)
    _choose_paint(strokes_, samples, samples[1:], samples[2:], (place.top, *shape), looks, painted)
    rows = slice(place.margin[0], len(picture) - place.margin[1])
    directions = stroke_directions(flow[rows], angle, angle_strength) if bristles or length > width else None
    pictures, page_row = (np.ascontiguousarray(under[rows]), directions), place.top + rows.start
    paint_strokes((strokes_, painted), (lists, counts), size, looks[2], pictures, page_row, out)
    return out


@cached(maxsize=256, most_bytes=KEPT_BYTES)
def _strokes_at_rest(
    place: PageRegion, shape: tuple[int, int], grid: tuple[float, int], half_size: float, drawing: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the strokes of a band that have not moved, cached for the next frame; see `_strokes_in`."""
    return _strokes_in(place, shape, grid, half_size, drawing, None)


def _strokes_in(
    place: PageRegion,
    shape: tuple[int, int],
    grid: tuple[float, int],
    half_size: float,
    drawing: int,
    drift: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the strokes that may be visible in a band; they do not depend on the picture.

    Args:
        shape: of the band.
        grid: the side of its squares, each of which has one stroke, and the rows and columns within reach of
            a stroke.
        half_size: the maximum distance of a stroke's edge from its middle.
        drawing: the first row of random numbers.
        drift: see `core.drift`.

    Returns:
        The strokes, topmost first, 3 x n float32: column and row of the middle on the page, and tone. And the
        strokes of each tile, see `paint_strokes`.
    """
    (pitch, reach), (height, width) = grid, shape
    more = 0 if drift is None else 1  # strokes that have moved are up to half a square outside their own
    around = math.ceil(reach / pitch) + 1 + more
    above, below = math.floor(place.top / pitch) - around, math.ceil((place.top + height) / pitch) + around
    left, right = -around, math.ceil(width / pitch) + around
    squares, page = ((above, below), (left, right)), (place.height, place.width)
    noise, shifts = drifted_noise(drift, *squares, pitch, page, RANDOM_COUNT, drawing)
    across, down, order, tone = noise.transpose(2, 0, 1)
    if drift is not None:
        across, down = across + shifts[..., 0], down + shifts[..., 1]
    x = (np.arange(left, right, dtype=np.float32) + across) * np.float32(pitch)
    y = (np.arange(above, below, dtype=np.float32)[:, None] + down) * np.float32(pitch)
    uppermost = _uppermost_first(order.reshape(-1))
    strokes_ = np.stack([each.reshape(-1)[uppermost] for each in (x, y, tone)])
    first, last = (
        (place.top + place.margin[0]) // TILE_SIZE,
        -(-(place.top + height - place.margin[1]) // TILE_SIZE),
    )
    # Squares of the grid within reach of a tile, each with one stroke.
    most = (math.ceil((TILE_SIZE + 2 * reach) / pitch) + 1 + more) ** 2
    lists = np.empty((last - first, -(-width // TILE_SIZE), most), np.int32)
    counts = np.zeros(lists.shape[:2], np.int32)
    # Slightly more than the strokes that cover part of it, so that rounding, which depends on the first row,
    # has no effect.
    _list_by_tile(strokes_, np.float32(half_size + 0.51), first * TILE_SIZE, lists, counts)
    return strokes_, lists, counts


def _uppermost_first(order: np.ndarray) -> np.ndarray:
    """Return the numbers of strokes by order, 0..1 in steps of 2**-24, the highest first.

    A radix sort by the lower 8 and the upper 16 bits takes a fifth of the time of a sort of floats.
    """
    codes = (np.float32(2**24 - 1) - order * np.float32(2**24)).astype(np.uint32)
    by_low_bits = np.argsort(codes.astype(np.uint8), kind="stable")
    return by_low_bits[np.argsort((codes[by_low_bits] >> 8).astype(np.uint16), kind="stable")]


@compiled
def _list_by_tile(strokes_, edge, top, lists, counts):  # type: ignore[no-untyped-def]
    """List for each tile, from row `top` of the page on, the strokes near it, in their order."""
    side, scale, half, zero = np.float32(TILE_SIZE), np.float32(1 / TILE_SIZE), np.float32(0.5), np.float32(0)
    rows, columns = counts.shape
    for i in range(strokes_.shape[1]):
        x, y = strokes_[0, i], strokes_[1, i] - np.float32(top)
        upper, lower = int(max(y - edge + half, zero) * scale), int(np.floor((y + edge - half) * scale))
        for row in range(upper, min(lower + 1, rows)):
            # Distance from the middle of its nearest pixels.
            down = y - np.float32(row) * side
            dy = max(half - down, down - side + half, zero)
            dx = np.sqrt(max(edge * edge - dy * dy, zero))
            left, right = int(max(x - dx + half, zero) * scale), int(np.floor((x + dx - half) * scale))
            for column in range(left, min(right + 1, columns)):
                lists[row, column, counts[row, column]] = i
                counts[row, column] += 1


@compiled(fastmath=True, noalias=True)
def _choose_paint(strokes_, reds, greens, blues, shape, looks, out):  # type: ignore[no-untyped-def]
    """Compute red, green and blue of each stroke without bristle marks, and the start of its marks.

    Args:
        reds, greens, blues: samples of the picture, of which every third belongs to the channel.
        shape: the picture's first row on the page, its height and width.
        out: 4 x strokes, written.
    """
    (variation, colors, bristles), half, zero = looks, np.float32(0.5), np.int32(0)
    top, height, width = np.int32(shape[0]), np.int32(shape[1]), np.int32(shape[2])
    for i in range(out.shape[1]):
        column, row, tone = np.int32(strokes_[0, i]), np.int32(strokes_[1, i]) - top, strokes_[2, i]
        # Strokes beyond the edge have the colour at the edge.
        column, row = min(max(column, zero), width - np.int32(1)), min(max(row, zero), height - np.int32(1))
        at = look_up_at(np.int32((row * width + column) * np.int32(3)))
        red, green, blue = reds[at], greens[at], blues[at]
        strength = max(red, green, blue) - min(red, green, blue)
        spread = colors * min(np.float32(GRAY_SPREAD_RATIO) + strength, np.float32(1))
        more, less = tone * np.float32(7), tone * np.float32(13)
        more, less = spread * (more - np.floor(more) - half), spread * (less - np.floor(less) - half)
        change = variation * (tone - half) - half * bristles
        out[0, i], out[1, i] = red + more + change, green - half * (more + less) + change
        out[2, i], out[3, i] = blue + less + change, tone * np.float32(MARK_COLUMNS)
