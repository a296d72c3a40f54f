"""Layers that give the tones of a face to a restyled face: for styles of tones."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.regions.features.blurring import enlarged, weighted_mean
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.feature_marks import FeatureMarks
from vidstyle.regions.features.ink_marks import outlines, solid_features
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.rasters import PageRaster, divided_cell

SOLID_RANGE = 0.62, 0.88
"""Darkness at which strokes begin, and from which they are full. All values here were tuned on 20 faces of 80
to 220 of 1080 lines in all styles."""
MARK_RATIO, MIN_MARK_PX = 0.025, 1.0
"""Standard deviation of the Gaussian by which tones of a style are compared with a face, relative to its
height: finer marks stay."""
FINE_EXPONENT, COARSE_EXPONENT, COARSE_RATIO = 0.95, 0.4, 0.15
"""How far features, and light and shade, of a restyled face approach the source: the rest keeps the look of
the style; and the standard deviation of the Gaussian that divides the two, relative to the face's height."""
OUTLINED_EXPONENT = 0.7
"""The first of these exponents where features have outlines too, in a style of light lines."""
DARK_SHARE, LIGHT_SHARE = 0.95, 0.5
"""How far the darkest tones approach the darkest colour of the page; and brightness of whites, relative to
the difference of the skin to this colour."""
STROKE_WEIGHT = 0.6
"""How much darker the darkest strokes are than tones."""
MIN_FACTOR, MAX_FACTOR, MIN_TONE = 0.1, 2.0, 0.04
"""Smallest and largest factor of tones; and tones above the darkest colour that are compared, at least."""
LIT_RANGE = 0.4, 0.1
"""Darkness, or brightness of whites, from which skin is not lit, and up to which it is."""
CLEAR_WEIGHT, CLEAR_RANGE = 0.5, (0.1, 0.4)
"""How far grain and scan lines are evened out under features, and the darkness from which they are."""
MIN_CELL_PX, CELL_RATIO = 2.0, 1 / 60
"""Side of the squares of tones in a style of squares, at least, and relative to the face's height."""
MIN_SKIN_CONTRAST, MAX_LIGHT_FACTOR = 0.28, 3.0
"""Luma of lit skin above the page's darkest colour, below which a face gets light; and the largest factor.
Features cannot be darker than this colour."""
BRIGHT_LUMA_RANGE = 0.3, 0.6
"""Luma from which parts of a face get less light, and from which they get none, such as glowing tubes."""


def tone_marks(
    each: Features,
    weight: np.ndarray,
    luma: np.ndarray,
    darkest: float,
    raster: PageRaster,
    medium: Medium,
) -> FeatureMarks:
    """Return the layers that give the tones of a face to the marks and colours of a style; see `ink_marks`.

    Args:
        darkest: luma of the page's darkest colour.
        raster: squares of the style.
        medium: of the style; between light lines, features get outlines in the ink of the style.
    """
    darkness, height = enlarged(each.darkness, luma.shape), each.face.box.height
    lit = weight * ramp(np.abs(darkness), LIT_RANGE)
    light = _light(luma, lit, weight, darkest)
    luma = luma if light is None else luma * light
    sigma = max(MIN_MARK_PX, MARK_RATIO * height)
    tones = np.maximum(cv2.GaussianBlur(luma, (0, 0), sigma) - np.float32(darkest), np.float32(MIN_TONE))
    shown = 1 - np.float32(DARK_SHARE) * np.clip(darkness, 0, 1)
    shown += np.float32(LIGHT_SHARE) * np.clip(-darkness, 0, 1)
    power = cv2.log(np.clip(np.float32(_mean(tones, lit)) * shown / tones, MIN_FACTOR, MAX_FACTOR))
    coarse = weighted_mean(power, weight, COARSE_RATIO * height)
    is_outlined = medium is Medium.OUTLINES
    fine = OUTLINED_EXPONENT if is_outlined else FINE_EXPONENT
    power = np.float32(fine) * (power - coarse) + np.float32(COARSE_EXPONENT) * coarse
    strokes = 1 - np.float32(STROKE_WEIGHT) * ramp(darkness, SOLID_RANGE)
    clear = ramp(cv2.GaussianBlur(darkness, (0, 0), sigma), CLEAR_RANGE)
    factor = 1 + weight * (cv2.exp(power) * strokes - 1)
    ink = weight * outlines(solid_features(each, luma.shape)[0], height) if is_outlined else None
    marks = FeatureMarks(np.float32(CLEAR_WEIGHT) * weight * clear, None, light, factor, ink)
    if medium is not Medium.SQUARES or raster.cell is None:
        return marks
    return marks.in_cells(each.window, divided_cell(raster.cell, max(MIN_CELL_PX, CELL_RATIO * height)))


def _light(luma: np.ndarray, lit: np.ndarray, weight: np.ndarray, darkest: float) -> np.ndarray | None:
    """Return the factor that makes dark skin of a page light enough for features; None if it is."""
    factor = min(MAX_LIGHT_FACTOR, (darkest + MIN_SKIN_CONTRAST) / max(_mean(luma, lit), 1e-3))
    if factor <= 1:
        return None
    return 1 + np.float32(factor - 1) * weight * (1 - ramp(luma, BRIGHT_LUMA_RANGE))


def _mean(plane: np.ndarray, weight: np.ndarray) -> float:
    """Return the weighted mean of a plane; 1 without weights."""
    area = float(weight.sum())
    return float((plane * weight).sum()) / area if area else 1.0
