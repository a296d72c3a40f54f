"""Colours of a restyled picture around a face."""

from __future__ import annotations

import cv2
import numpy as np

MAX_SAMPLES = 16_384
"""Samples that are measured for the brightest colour, at most."""
MIN_SKIN = 1e-3
"""Share of skin from which its mean is right; there is none to be shown below."""


def brightest_color(values: np.ndarray, luma: np.ndarray, share: float) -> np.ndarray:
    """Return the mean of the samples where luma is highest, of `MAX_SAMPLES` at most.

    Args:
        values: samples, of luma's size or a fraction of it.
        luma: of the page, H x W float32.
        share: of the pixels that count as bright.
    """
    every = max(1, round((luma.size / MAX_SAMPLES) ** 0.5))
    luma = luma[::every, ::every]
    values = cv2.resize(values, luma.shape[::-1], interpolation=cv2.INTER_NEAREST)
    return np.asarray(values[luma >= np.quantile(luma, 1 - share)].mean(axis=0), np.float32)


def local_mean(values: np.ndarray, size: float, step: tuple[int, int]) -> np.ndarray:
    """Return the mean of the samples nearby."""
    return cv2.blur(values, (max(1, round(size / step[0])), max(1, round(size / step[1]))))


def skin_mean(values: np.ndarray, skin: np.ndarray, size: float, step: tuple[int, int]) -> np.ndarray:
    """Return the mean of the samples nearby that are skin; `skin`: mask of their height and width."""
    total = local_mean(values * skin, size, step)
    area = local_mean(skin, size, step)
    return total / np.maximum(area.reshape(skin.shape), np.float32(MIN_SKIN))
