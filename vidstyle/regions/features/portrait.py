"""Darkness of each part of a face, relative to its lit skin, from which the face is drawn."""

from __future__ import annotations

import numpy as np

from vidstyle.core.sampling import sampled_quantile
from vidstyle.regions.features.areas import Areas
from vidstyle.regions.features.blurring import blurred, weighted_mean

SHADE_RATIO, SHADE_WEIGHT = 0.25, 0.5
"""Standard deviation of the Gaussian that finds light and shade, relative to the face's height; and the share
of light and shade that is removed."""
SHARPENING_RATIOS, MIN_SHARPENING_PX = ((0.06, 0.5), (0.015, 0.6)), 0.6
"""Standard deviations of Gaussians, relative to the face's height, and the factors by which differences from
them are raised around eyes, nose and mouth; and the smallest standard deviation."""
BRIGHT_SHARE = 0.75
"""Quantile of luma of the face from which light and shade are measured."""
SKIN_SHARE, INK_SHARE = 0.65, 0.015
"""Quantiles of luma of the face that is lit skin, and of eyes and mouth that is as dark as ink. All values
above were tuned on 20 faces of 80 to 220 of 1080 lines in ink, comic and manga."""
MIN_CONTRAST_RATIO = 0.25
"""Difference of the two, relative to the skin, at least: noise is no feature."""
MIN_SKIN_LUMA = 0.05
"""Luma of lit skin, at least: black has no features."""


def face_darkness(luma: np.ndarray, inner: np.ndarray, areas: Areas, height: float) -> np.ndarray:
    """Return the darkness of a face: 0 for lit skin, 1 for its darkest strokes, less than 0 for whites.

    Args:
        luma: the window of the face, H x W float32, 0..1.
        inner: mask of the face, H x W float32, 0..1.
        areas: masks of its features.
        height: height of the face in pixels.
    """
    face, parts = inner > 0.5, areas.parts > 0.5
    bright = sampled_quantile(luma[face], BRIGHT_SHARE, default=1.0)
    shade = weighted_mean(luma, inner, SHADE_RATIO * height) - np.float32(bright)
    even = luma - np.float32(SHADE_WEIGHT) * inner * shade
    for ratio, factor in SHARPENING_RATIOS:
        sigma = max(MIN_SHARPENING_PX, ratio * height)
        even = even + np.float32(factor) * areas.core * (even - blurred(even, sigma))
    skin = max(sampled_quantile(even[face], SKIN_SHARE, default=1.0), MIN_SKIN_LUMA)
    dark = sampled_quantile(even[parts], INK_SHARE, default=0.0)
    return np.asarray((np.float32(skin) - even) / np.float32(max(skin - dark, MIN_CONTRAST_RATIO * skin)))
