"""Wide Gaussians on reduced copies, which differ from exact ones by about a code."""

from __future__ import annotations

import cv2
import numpy as np

MIN_SIGMA_PX = 4.0
"""Standard deviation of a Gaussian on a reduced copy, in pixels of the copy."""
MIN_WEIGHT = 1e-3
"""Added to all weights, so that the mean without selected samples is the mean of all samples nearby."""


def blurred(plane: np.ndarray, sigma: float) -> np.ndarray:
    """Return a plane after a Gaussian, H x W float32."""
    return enlarged(_reduced_blur(plane, sigma), plane.shape)


def weighted_mean(plane: np.ndarray, weight: np.ndarray, sigma: float) -> np.ndarray:
    """Return the mean of the samples nearby by their weights and a Gaussian, H x W float32."""
    weight = np.asarray(weight + np.float32(MIN_WEIGHT), np.float32)
    total, area = (_reduced_blur(each, sigma) for each in (plane * weight, weight))
    return enlarged(total / area, plane.shape)


def enlarged(plane: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return a plane at the size of a larger one."""
    is_same = plane.shape == shape
    return plane if is_same else cv2.resize(plane, shape[1::-1], interpolation=cv2.INTER_LINEAR)


def resized(plane: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return a plane at the size of a smaller or larger one."""
    if plane.size <= shape[0] * shape[1]:
        return enlarged(plane, shape)
    return cv2.resize(plane, shape[1::-1], interpolation=cv2.INTER_AREA)


def _reduced_blur(plane: np.ndarray, sigma: float) -> np.ndarray:
    """Return a plane after a Gaussian, in a copy in which that has about `MIN_SIGMA_PX`."""
    factor = max(1, int(sigma / MIN_SIGMA_PX))
    height, width = plane.shape
    size = -(-width // factor), -(-height // factor)
    small = plane if factor == 1 else cv2.resize(plane, size, interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(small, (0, 0), sigma * size[0] / width, sigmaY=sigma * size[1] / height)
