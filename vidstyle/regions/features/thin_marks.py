"""Thin dark strokes of a face, which ink draws, and the soft shade between them."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.sampling import percentiles

THIN_RATIO = 0.08
"""Diameter of the disc that fills strokes outside the eyes, such as nostrils and the line between the lips,
relative to the face's height: lips, and a shadow beside the nose, are wider. Tuned on 20 faces of 80 to 220
lines in ink, comic and woodcut."""
EYE_SHADE_SHARE = 0.6
"""Share of the soft shade around eyes that is left out: hatching would hide them."""
SOFTNESS_RATIO = 0.03
"""Standard deviation of the Gaussian that smooths skin without features, in the same way."""
SHADE_EXPONENT = 0.4
"""How much of the shade between strokes, such as in an eye socket, is kept: 1 for all."""
NEAR_RATIO = 0.25
"""Side of the square in which the strongest stroke is full ink, in the same way."""
DARKNESS_RANGE = 0.16, 0.8
"""Darkness of the strongest stroke nearby, relative to the skin, at least and at most: a faint shadow does
not become black."""
MIN_DARKNESS_RATIO, MIN_INK_RATIO, STRONGEST_SHARE = 0.5, 0.35, 0.97
"""The same, at least, relative to the strongest strokes of the face, in tones and of thin strokes; and the
quantile that counts as these."""
MAX_QUANTILE_SAMPLES = 8192
"""Values of which a quantile is taken, at most."""


class Areas(NamedTuple):
    """Soft masks in the window of a face, H x W float32, 0..1.

    Attributes:
        parts: eyes and mouth.
        whole: all that belongs to features.
        weights: how much a dark mark counts.
        eyes: eyes with their brows.
    """

    parts: np.ndarray
    whole: np.ndarray
    weights: np.ndarray
    eyes: np.ndarray


def thin_marks(
    luma: np.ndarray, skin: np.ndarray, strokes: np.ndarray, areas: Areas, height: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return coverage by thin dark strokes, and luma without them relative to the skin; see `FeatureTones`.

    Args:
        luma, skin, strokes: luma, without features, and without strokes, H x W float32.
        areas: where features are.
        height: of the face in pixels.
    """
    thin = np.minimum(cv2.morphologyEx(luma, cv2.MORPH_CLOSE, disc(THIN_RATIO * height)), strokes)
    ground = thin + areas.eyes * (strokes - thin)
    socket = 1 + areas.eyes * (cv2.pow(strokes / skin, SHADE_EXPONENT) - 1)
    darkness = np.maximum(1 - luma / ground * socket, 0)
    peak = peak_of(darkness, areas.parts, height, MIN_INK_RATIO)
    form = cv2.GaussianBlur(ground, (0, 0), max(0.5, SOFTNESS_RATIO * height)) / skin
    shade = (1 - np.float32(EYE_SHADE_SHARE) * areas.eyes) * np.maximum(1 - form, 0)
    return np.minimum(areas.weights * darkness / peak, 1), 1 - shade


def peak_of(
    darkness: np.ndarray, parts: np.ndarray, height: float, least_ratio: float = MIN_DARKNESS_RATIO
) -> np.ndarray:
    """Return the darkness of the strongest mark nearby, within limits.

    Args:
        darkness: of marks, H x W float32, 0..1.
        parts: eyes and mouth, in the same way.
        height: of the face in pixels.
        least_ratio: the least, relative to the darkness of the face's strongest strokes.
    """
    size = max(1, round(NEAR_RATIO * height))
    peak = cv2.blur(cv2.dilate(darkness * parts, np.ones((size, size), np.uint8)), (size, size))
    least, most = DARKNESS_RANGE
    strongest = quantile(darkness[parts > 0.5], STRONGEST_SHARE) if parts.max() > 0.5 else most
    return np.clip(peak, min(most, max(least, least_ratio * strongest)), most)


def quantile(values: np.ndarray, share: float) -> float:
    """Return a quantile, of `MAX_QUANTILE_SAMPLES` values at most."""
    return float(percentiles(values.ravel()[:: -(-values.size // MAX_QUANTILE_SAMPLES)], [100 * share])[0])


def disc(size: float) -> np.ndarray:
    """Return a disc for morphology, of at least three pixels."""
    side = max(3, 2 * int(size / 2) + 1)
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
