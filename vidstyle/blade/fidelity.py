"""How close a bank comes to what it imitates."""

from __future__ import annotations

import cv2
import numpy as np

WINDOW = 11
"""Pixels of the window of structural similarity, as its authors have it; the border is left out."""


def psnr(result: np.ndarray, target: np.ndarray) -> float:
    """Peak signal-to-noise ratio in dB, for values whose peak is 1."""
    error = float(np.mean(np.square(result.astype(np.float64) - target)))
    return float("inf") if error == 0 else -10 * np.log10(error)


def mssim(result: np.ndarray, target: np.ndarray) -> float:
    """Mean structural similarity with a Gaussian window of 1.5 px; Wang and others 2004."""

    def blurred(values: np.ndarray) -> np.ndarray:
        return cv2.GaussianBlur(values, (WINDOW, WINDOW), 1.5, borderType=cv2.BORDER_REPLICATE)

    one, two = result.astype(np.float64), target.astype(np.float64)
    mean_one, mean_two = blurred(one), blurred(two)
    variance_one = blurred(one * one) - mean_one**2
    variance_two = blurred(two * two) - mean_two**2
    covariance = blurred(one * two) - mean_one * mean_two
    low, high = 0.01**2, 0.03**2
    similarity = (2 * mean_one * mean_two + low) * (2 * covariance + high)
    similarity /= (mean_one**2 + mean_two**2 + low) * (variance_one + variance_two + high)
    inside = similarity[WINDOW // 2 : -(WINDOW // 2), WINDOW // 2 : -(WINDOW // 2)]
    return float((inside if inside.size else similarity).mean())
