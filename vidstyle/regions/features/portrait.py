"""How dark each part of a face is, relative to its lit skin: what a drawing of the face shows."""

from __future__ import annotations

import numpy as np

from vidstyle.core.sampling import percentiles
from vidstyle.regions.features.areas import Areas
from vidstyle.regions.features.blurring import blurred, weighted_mean

SHADE_RATIO, SHADE_WEIGHT = 0.25, 0.5
"""Standard deviation of the Gaussian that finds light and shade, relative to the face's height; and the share
of them that is taken off."""
SHARPENING_RATIOS = (0.06, 0.5), (0.015, 0.6)
"""Standard deviations of Gaussians, relative to the face's height, and the factors by which what differs from
them is raised around eyes, nose and mouth."""
SKIN_SHARE, INK_SHARE = 0.65, 0.015
"""Quantiles of luma of the face that is lit skin, and of eyes and mouth that is as dark as ink. These and the
above were tuned on 20 faces of 80 to 220 of 1080 lines in ink, comic and manga."""
MIN_CONTRAST_RATIO = 0.25
"""Difference of the two, relative to the skin, at least: noise is no feature."""
MIN_SKIN_LUMA = 0.05
"""Luma of lit skin, at least: black has no features."""
MAX_QUANTILE_SAMPLES = 8192
"""Values of which a quantile is taken, at most."""


def face_darkness(luma: np.ndarray, inner: np.ndarray, areas: Areas, height: float) -> np.ndarray:
    """Return the darkness of a face: 0 for lit skin, 1 for its darkest strokes, less than 0 for whites.

    Args:
        luma: the window of the face, H x W float32, 0..1.
        inner: mask of the face, in the same way.
        areas: where features are.
        height: height of the face in pixels.
    """
    face = inner > 0.5
    bright = quantile(luma[face], 0.75) if face.any() else 1.0
    shade = weighted_mean(luma, inner, SHADE_RATIO * height) - np.float32(bright)
    even = luma - np.float32(SHADE_WEIGHT) * inner * shade
    for ratio, factor in SHARPENING_RATIOS:
        even = even + np.float32(factor) * areas.whole * (even - blurred(even, max(0.6, ratio * height)))
    parts = areas.parts > 0.5
    skin = max(quantile(even[face], SKIN_SHARE) if face.any() else 1.0, MIN_SKIN_LUMA)
    dark = quantile(even[parts], INK_SHARE) if parts.any() else 0.0
    return np.asarray((np.float32(skin) - even) / np.float32(max(skin - dark, MIN_CONTRAST_RATIO * skin)))


def quantile(values: np.ndarray, share: float) -> float:
    """Return a quantile, of `MAX_QUANTILE_SAMPLES` values at most."""
    return float(percentiles(values.ravel()[:: -(-values.size // MAX_QUANTILE_SAMPLES)], [100 * share])[0])
