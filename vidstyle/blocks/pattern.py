"""Pattern filling: hatching, or the user's own tiles, by level of luma."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, Choice, PageRegion, Raster, Slider, block
from vidstyle.block.gray_png import read_gray_png
from vidstyle.core.kernels import TIE_LIFT, cached, compiled

MAX_TILE_SIDE_PX = 1024
"""Maximum side of a tile."""
MAX_TILE_BYTES = 16 << 20
"""Maximum size of the file of a tile."""
KEPT_BYTES = 1 << 28
"""Memory for the cached strokes of the last few pages."""

LAYOUT_DEGREES = {"cross": (0.0, 90.0, 45.0, 135.0), "parallel": (0.0,), "weave": (0.0, 90.0)}
"""Angles of the sets of strokes relative to the first, by layout; repeated for further sets."""


def read_tiles(path: Path) -> tuple[np.ndarray, ...]:
    """Read the PNG pictures of a folder as gray tiles, float32 0..1, darkest first.

    Raises:
        ValueError: there are fewer than two, or one is a link, not a PNG, or larger than `MAX_TILE_SIDE_PX`.
        OSError: a file cannot be read.
    """
    files = sorted(path.glob("*.png"))
    if not 2 <= len(files) <= 32:
        raise ValueError(f"needs 2 to 32 .png tiles, has {len(files)}")
    if link := next((file for file in files if file.is_symlink()), None):
        raise ValueError(f"{link.name} is a link, which might lead out of the style's folder")
    return tuple(sorted((read_tile(file) for file in files), key=lambda tile: float(tile.mean())))


def read_tile(file: Path) -> np.ndarray:
    """Read a PNG picture as a gray tile, float32 0..1.

    Raises:
        ValueError: the file is not a PNG, or larger than `MAX_TILE_SIDE_PX`.
        OSError: the file cannot be read.
    """
    tile = read_gray_png(file, MAX_TILE_SIDE_PX, MAX_TILE_BYTES)
    return tile.astype(np.float32) / np.float32(255)


def _raster(spacing: float, angle: float, layout: str, wobble: float) -> Raster | None:
    """Return the raster of ruled lines; lines by hand have none."""
    if wobble:
        return None
    turns = [math.radians(angle + turn) for turn in LAYOUT_DEGREES[layout]]
    return Raster(tuple((-math.sin(turn) / spacing, math.cos(turn) / spacing) for turn in turns))


@block(
    "pixel",
    on="luma",
    raster=_raster,
    chroma="dropped",
    label="Hatching",
    category="lines",
    aliases=(
        "crosshatch, cross-hatching, pencil, sketch, pen, shading, drawing, engraving, "
        "hand drawn, scribble, graphite"
    ),
)
def pattern(
    luma: np.ndarray,
    place: PageRegion,
    levels: Annotated[
        int, Slider(2, 9, "number of tones, including blank white", explore=(3, 6), label="Number of tones")
    ] = 5,
    spacing: Annotated[
        float,
        Slider(
            3, 64, "distance between strokes", "px", explore=(5, 12), label="Stroke distance", max_detail=1
        ),
    ] = 7,
    width: Annotated[
        float,
        Slider(
            0.05, 1, "width of a stroke, relative to the distance", explore=(0.15, 0.4), label="Stroke width"
        ),
    ] = 0.24,
    angle: Annotated[
        float,
        Slider(
            -90, 90, "direction of the first set of strokes", "degrees", (-60, 60), label="Stroke direction"
        ),
    ] = 45,
    layout: Annotated[
        str, Choice(tuple(LAYOUT_DEGREES), "directions of further sets of strokes", label="Crossing strokes")
    ] = "cross",
    wobble: Annotated[float, Slider(0, 1, "irregularity of the strokes", label="Hand wobble")] = 0.5,
    softness: Annotated[
        float, Slider(0, 1, "share of each level over which its strokes fade in", label="Soft transitions")
    ] = 0.35,
    tiles: Annotated[
        Any,
        Asset(
            "folder of .png tiles, one for each level, instead of strokes",
            read_tiles,
            optional=True,
            label="Own tiles",
        ),
    ] = "",
) -> np.ndarray:
    """Draw tones as black hatching on white, with more strokes in darker areas.

    Each level adds a set of strokes to the strokes of lighter levels; the strokes are fixed to the page. If
    tiles are given, their number replaces `levels`, and they repeat over the page. Paper, section 4.2 B.
    """
    rows, columns = luma.shape
    if tiles is not None:
        return _fill(luma, tiles, place.top, softness)
    sets = _stroke_sets(levels, spacing, width, angle, layout, wobble, place.height, place.width)
    out = np.empty((rows, columns), np.float32)
    _hatch(luma, sets, place.top, np.float32(softness), TIE_LIFT, out)
    return out


def _fill(luma: np.ndarray, tiles: tuple[np.ndarray, ...], top: int, softness: float) -> np.ndarray:
    rows, columns = np.arange(top, top + luma.shape[0]), np.arange(luma.shape[1])
    level = (luma + TIE_LIFT) * len(tiles)
    out = np.zeros(luma.shape, np.float32)
    for number, tile in enumerate(tiles):
        shown = _risen(level - number, softness) if number else np.ones_like(luma)
        page = tile[np.ix_(rows % tile.shape[0], columns % tile.shape[1])]
        out += shown * (page - out)
    return out


def _risen(above_border: np.ndarray, softness: float) -> np.ndarray:
    ramp = np.clip(above_border / np.float32(max(softness, 1e-6)) + np.float32(0.5), 0, 1)
    return ramp * ramp * (3 - 2 * ramp)


@cached(maxsize=8, most_bytes=KEPT_BYTES)
def _stroke_sets(
    levels: int, spacing: float, width: float, angle: float, layout: str, wobble: float, *page: int
) -> np.ndarray:
    """Return the coverage of pixels by each set of strokes, (levels - 1) x page height x page width uint8.

    Cached for the last few pages, as the strokes do not move.
    """
    sets = np.empty((levels - 1, *page), np.uint8)
    turns = LAYOUT_DEGREES[layout]
    for number in range(levels - 1):
        direction = math.radians(angle + turns[number % len(turns)])
        # Further strokes in the same direction lie between the existing ones.
        shift = 0.5 * (number // len(turns)) + 0.37 * (number % len(turns))
        cosine, sine = math.cos(direction) / spacing, -math.sin(direction) / spacing
        _draw_strokes(cosine, sine, shift, width / 2, wobble, spacing, sets[number])
    return sets


@compiled
def _draw_strokes(cosine, sine, shift, half_width, wobble, spacing, out):  # type: ignore[no-untyped-def]
    """Draw parallel strokes that vary slightly in position and width. Lengths are in spacings."""
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            along = (x + 0.5) * cosine + (row + 0.5) * sine
            across = (row + 0.5) * cosine - (x + 0.5) * sine + shift
            stroke = np.floor(across)
            own = stroke * 2.399
            sway = np.sin(along * 0.31 + own) + 0.6 * np.sin(along * 0.83 + own * 1.7)
            swell = np.sin(along * 0.53 + own * 2.3)
            middle = 0.5 + 0.09 * wobble * sway
            half = half_width * (1 + 0.35 * wobble * swell)
            cover = (half - abs(across - stroke - middle)) * spacing + 0.5
            out[row, x] = int(min(max(cover, 0.0), 2 * half * spacing, 1.0) * 255 + 0.5)


@compiled
def _hatch(luma, sets, top, softness, lift, out):  # type: ignore[no-untyped-def]
    """Draw black strokes on white: set n appears where luma is below its border.

    Args:
        top: the row of the page at which the picture begins.
    """
    half, one, three, two = np.float32(0.5), np.float32(1), np.float32(3), np.float32(2)
    count = sets.shape[0]
    levels = np.float32(count + 1)
    sharpness = one / max(softness, np.float32(1e-6))
    for row in range(out.shape[0]):
        out[row, :] = one
        for number in range(count):
            strokes = sets[number, top + row]
            border = levels - one - np.float32(number)
            for x in range(out.shape[1]):
                ramp = min(
                    max((border - (luma[row, x] + lift) * levels) * sharpness + half, np.float32(0)), one
                )
                ramp = ramp * ramp * (three - two * ramp)
                out[row, x] *= one - ramp * strokes[x] * np.float32(1 / 255)
