"""Noise of a single picture, which has no other frames to remove it with."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import cv2
import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.stabilize.motion import plane_noise_level

MIN_NOISE_LEVELS = 3 / 255, 3.75 / 255
"""Noise below both stays: in the picture, and in a copy of half the size, which shows noise that the camera
has smoothed; relative to the contrast. 64 clean photographs have at most 3 / 255 and 3.5 / 255."""
MIN_CONTRAST = 0.3
"""Contrast below which it is not taken into account, relative to the distance from black to white."""
DARKEST_PERCENTILE = 2
"""Percentile of the darkest samples that count for the contrast; as many of the brightest do not."""
TEXTURE_RATIO = 0.3
"""Noise of the smaller copy that counts as texture, relative to the noise of the picture."""
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
    if not steady or request.time is not None:
        return request
    plane = picture.luma if picture.color is None else picture.color
    assert plane is not None
    black, white = picture.encoding.luma_levels
    luma = plane if plane.ndim == 2 else plane[..., 1]
    levels, limit = _noise_levels(luma), _contrast(luma, white - black)
    if all(level < limit * least for level, least in zip(levels, MIN_NOISE_LEVELS, strict=True)):
        return request
    fine, coarse = levels if plane.ndim == 2 else _noise_levels(_guide(plane))
    # White noise has half its deviation in a copy of half the size.
    variance = np.float32(max(fine, 2 * coarse - TEXTURE_RATIO * fine) ** 2)
    return replace(request, picture=picture.map_planes(partial(_flatten, variance=variance)))


def _contrast(plane: np.ndarray, span: float) -> float:
    """Return the difference of dark and bright in a plane: styles stretch low contrast, and its noise."""
    dark, bright = np.percentile(plane[::4, ::4], (DARKEST_PERCENTILE, 100 - DARKEST_PERCENTILE))
    return float(max(bright - dark, MIN_CONTRAST * span))


def _noise_levels(plane: np.ndarray) -> tuple[float, float]:
    """Return the noise of a plane, and of a copy of half its size, in the units of its samples."""
    height, width = (max(side // 2, 1) for side in plane.shape)
    half = cv2.resize(plane.astype(np.float32), (width, height), interpolation=cv2.INTER_AREA)
    return plane_noise_level(plane), plane_noise_level(half)


def _guide(plane: np.ndarray) -> np.ndarray:
    """Return the plane, H x W, or the mean of its channels, H x W x 3."""
    return plane if plane.ndim == 2 else plane.mean(axis=2, dtype=np.float32)


def _flatten(plane: np.ndarray, kind: str, variance: np.float32) -> np.ndarray:
    if kind == "alpha":
        return plane
    values = plane.astype(np.float32)
    for size in WINDOW_SIZES_PX:
        values = _smooth(values, variance, size)
    return values if plane.dtype.kind == "f" else np.rint(values).astype(plane.dtype)


def _smooth(values: np.ndarray, variance: np.float32, size: int) -> np.ndarray:
    """Mix samples, H x W or H x W x 3, with their local mean, which remains in areas of noise only.

    He, Sun and Tang 2013, "Guided Image Filtering", with the weights of Lee 1980; the same for all channels.
    """

    def local_mean(plane: np.ndarray) -> np.ndarray:
        return cv2.blur(plane, (size, size), borderType=cv2.BORDER_REFLECT_101)

    channels, guide = values.shape[2:], _guide(values)
    mean = local_mean(guide)
    spread = np.maximum(local_mean(guide * guide) - mean * mean, np.float32(1e-9))
    noise = variance * np.float32(NOISE_VARIANCE_FACTOR)
    weight = np.maximum(1 - noise / spread, np.float32(0))
    if channels:
        weight = np.repeat(weight[..., None], channels[0], axis=2)
    return local_mean(weight) * values + local_mean((1 - weight) * local_mean(values))
