"""Lighten the shadows of a picture: ink on paper shows less of them than a screen does."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.media.resize import reduce_picture

_LIFT_FACTOR, _MIN_LIT_LEVEL, _MAX_GAIN_FACTOR = 0.42, 0.55, 2.0
"""Exponent that lightens black shadows, the light above which a part is unchanged, 0..1, and the maximum
gain.

They were tuned on dark frames of a trailer, a room and two flash photographs, in the style comic: with more
light, faces in flash light turn pale and dark rooms turn to fog.
"""
_CHROMA_EXPONENT = 0.5
"""Exponent of the gain by which colours become stronger, so that they do not fade in the light."""
_BASE_SIDE_PX, _WINDOW_SIDE_PX, _MIN_EDGE_DEVIATION = 160, 9, 0.1
"""Longer side of the copy in which the local light is measured; window of its guided filter, and deviation
from which the filter keeps an edge."""
_NEUTRAL_LEVEL = 128
"""Chroma of grey."""
_MIN_SEEN_LEVEL = 0.02
"""Light below which the eye sees no detail."""


def lift_shadows(color: np.ndarray) -> np.ndarray:
    """Return a picture, H x W x 3 uint8, with lighter shadows; lit parts and the local contrast stay.

    A face in the dark becomes visible, and one in the light of a flash next to it does not become pale.
    """
    lab = cv2.cvtColor(np.ascontiguousarray(color), cv2.COLOR_RGB2LAB)
    luma = lab[..., 0].astype(np.float32) / 255
    light = _local_light(luma)
    lit = np.clip(light / _MIN_LIT_LEVEL, 0, 1)
    shadow = 1 - lit * lit * (3 - 2 * lit)
    gain = np.minimum(light ** (-_LIFT_FACTOR * shadow), _MAX_GAIN_FACTOR)
    lab[..., 0] = np.clip(255 * luma * gain + 0.5, 0, 255).astype(np.uint8)
    chroma = lab[..., 1:].astype(np.float32) - _NEUTRAL_LEVEL
    lab[..., 1:] = np.clip(
        _NEUTRAL_LEVEL + 0.5 + chroma * (gain**_CHROMA_EXPONENT)[..., np.newaxis], 0, 255
    ).astype(np.uint8)
    return cv2.cvtColor(lab, cv2.COLOR_LAB2RGB)


def _local_light(luma: np.ndarray) -> np.ndarray:
    """Return the mean light around each pixel, H x W float32, within the edges of the picture.

    It is the guided filter of He, Sun and Tang (2010), whose coefficients are measured in a small copy.
    """
    small = reduce_picture(luma, _BASE_SIDE_PX)
    window = _WINDOW_SIDE_PX, _WINDOW_SIDE_PX
    mean = cv2.blur(small, window)
    variance = cv2.blur(small * small, window) - mean * mean
    slope = variance / (variance + _MIN_EDGE_DEVIATION**2)
    parts = (cv2.blur(each, window) for each in (slope, mean - slope * mean))
    slopes, offsets = (cv2.resize(each, luma.shape[::-1]) for each in parts)
    return np.maximum(_MIN_SEEN_LEVEL, slopes * luma + offsets)
