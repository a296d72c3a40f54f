"""Kernels for tone mapping. Curves are lookup tables; signals and light are floats 0..1."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.core.kernels import compiled, index_at


@compiled(fastmath=True)
def look_up(table, position):  # type: ignore[no-untyped-def]
    """Return the table entry nearest to a position 0..1."""
    last = np.int32(table.size - 1)
    position = min(max(position, np.float32(0)), np.float32(1))
    return table[index_at(position * np.float32(last) + np.float32(0.5), last)]


@compiled(fastmath=True)
def map_pixel(red, green, blue, tables):  # type: ignore[no-untyped-def]
    """Return the SDR signal of one HDR pixel.

    Args:
        red, green, blue: 0..1.
        tables:
            light: from signal to light.
            gain: factor, by the largest signal (PQ) or the fourth root of the largest light (HLG).
            ootf: factor for HLG's scene light, by the fourth root of its luminance; empty for PQ.
            gamut: 3 x 3 matrix, linear light to BT.709 primaries.
            display: from the square root of light to signal.
    """
    light, gain, ootf, gamut, display = tables
    linear_red, linear_green, linear_blue = look_up(light, red), look_up(light, green), look_up(light, blue)
    if ootf.size:
        luminance = np.float32(0.2627) * linear_red + np.float32(0.6780) * linear_green
        luminance += np.float32(0.0593) * linear_blue
        brighter = look_up(ootf, math.sqrt(math.sqrt(luminance)))
        most = max(linear_red, linear_green, linear_blue) * brighter
        factor = brighter * look_up(gain, math.sqrt(math.sqrt(most)))
    else:
        factor = look_up(gain, max(red, green, blue))
    linear_red, linear_green, linear_blue = linear_red * factor, linear_green * factor, linear_blue * factor
    new_red = gamut[0, 0] * linear_red + gamut[0, 1] * linear_green + gamut[0, 2] * linear_blue
    new_green = gamut[1, 0] * linear_red + gamut[1, 1] * linear_green + gamut[1, 2] * linear_blue
    new_blue = gamut[2, 0] * linear_red + gamut[2, 1] * linear_green + gamut[2, 2] * linear_blue
    return (
        look_up(display, math.sqrt(max(new_red, np.float32(0)))),
        look_up(display, math.sqrt(max(new_green, np.float32(0)))),
        look_up(display, math.sqrt(max(new_blue, np.float32(0)))),
    )


@compiled(fastmath=True)
def mix_rows(plane, row, weights):  # type: ignore[no-untyped-def]
    """Interpolate a chroma row at a vertical position, in rows."""
    last = plane.shape[0] - 1
    place = min(max(row, 0.0), float(last))
    above = index_at(place, max(last - 1, 0))
    share = np.float32(place - above)
    below = min(above + 1, last)
    for column in range(plane.shape[1]):
        first = np.float32(plane[above, column])
        weights[column] = first + share * (np.float32(plane[below, column]) - first)


@compiled(fastmath=True)
def interpolate_chroma(row, place):  # type: ignore[no-untyped-def]
    """Interpolate a chroma row at a horizontal position, in samples."""
    last = row.size - 1
    place = min(max(place, np.float32(0)), np.float32(last))
    index = index_at(place, max(last - 1, 0))
    return row[index] + (place - np.float32(index)) * (row[min(index + 1, last)] - row[index])


@compiled(fastmath=True)
def tone_map_planes(planes, out, first, end, levels, matrices, place, tables, rows):  # type: ignore[no-untyped-def]
    """Tone-map rows `first` to `end` (a multiple of the subsampling, or the last) of a picture with chroma.

    Args:
        planes, out: luma, blue and red difference; `planes` are read, `out` is written.
        levels: of `planes` and `out`: luma black, luma range, chroma neutral, chroma range; in codes.
        matrices: 3 x 3, from the source's luma and chroma to RGB, and from RGB to the result's.
        place: horizontal and vertical subsampling, horizontal and vertical siting.
        tables: see `map_pixel`.
        rows: scratch memory: two rows of the width of chroma and two of the width of luma, float32.
    """
    luma, blue, red = planes
    out_luma, out_blue, out_red = out
    in_levels, out_levels = levels
    to_rgb, from_rgb = matrices
    step_x, step_y = int(place[0]), int(place[1])
    width = luma.shape[1]
    blue_row, red_row = rows[0][0], rows[0][1]
    new_blue, new_red = rows[1][0], rows[1][1]
    across = np.float32(1) / np.float32(step_x)
    for top in range(first, end, step_y):
        bottom = min(top + step_y, end)
        for column in range(width):
            new_blue[column], new_red[column] = 0, 0
        for row in range(top, bottom):
            mix_rows(blue, (row - place[3]) / step_y, blue_row)
            mix_rows(red, (row - place[3]) / step_y, red_row)
            for column in range(width):
                where = (np.float32(column) - place[2]) * across
                bright = (np.float32(luma[row, column]) - in_levels[0]) / in_levels[1]
                cb = (interpolate_chroma(blue_row, where) - in_levels[2]) / in_levels[3]
                cr = (interpolate_chroma(red_row, where) - in_levels[2]) / in_levels[3]
                r, g, b = map_pixel(
                    bright + to_rgb[0, 2] * cr,
                    bright + to_rgb[1, 1] * cb + to_rgb[1, 2] * cr,
                    bright + to_rgb[2, 1] * cb,
                    tables,
                )
                bright = from_rgb[0, 0] * r + from_rgb[0, 1] * g + from_rgb[0, 2] * b
                out_luma[row, column] = int(out_levels[0] + out_levels[1] * bright + np.float32(0.5))
                new_blue[column] += from_rgb[1, 0] * r + from_rgb[1, 1] * g + from_rgb[1, 2] * b
                new_red[column] += from_rgb[2, 0] * r + from_rgb[2, 1] * g + from_rgb[2, 2] * b
        scale = out_levels[3] / np.float32(bottom - top)
        store_chroma(new_blue, out_blue[top // step_y], step_x, out_levels[2], scale)
        store_chroma(new_red, out_red[top // step_y], step_x, out_levels[2], scale)


@compiled(fastmath=True)
def store_chroma(row, out, step, neutral, scale):  # type: ignore[no-untyped-def]
    """Subsample a row of chroma to every `step` pixels, left-sited: weights 1 2 1 if the step is 2."""
    last = row.size - 1
    for index in range(out.size):
        column = index * step
        value = row[column]
        if step == 2:
            value = np.float32(0.5) * value
            value += np.float32(0.25) * (row[max(column - 1, 0)] + row[min(column + 1, last)])
        out[index] = int(neutral + scale * value + np.float32(0.5))


@compiled(fastmath=True)
def tone_map_colors(color, out, first, end, top, tables):  # type: ignore[no-untyped-def]
    """Tone-map rows of an RGB picture of integers 0..`top`."""
    scale = np.float32(1) / np.float32(top)
    for row in range(first, end):
        for column in range(color.shape[1]):
            r, g, b = map_pixel(
                color[row, column, 0] * scale,
                color[row, column, 1] * scale,
                color[row, column, 2] * scale,
                tables,
            )
            out[row, column, 0] = int(r * np.float32(top) + np.float32(0.5))
            out[row, column, 1] = int(g * np.float32(top) + np.float32(0.5))
            out[row, column, 2] = int(b * np.float32(top) + np.float32(0.5))
