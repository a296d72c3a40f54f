"""Conversion between codes and values without kernels, for small parts of pictures."""

from __future__ import annotations

import numpy as np

from vidstyle.core.picture import Encoding


def values_from_codes(codes: np.ndarray, kind: str, encoding: Encoding) -> np.ndarray:
    """Return working values of samples, float32: luma and RGB 0..1, chroma -0.5..0.5.

    Args:
        kind: of the plane: "luma", "chroma" or "color".
    """
    zero, span = _levels(kind, encoding)
    return np.asarray((codes - np.float32(zero)) / np.float32(span))


def codes_from_values(values: np.ndarray, kind: str, encoding: Encoding) -> np.ndarray:
    """Return the codes of working values, clipped to those of black and white; see `values_from_codes`."""
    zero, span = _levels(kind, encoding)
    low, high = (-0.5, 0.5) if kind == "chroma" else (0, 1)
    codes = np.clip(values, low, high) * np.float32(span) + np.float32(zero)
    return codes if encoding.depth == 0 else np.rint(codes).astype(encoding.dtype)


def _levels(kind: str, encoding: Encoding) -> tuple[float, float]:
    """Return the code of 0 and how many codes there are to 1."""
    if kind == "chroma":
        return encoding.chroma_levels
    black, white = encoding.luma_levels
    return black, white - black
