"""Noise of a single picture, which has no other frames to remove it with."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import cv2
import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.stabilize.motion import noise_level

MIN_NOISE_LEVEL = 3 / 255
"""Noise below it stays: 54 clean photographs have at most 2.2 / 255, ones of a dim room 8 / 255 or more."""
NOISE_VARIANCE_FACTOR = 0.8
"""Local variance that counts as noise, relative to the estimate. Tuned so that small faces keep features."""
WINDOW_SIZES_PX = 9, 5
"""Windows of the local mean, one after the other: the smaller one removes noise nearer to edges."""


def flatten_still(request: FrameRequest, steady: float) -> FrameRequest:
    """Flatten the noise of a picture that stands alone, which a style would turn into lines and specks.

    Keeps edges and alpha. `Stabilizer` does this for films.

    Args:
        steady: as in a style; 0 for no change.

    Returns:
        The same request if it is a frame of a film, or has little noise.
    """
    picture = request.picture
    level = noise_level(picture) if steady and request.time is None else 0
    if level < MIN_NOISE_LEVEL:
        return request
    black, white = picture.encoding.luma_levels
    variance = np.float32((level * (white - black)) ** 2)
    return replace(request, picture=picture.map_planes(partial(_flatten, variance=variance)))


def _flatten(plane: np.ndarray, kind: str, variance: np.float32) -> np.ndarray:
    if kind == "alpha":
        return plane
    values = plane.astype(np.float32)
    for size in WINDOW_SIZES_PX:
        values = _smooth(values, variance, size)
    return values if plane.dtype.kind == "f" else np.rint(values).astype(plane.dtype)


def _smooth(values: np.ndarray, variance: np.float32, size: int) -> np.ndarray:
    """Mix samples, H x W or H x W x 3, with their local mean, which remains where there is only noise.

    He, Sun and Tang 2013, "Guided Image Filtering", with the weights of Lee 1980; the same for all channels.
    """

    def local_mean(plane: np.ndarray) -> np.ndarray:
        return cv2.blur(plane, (size, size), borderType=cv2.BORDER_REFLECT_101)

    channels = values.shape[2:]
    guide = values.mean(axis=2) if channels else values
    mean = local_mean(guide)
    spread = np.maximum(local_mean(guide * guide) - mean * mean, np.float32(1e-9))
    noise = variance * np.float32(NOISE_VARIANCE_FACTOR / (channels[0] if channels else 1))
    weight = np.maximum(1 - noise / spread, np.float32(0))
    if channels:
        weight = np.repeat(weight[..., None], channels[0], axis=2)
    return local_mean(weight) * values + local_mean((1 - weight) * local_mean(values))
