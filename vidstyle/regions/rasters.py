"""Positions of the dots, squares and lines of a style, so that patches continue those around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.block import Raster, Wave
from vidstyle.core.picture import PictureLayout
from vidstyle.regions.boxes import Rectangle
from vidstyle.style import Style
from vidstyle.style.lower import lower
from vidstyle.style.nodes import nodes_in_order
from vidstyle.style.resolve import resolve

MAX_GAP_PX = 96
"""Rasters with longer periods are not continued."""
GAP_WEIGHT = 0.0005
"""Weight of a pixel of a gap between patches, relative to the worst phase of a wave."""


@dataclass(frozen=True)
class PageRaster:
    """The rasters of a style on a page.

    Attributes:
        waves: waves with the periods of its dots, squares and lines, in pixels of the page.
        cell: height and width of its largest squares in whole pixels; None without squares.
        is_screen: whether it has any marks.
        has_points: whether all of them are points, squares or letters of one tone each: those may be
            small, while finer dots or lines would look like another print.
        has_dots: whether some are dots that grow with the tone.
        has_colors: whether some are in several inks.
    """

    waves: tuple[Wave, ...] = ()
    cell: tuple[int, int] | None = None
    is_screen: bool = False
    has_points: bool = False
    has_dots: bool = False
    has_colors: bool = False

    def gap(self, right: int, down: int, step: tuple[int, int]) -> tuple[int, int]:
        """Return by how much more to move a part of the page that is moved by `right` and `down`.

        The rasters of the moved part are then where those of the page are, as nearly as a small move can.

        Args:
            step: the result consists of multiples of it, across and down.
        """
        if not self.waves:
            return 0, 0
        columns, rows = (np.arange(0, _longest_period(self.waves, axis), step[axis]) for axis in (0, 1))
        cost = GAP_WEIGHT * np.add.outer(rows, columns)
        for across, along in self.waves:
            phase = np.add.outer((rows + down) * along, (columns + right) * across)
            cost += 1 - np.cos(2 * np.pi * phase)
        row, column = np.unravel_index(np.argmin(cost), cost.shape)
        return int(columns[column]), int(rows[row])


NO_RASTER = PageRaster()


def raster_of(style: Style, request: FrameRequest) -> PageRaster:
    """Return the rasters of a style on the page of a request."""
    picture = request.picture
    steps = resolve(style, *picture.shape)
    lowered = lower(style, steps, PictureLayout.of(picture), request.encoding, request.rgb)
    waves, cells, rasters, has_colors = dict[Wave, None](), [(1, 1)], list[Raster](), False
    for node in nodes_in_order(lowered.outputs):
        if node.block is not None and (raster := node.block.raster_for(node.values)):
            rasters.append(raster)
            has_colors |= node.kind == "color" and node.inputs["image"].op != "rgb_from_gray"
            down, right = (page / side for page, side in zip(picture.shape, node.shape, strict=True))
            waves |= {(across / right, along / down): None for across, along in raster.waves}
            cells += [(round(raster.cell[0] * down), round(raster.cell[1] * right))] if raster.cell else []
    cell = max(cells)
    return PageRaster(
        tuple(waves),
        None if cell == (1, 1) else cell,
        is_screen=bool(rasters),
        has_points=bool(rasters) and all(each.has_points for each in rasters),
        has_dots=any(each.has_dots for each in rasters),
        has_colors=has_colors,
    )


def divided_cell(cell: tuple[int, int], widest: float) -> tuple[int, int]:
    """Return height and width of equal parts of a cell, of at most `widest` pixels, and at least one."""
    most = max(1, round(widest))
    down, across = (
        max(each for each in range(1, side + 1) if side % each == 0 and each <= most) for side in cell
    )
    return down, across


def cell_means(plane: np.ndarray, window: Rectangle, cell: tuple[int, int]) -> np.ndarray:
    """Return a plane whose pixels have the mean of their cell of the page.

    Args:
        plane: H x W float32, of a window of the page; outside it counts as 0.
        window: the window.
        cell: height and width of a cell.
    """
    down, across = cell
    above, before = window.top % down, window.left % across
    height, width = plane.shape
    rows, columns = -(-(above + height) // down), -(-(before + width) // across)
    whole = np.zeros((rows * down, columns * across), np.float32)
    whole[above : above + height, before : before + width] = plane
    means = whole.reshape(rows, down, columns, across).mean(axis=(1, 3))
    full = np.repeat(np.repeat(means, down, axis=0), across, axis=1)
    return full[above : above + height, before : before + width]


def _longest_period(waves: tuple[Wave, ...], axis: int) -> int:
    """Return the longest period of waves across or down in pixels, at least 1."""
    lengths = [abs(wave[axis]) for wave in waves if abs(wave[axis]) > 1 / MAX_GAP_PX]
    return max(1, round(1 / min(lengths, default=1.0)))
