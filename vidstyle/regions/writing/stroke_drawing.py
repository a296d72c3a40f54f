"""Draws lifted writing over a restyled picture, in the ink of the style."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import codes_from_values, values_from_codes
from vidstyle.regions.patches import plane_area
from vidstyle.regions.rasters import cell_means, divided_cell
from vidstyle.regions.writing.finding import thickness_of
from vidstyle.regions.writing.lifting import Strokes, luma_in
from vidstyle.style import Style

PAINT_WEIGHT = 0.8
"""Opacity of writing in styles without ink, in which nothing is quite black."""
CALM_WEIGHT = 0.6
"""Weight of the mean nearby in the ground around strokes: dots, tiles and letters there would hide them."""
MIN_CONTRAST = 0.3
"""Difference in luma from the ground below which writing has the other colour, ink or paper."""
GROUND_RATIO = 6
"""Side of the square around a pixel whose mean is its ground, relative to the thickness of strokes."""
MAX_DOT_PX_RATIO = 2 / 720
"""Largest side of the squares that writing consists of in styles of squares, relative to the picture's
shorter side."""
MIN_DOT_COVERAGE = 0.18
"""Coverage from which such a square is full."""


def draw_writing(
    page: Picture,
    writing: Sequence[Strokes],
    style: Style,
    region: np.ndarray | None,
    cell: tuple[int, int] | None,
) -> Picture:
    """Return a picture with writing over it.

    Args:
        page: the restyled picture; only read.
        writing: the strokes.
        style: its ink and paper are the colours.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        cell: height and width of squares that the picture consists of.
    """
    colors = [rgb_from_text(text) for text in (style.ink, style.paper)]
    tones = [page.encoding.yuv_from_color(color) for color in colors]
    covers = [_covers(page, each, style, (tones[0][0], tones[1][0]), region, cell) for each in writing]
    size = thickness_of(page.shape)
    surroundings = [_surroundings(each, size // 2) for each in writing]
    samples = [
        *([np.array([tone[0] for tone in tones], np.float32)] if page.luma is not None else ()),
        *(
            [np.array([tone[channel] for tone in tones], np.float32) for channel in (1, 2)]
            if page.chroma
            else ()
        ),
        *([np.array(colors, np.float32)] if page.color is not None else ()),
    ]

    def draw(plane: np.ndarray, kind: str) -> np.ndarray:
        if kind not in ("luma", "chroma", "color"):
            return plane
        step, plane = page.encoding.subsampling if kind == "chroma" else (1, 1), plane.copy()
        inks = samples.pop(0)
        for strokes, near, pair in zip(writing, surroundings, covers, strict=True):
            area = plane_area(strokes.window, step)
            values = _calmed(values_from_codes(plane[area], kind, page.encoding), near, size, step)
            for ink, cover in zip(inks, pair, strict=True):
                values = _over(values, ink, cover)
            plane[area] = codes_from_values(values, kind, page.encoding)
        return plane

    return page.map_planes(draw)


def _covers(
    page: Picture,
    strokes: Strokes,
    style: Style,
    tones: tuple[float, float],
    region: np.ndarray | None,
    cell: tuple[int, int] | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the coverage by ink and by paper, H x W float32, 0..1.

    Dark strokes have the ink of the style and light ones its paper, unless the ground has that colour.

    Args:
        tones: luma of ink and of paper.
    """
    size = GROUND_RATIO * thickness_of(page.shape)
    ground = cv2.blur(luma_in(page, strokes.window), (size, size))
    ink, paper = (np.abs(ground - np.float32(tone)) for tone in tones)
    dark, light = (_in_dots(each, strokes, page.shape, cell) for each in (strokes.dark, strokes.light))
    in_ink = (ink > MIN_CONTRAST) | (ink > paper)
    in_paper = (paper > MIN_CONTRAST) | (paper > ink)
    opacity = np.array(1 if style.lines else PAINT_WEIGHT, np.float32)
    if region is not None:
        opacity = opacity * region[plane_area(strokes.window, (1, 1))]
    return (
        opacity * np.maximum(np.where(in_ink, dark, 0), np.where(in_paper, 0, light)),
        opacity * np.maximum(np.where(in_ink, 0, dark), np.where(in_paper, light, 0)),
    )


def _in_dots(
    cover: np.ndarray, strokes: Strokes, shape: tuple[int, int], cell: tuple[int, int] | None
) -> np.ndarray:
    """Return coverage in which squares, parts of the cells of the page, are all full or empty."""
    if cell is None:
        return cover
    dot = divided_cell(cell, MAX_DOT_PX_RATIO * min(shape))
    return (cell_means(cover, strokes.window, dot) >= MIN_DOT_COVERAGE).astype(np.float32)


def _surroundings(strokes: Strokes, size: int) -> np.ndarray:
    """Return a soft mask of strokes and what is close to them, H x W float32, 0..1."""
    near = cv2.dilate(np.maximum(strokes.dark, strokes.light), np.ones((size, size), np.uint8))
    return np.float32(CALM_WEIGHT) * cv2.blur(near, (size, size))


def _calmed(values: np.ndarray, near: np.ndarray, size: int, step: tuple[int, int]) -> np.ndarray:
    """Return samples that are nearer to their local mean around strokes."""
    return _over(values, cv2.blur(values, (2 * size // step[0], 2 * size // step[1])), near)


def _over(values: np.ndarray, ink: np.ndarray, cover: np.ndarray) -> np.ndarray:
    """Return samples with an ink over them."""
    if cover.shape != values.shape[:2]:
        cover = cv2.resize(cover, values.shape[1::-1], interpolation=cv2.INTER_AREA)
    weight = cover if values.ndim == 2 else cover[..., None]
    return values + weight * (ink - values)
