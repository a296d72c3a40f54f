"""Whether a style keeps the structure and the texture of a crop everywhere, compared in small squares.

A correlation of the whole crop depends on its strongest edges. People see the parts that are lost.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.explore.measure import band_pass

STRUCTURE_BAND_PX, TEXTURE_BAND_PX = (3, 8), (2, 4)
"""Standard deviations of the two blurs between which structure and texture are seen."""
SQUARE_SIDE_PX, SQUARE_DISTANCE_PX = 25, 8
MIN_STRENGTH, WEAK_PERCENTILE = 0.006, 30
"""Strength of a band, and the percentile of it in the source, below which a square has nothing to compare."""
MIN_SQUARE_COUNT = 30
MIN_COMMON_VARIANCE = 1e-4
"""What is added to the product of two strengths, so that the correlation of weak squares is small."""
MIN_TEXTURE = 0.004
"""What is added to strengths, so that the ratio of two weak ones means nothing."""
SMEARED_RATIO = 0.41
"""Strength of texture relative to the source below which a square is smeared."""


class Texture(NamedTuple):
    """What is left of a source.

    Attributes:
        structure_kept: correlation of luma structure of 3 to 8 pixels with the source, mean of squares.
        smeared: share of squares whose texture of 2 to 4 pixels is much weaker than in the source.
    """

    structure_kept: float
    smeared: float


class Squares(NamedTuple):
    """Squares of two pictures: their correlation, and the deviation of each picture."""

    correlation: np.ndarray
    source_strength: np.ndarray
    result_strength: np.ndarray


class SourceTexture:
    """Structure and texture of a source, luma 0..1, H x W float32."""

    def __init__(self, luma: np.ndarray) -> None:
        self._structure, self._texture = (
            band_pass(luma, *band) for band in (STRUCTURE_BAND_PX, TEXTURE_BAND_PX)
        )

    def compared(self, luma: np.ndarray) -> Texture:
        """Return what is left of the source in a result, from its luma."""
        structure = _filled_squares(self._structure, band_pass(luma, *STRUCTURE_BAND_PX))
        texture = _filled_squares(self._texture, band_pass(luma, *TEXTURE_BAND_PX))
        ratio = (texture.result_strength + MIN_TEXTURE) / (texture.source_strength + MIN_TEXTURE)
        return Texture(float(structure.correlation.mean()), float((ratio < SMEARED_RATIO).mean()))


def compare_squares(source: np.ndarray, result: np.ndarray, side: int) -> Squares:
    """Compare the square around each pixel of two pictures, H x W float32."""

    def mean(picture: np.ndarray) -> np.ndarray:
        return cv2.blur(picture, (side, side))

    source_mean, result_mean = mean(source), mean(result)
    strengths = [
        np.sqrt(np.maximum(mean(each * each) - middle * middle, 0))
        for each, middle in ((source, source_mean), (result, result_mean))
    ]
    common = mean(source * result) - source_mean * result_mean
    return Squares(common / (strengths[0] * strengths[1] + MIN_COMMON_VARIANCE), *strengths)


def _filled_squares(source: np.ndarray, result: np.ndarray) -> Squares:
    """Return the squares in which the source has something to compare, in a list."""
    grid = tuple(slice(min(SQUARE_DISTANCE_PX, side) // 2, None, SQUARE_DISTANCE_PX) for side in source.shape)
    squares = Squares(*(each[grid] for each in compare_squares(source, result, SQUARE_SIDE_PX)))
    strength = squares.source_strength
    filled = strength > max(MIN_STRENGTH, float(np.percentile(strength, WEAK_PERCENTILE)))
    if filled.sum() < MIN_SQUARE_COUNT:
        filled = strength >= np.median(strength)
    return Squares(*(each[filled] for each in squares))
