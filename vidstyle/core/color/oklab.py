"""OKLab: Ottosson 2020, "A perceptual color space for image processing"."""

from __future__ import annotations

import numpy as np

CONE_WEIGHTS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
LAB_WEIGHTS = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def light_of(values: np.ndarray) -> np.ndarray:
    """Light of sRGB values, 0..1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab_from_rgb(colors: np.ndarray) -> np.ndarray:
    """OKLab of sRGB colours within 0..1, both 3 x n float64."""
    return _product(LAB_WEIGHTS, np.cbrt(_product(CONE_WEIGHTS, light_of(colors))))


def rgb_from_lab(lab: np.ndarray) -> np.ndarray:
    """Return the inverse of `lab_from_rgb`, clipped to 0..1."""
    light = _product(np.linalg.inv(CONE_WEIGHTS), _product(np.linalg.inv(LAB_WEIGHTS), lab) ** 3).clip(0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def _product(matrix: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Matrix times 3 x n columns, by hand: a library's product depends on the number of threads."""
    return np.stack([row[0] * columns[0] + row[1] * columns[1] + row[2] * columns[2] for row in matrix])
