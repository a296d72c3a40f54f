"""Line screen: tones as parallel lines of varying width that follow the form."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from vidstyle.block import NO_PERIOD, PageRegion, SavedRef, Slider, block
from vidstyle.core.kernels import compiled


@block(
    "pixel",
    on="luma",
    chroma="dropped",
    label="Engraving lines",
    category="print",
    raster=lambda: NO_PERIOD,
    aliases="banknote, etching, woodcut, linocut, scanlines, scan lines, old television, old tv, crt",
)
def line_screen(
    luma: np.ndarray,
    place: PageRegion,
    form: Annotated[
        Any, SavedRef("picture whose luma is the height of the form", on="luma", label="Form to follow")
    ] = "source",
    spacing: Annotated[
        float, Slider(3, 64, "distance between lines", "px", explore=(4, 10), label="Line distance")
    ] = 6,
    angle: Annotated[
        float, Slider(-90, 90, "direction of the lines", "degrees", (-60, 60), label="Line direction")
    ] = 20,
    bend: Annotated[
        float, Slider(-64, 64, "displacement of the lines in white areas", "px", (-32, 32), label="Line bend")
    ] = 10,
    least: Annotated[
        float,
        Slider(0, 1, "width of lines in white areas, relative to their distance", label="Thinnest line"),
    ] = 0,
    most: Annotated[
        float,
        Slider(0, 1, "width of lines in black areas, relative to their distance", label="Thickest line"),
    ] = 1,
) -> np.ndarray:
    """Draw tones as black lines on white, wider in darker areas, as in engravings and banknotes.

    Lines are fixed to the page except for `bend`: as on a surface seen at an angle, they are displaced across
    their direction by `bend` times the luma of `form`, which should be smooth. Edges are anti-aliased.
    Ostromoukhov 1999, "Digital Facial Engraving", places the lines along a form by hand.
    """
    turn, spacing = math.radians(angle), float(np.float32(spacing))
    rows = _turns(place.top, luma.shape[0], math.cos(turn) / spacing)
    columns = _turns(0, luma.shape[1], math.sin(turn) / spacing)
    out = np.empty(luma.shape, np.float32)
    size = np.float32(spacing), np.float32(bend / spacing), np.float32(least), np.float32(most)
    _draw(luma, form, rows, columns, size, out)
    return out


def _turns(first: int, count: int, per_pixel: float) -> np.ndarray:
    """Return the positions of pixels between two lines, 0..1, reduced before float32 loses precision."""
    places: np.ndarray = (np.arange(first, first + count) + 0.5) * per_pixel
    return (places - np.floor(places)).astype(np.float32)


@compiled(fastmath=True)
def _draw(luma, form, rows, columns, size, out):  # type: ignore[no-untyped-def]
    spacing, bend, least, most = size
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    # At full width, lines also cover the softened edges.
    whole = one + one / spacing
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            width = least + (most - least) * (one - min(max(luma[y, x], zero), one))
            turns = rows[y] + columns[x] + bend * form[y, x]
            beside = abs(turns - np.floor(turns) - half)
            cover = (half * width * whole - beside) * spacing + half
            out[y, x] = one - min(max(cover, zero), min(width * spacing, one))
