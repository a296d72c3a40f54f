"""Short generated films for the tests of temporal processing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import cv2
import numpy as np
from media import photograph

from vidstyle.core.picture import Encoding, Picture

VIDEO = Encoding()
RATE = 25
"""Frames per second."""


@cache
def page(height: int, width: int, name: str = "coffee") -> np.ndarray:
    """Return luma and chroma of a photograph as 8-bit video codes, H x W x 3 float32."""
    color = cv2.resize(photograph(name), (width, height), interpolation=cv2.INTER_AREA)
    luma, red, blue = np.moveaxis(cv2.cvtColor(color, cv2.COLOR_RGB2YCrCb).astype(np.float32), 2, 0)
    return np.stack([16 + luma * 219 / 255, 128 + (blue - 128) * 224 / 255, 128 + (red - 128) * 224 / 255], 2)


def picture(planes: np.ndarray, encoding: Encoding = VIDEO) -> Picture:
    """Return a picture in an encoding, from codes of 8-bit 4:4:4 video, H x W x 3; codes are rounded."""
    across, down = encoding.subsampling
    unit = 2.0 ** (encoding.depth - 8)
    codes = np.clip(np.rint(planes * unit), 0, 256 * unit - 1).astype(encoding.dtype)
    blue, red = (np.ascontiguousarray(codes[::down, ::across, number]) for number in (1, 2))
    return Picture(encoding, luma=np.ascontiguousarray(codes[..., 0]), chroma=(blue, red))


def noisy(planes: np.ndarray, deviation: float, number: int) -> np.ndarray:
    """Add noise to the frame `number` of a film; each frame has different noise."""
    random = np.random.default_rng(number)
    return planes + random.normal(0, deviation, planes.shape).astype(np.float32)


def still_film(count: int, deviation: float = 4, shape: tuple[int, int] = (180, 320)) -> Iterator[Picture]:
    """Return a film of a still scene with camera noise."""
    return (picture(noisy(page(*shape), deviation, number)) for number in range(count))


def panned_film(
    count: int, pixels: int = 3, deviation: float = 4, encoding: Encoding = VIDEO
) -> Iterator[Picture]:
    """Yield a film of a camera that pans over a scene, with noise."""
    wide = page(180, 320 + pixels * count)
    for number in range(count):
        shown = wide[:, number * pixels : number * pixels + 320]
        yield picture(noisy(shown, deviation, number), encoding)
