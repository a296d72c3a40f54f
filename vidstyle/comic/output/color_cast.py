"""Reduction of a strong colour cast, which styles would turn into one pure colour."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.media.resize import reduce_picture

_SAMPLE_SIDE_PX = 160
"""Longer side of the copy in which the cast is measured."""
_LIGHT_PERCENTILE_RANGE, _MAX_NEUTRAL_PERCENTILE = (75, 99), 10
"""Percentiles of lightness between which a pixel is a light, and percentile of chroma up to which a light is
one of the most neutral ones."""
_MIN_CAST_CHROMA, _MIN_CONCENTRATION = 30.0, 0.95
"""Chroma (CIELAB) of the most neutral lights from which a picture has a cast, and concentration of all its
hues, 0..1.

Of more than 40 films and 69 photographs, two films have one: a room in the light of a bulb, and a toy by a
lamp. Night skies, meadows and flowers have lights that are more neutral, or several hues.
"""
_REMOVED_SHARE = 0.7
"""How much of the cast is removed: 1 makes the most neutral lights grey, as if the light were white."""


def reduce_color_cast(color: np.ndarray) -> np.ndarray:
    """Return a picture, H x W x 3 uint8, in whiter light if all of it has the colour of its light.

    The channels are scaled by the colour of the most neutral lights (von Kries), whose luma stays.
    """
    light = _cast_color(color)
    if light is None:
        return color
    gains = (float(_luma(light)) / np.maximum(light, 1 / 255)) ** _REMOVED_SHARE
    gains *= float(_luma(light)) / float(_luma(light * gains))
    return np.clip(color * gains.astype(np.float32) + 0.5, 0, 255).astype(np.uint8)


def _cast_color(color: np.ndarray) -> np.ndarray | None:
    """Return the RGB colour of the most neutral lights, 0..1, if the picture has a strong cast."""
    small = reduce_picture(color, _SAMPLE_SIDE_PX).astype(np.float32) / 255
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB)
    chroma = np.linalg.norm(lab[..., 1:], axis=2)
    low, high = np.percentile(lab[..., 0], _LIGHT_PERCENTILE_RANGE)
    is_light = (lab[..., 0] >= low) & (lab[..., 0] <= high)
    limit = np.percentile(chroma[is_light], _MAX_NEUTRAL_PERCENTILE)
    spread = np.linalg.norm(lab[..., 1:].mean(axis=(0, 1)))
    if limit < _MIN_CAST_CHROMA or spread < _MIN_CONCENTRATION * chroma.mean():
        return None
    return np.asarray(small[is_light & (chroma <= limit)].mean(axis=0))


def _luma(color: np.ndarray) -> np.ndarray:
    """Return the luma of one RGB colour."""
    pixel = color.astype(np.float32).reshape(1, 1, 3)
    return np.asarray(cv2.cvtColor(pixel, cv2.COLOR_RGB2GRAY)[0, 0])
