"""Selection of a filter for each pixel by the structure tensor and a bank's additional features."""

from __future__ import annotations

import math

import cv2
import numpy as np

from vidstyle.blade.bins import Bins, Feature
from vidstyle.blade.structure_tensor import select_filters, window_radius


def choose_filters(
    luma: np.ndarray, bins: Bins, rho: float, margin: tuple[int, int] = (0, 0), top: int = 0
) -> np.ndarray:
    """Return the index of the filter for each square; arguments and result as in `select_filters`."""
    selected = select_filters(luma, bins, rho, margin, top)
    for feature in bins.features:
        selected *= feature.bins
        selected += levels_of(feature, luma, margin)
    return selected


def choice_radius(bins: Bins, rho: float) -> int:
    """Return the number of pixels on each side that a selection depends on."""
    return max(
        window_radius(rho) + (bins.curvatures > 1), *(feature_radius(each) for each in bins.features), 0
    )


def feature_radius(feature: Feature) -> int:
    """Return the number of pixels on each side that a feature depends on."""
    return math.ceil(3 * feature.rho) if feature.needs_mean else window_radius(feature.rho)


def levels_of(feature: Feature, luma: np.ndarray, margin: tuple[int, int] = (0, 0)) -> np.ndarray:
    """Return the bin of the feature at each pixel, H x W int32; undefined in the margin."""
    if not feature.needs_mean:
        return select_filters(luma, feature.tensor_bins, feature.rho, margin)
    size = 2 * feature_radius(feature) + 1
    mean = cv2.GaussianBlur(luma, (size, size), feature.rho, borderType=cv2.BORDER_REPLICATE)
    start, density = feature.start_and_density
    with np.errstate(over="ignore", invalid="ignore"):  # the margin may hold any values
        value = luma - mean if feature.name == "difference" else mean
        levels = (value - start) * density
    # If one of two numbers is NaN, these return the other one.
    return np.asarray(np.fmax(np.fmin(levels, np.float32(feature.bins - 0.5)), np.float32(0)), np.int32)
