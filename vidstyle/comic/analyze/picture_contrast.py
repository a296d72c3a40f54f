"""Exposure, contrast and colours of a picture."""

from __future__ import annotations

import cv2
import numpy as np

_MAX_BLANK_RANGE = 0.1
"""Maximum range of lightness of a blank picture between percentiles 2 and 98, 0..1."""
_FULL_CONTRAST_DEVIATION = 0.18
"""Standard deviation of lightness of a picture with full contrast, 0..1."""
_FULL_LIGHT_LEVEL = 0.43
"""Percentile 80 of lightness of a well-lit picture, 0..1."""
_FULL_FORMS_DEVIATION = 0.16
"""Standard deviation of lightness and chroma together of a picture with distinct large forms, 0..1."""
_FORMS_SIDE_PX, _FORMS_BLUR_PX = 64, 2.0
"""Longer side of the copy in which large forms are measured, and standard deviation of its Gaussian."""
_MAX_CLIPPED_SHARE = 0.3
"""Share of a picture that may be clipped without penalty, for nights and skies."""


def measure_exposure(luma: np.ndarray) -> float:
    """Measure how well a picture, H x W uint8, is exposed: 0..1."""
    contrast = min(1.0, float(luma.std()) / 255 / _FULL_CONTRAST_DEVIATION)
    light = min(1.0, _percentiles(luma, 80)[0] / 255 / _FULL_LIGHT_LEVEL)
    clipped = float(np.mean((luma < 10) | (luma > 250)))
    return contrast * light * (1 - max(0.0, clipped - _MAX_CLIPPED_SHARE) / (1 - _MAX_CLIPPED_SHARE))


def measure_forms(color: np.ndarray) -> float:
    """Measure the contrast of the large forms of a picture, H x W x 3 uint8: 0..1.

    In print, large forms remain recognizable in a panel whose details are too small.
    """
    factor = _FORMS_SIDE_PX / max(color.shape)
    height, width = (max(1, round(side * factor)) for side in color.shape[:2])
    small = cv2.resize(color, (width, height), interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)
    coarse = cv2.GaussianBlur(lab, (0, 0), _FORMS_BLUR_PX)
    return min(1.0, float(np.sqrt(coarse.var(axis=(0, 1)).sum())) / 255 / _FULL_FORMS_DEVIATION)


def is_blank(luma: np.ndarray) -> bool:
    """Whether the picture, H x W uint8, is black, white or one tone."""
    darkest, brightest = _percentiles(cv2.GaussianBlur(luma, (0, 0), 2), 2, 98)
    return brightest - darkest < 255 * _MAX_BLANK_RANGE


def _percentiles(luma: np.ndarray, *shares: float) -> list[int]:
    """Return percentiles of H x W uint8."""
    counts = np.bincount(luma.ravel(), minlength=256).cumsum()
    return [int(np.searchsorted(counts, share / 100 * luma.size)) for share in shares]


def color_histogram(color: np.ndarray) -> np.ndarray:
    """Return the shares of 64 colours in a picture, H x W x 3 uint8: float32 of sum 1."""
    small = cv2.resize(color, (48, 48), interpolation=cv2.INTER_AREA)
    counts = cv2.calcHist([small], [0, 1, 2], None, [4, 4, 4], [0, 256] * 3).ravel()
    return (counts / counts.sum()).astype(np.float32)
