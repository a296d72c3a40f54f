"""Pictures of films as plain RGB, for pages of pictures."""

from __future__ import annotations

from fractions import Fraction

import cv2
import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu import CpuRenderer
from vidstyle.style import load_style

_RGB = Encoding(full_range=True, step=(1, 1))


def rgb_of(picture: Picture) -> np.ndarray:
    """The picture as H x W x 3 uint8; where it is transparent, on the white of paper."""
    with CpuRenderer(load_style("plain")) as renderer:
        shown = renderer.run(picture, None, _RGB, rgb=True)
    assert shown.color is not None
    if shown.alpha is None:
        return np.ascontiguousarray(shown.color)
    alpha = shown.alpha[..., np.newaxis] / np.float32(255)
    return np.rint(shown.color * alpha + 255 * (1 - alpha)).astype(np.uint8)


def square(color: np.ndarray, sample_aspect: Fraction | None) -> np.ndarray:
    """The picture, H x W x 3 uint8, as wide as it is where its pixels are square; its height stays."""
    width = max(1, round(color.shape[1] * (sample_aspect or 1)))
    if width == color.shape[1]:
        return color
    smaller = width < color.shape[1]
    return cv2.resize(
        color, (width, color.shape[0]), interpolation=cv2.INTER_AREA if smaller else cv2.INTER_CUBIC
    )
