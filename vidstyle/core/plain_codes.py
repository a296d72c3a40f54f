"""Conversion between codes and values without kernels, for small parts of pictures."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Encoding, Picture


def values_from_codes(codes: np.ndarray, kind: str, encoding: Encoding) -> np.ndarray:
    """Return working values of samples, float32: luma and RGB 0..1, chroma -0.5..0.5.

    Args:
        kind: of the plane: "luma", "chroma" or "color".
    """
    zero, span = _levels(kind, encoding)
    return np.asarray((codes - np.float32(zero)) / np.float32(span))


def codes_from_values(values: np.ndarray, kind: str, encoding: Encoding) -> np.ndarray:
    """Return the codes of working values, clipped to black and white; see `values_from_codes`."""
    zero, span = _levels(kind, encoding)
    low, high = (-0.5, 0.5) if kind == "chroma" else (0, 1)
    codes = np.clip(values, low, high) * np.float32(span) + np.float32(zero)
    return codes if encoding.depth == 0 else np.rint(codes).astype(encoding.dtype)


class PartLuma:
    """Luma of a part of a picture, which can be changed in place without a change of its chroma.

    Args:
        picture: the picture.
        area: rows and columns.

    Attributes:
        luma: H x W float32, 0..1; a change of the picture leaves it unchanged.
    """

    def __init__(self, picture: Picture, area: tuple[slice, slice]) -> None:
        plane = picture.luma if picture.color is None else picture.color
        assert plane is not None
        self._codes, self._encoding = plane[area], picture.encoding
        self._values = values = values_from_codes(self._codes, "luma", self._encoding)
        self.luma = values if values.ndim == 2 else cv2.transform(values, self._encoding.weights[None])

    def add(self, change: np.ndarray) -> None:
        """Add this to the luma, in RGB to each channel; H x W float32."""
        values = self._values + (change if self._values.ndim == 2 else change[..., None])
        self._codes[:] = codes_from_values(values, "luma", self._encoding)


def _levels(kind: str, encoding: Encoding) -> tuple[float, float]:
    """Return the code of 0 and how many codes there are to 1."""
    if kind == "chroma":
        return encoding.chroma_levels
    black, white = encoding.luma_levels
    return black, white - black
