"""Layers over a restyled face that give it the tones of the source."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.regions.features.blurring import enlarged, resized, weighted_mean
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.ramps import ramp

SOLID_RANGE = 0.62, 0.88
"""Darkness at which a pixel begins to be full ink, and from which it is. All values here were tuned on 20
faces of 80 to 220 of 1080 lines in all styles."""
MARK_RATIO, MIN_MARK_PX = 0.025, 1.0
"""Standard deviation of the Gaussian by which tones of a style are compared with a face, relative to its
height: finer marks stay."""
FINE_EXPONENT, COARSE_EXPONENT, COARSE_RATIO = 0.95, 0.4, 0.15
"""How far features, and light and shade, of a restyled face approach the source: the rest keeps the look of
the style; and the standard deviation of the Gaussian that divides the two, relative to the face's height."""
DARK_SHARE, LIGHT_SHARE = 0.95, 0.5
"""How far the darkest tones approach the darkest colour of the page; and brightness of whites, relative to
the difference of the skin to this colour."""
STROKE_WEIGHT = 0.6
"""How much darker the darkest strokes are than tones."""
MIN_FACTOR, MAX_FACTOR, MIN_TONE = 0.1, 2.0, 0.04
"""Smallest and largest factor of tones; and tones above the darkest colour that are compared, at least."""
LIT_RANGE = 0.4, 0.1
"""Darkness, or brightness of whites, from which skin is not lit, and up to which it is."""
CLEAR_WEIGHT, CLEAR_RANGE = 0.65, (0.1, 0.4)
"""How far grain, letters and scan lines are evened out around eyes, nose and mouth, and in dark parts; and
the darkness at which a part begins to be dark, and from which it is."""
MIN_SKIN_CONTRAST, MAX_LIGHT_FACTOR = 0.28, 3.0
"""Luma of lit skin above the page's darkest colour, below which a face gets light; and the largest factor.
Features cannot be darker than this colour."""
BRIGHT_LUMA_RANGE = 0.3, 0.6
"""Luma from which parts of a face get less light, and from which they get none, such as glowing tubes."""


class FeatureMarks(NamedTuple):
    """Layers over a part of the page in the order in which they apply, H x W float32; None: not used.

    Attributes:
        clear: coverage by the ground between marks.
        ground: weight of samples in the mean that is this ground; None: all are equal.
        light: factor that lights a dark face.
        factor: of tones, above the darkest colour.
        ink: coverage by the ink of the style.
    """

    clear: np.ndarray
    ground: np.ndarray | None = None
    light: np.ndarray | None = None
    factor: np.ndarray | None = None
    ink: np.ndarray | None = None

    def for_chroma(self, shape: tuple[int, ...]) -> FeatureMarks:
        """Return the layers at the size of a chroma plane, without factors of tones that add colour."""
        capped = self if self.factor is None else self._replace(factor=np.minimum(self.factor, 1))
        planes = {name: plane for name, plane in capped._asdict().items() if plane is not None}
        return capped._replace(**{name: resized(plane, shape) for name, plane in planes.items()})


def tone_marks(each: Features, weight: np.ndarray, luma: np.ndarray, darkest: float) -> FeatureMarks:
    """Return the layers that give the tones of a face to the marks and colours of a style; see `ink_marks`.

    Args:
        darkest: luma of the page's darkest colour.
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
    power = np.float32(FINE_EXPONENT) * (power - coarse) + np.float32(COARSE_EXPONENT) * coarse
    strokes = 1 - np.float32(STROKE_WEIGHT) * ramp(darkness, SOLID_RANGE)
    dark = ramp(cv2.GaussianBlur(darkness, (0, 0), sigma), CLEAR_RANGE)
    clear = np.maximum(dark, enlarged(each.areas.whole, luma.shape))
    factor = 1 + weight * (cv2.exp(power) * strokes - 1)
    return FeatureMarks(np.float32(CLEAR_WEIGHT) * weight * clear, None, light, factor)


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
