"""The arrays of an asset as the layers of one texture."""

from __future__ import annotations

import numpy as np


def layers_of(arrays: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return one layer per array, with the array in the upper left corner; one empty pixel without arrays.

    Args:
        arrays: H x W float32, or H x W x 4 float16 or float32.

    Returns:
        Layers x H x W x 1 or 4.
    """
    arrays = arrays or (np.zeros((1, 1), np.float32),)
    height, width = (max(array.shape[axis] for array in arrays) for axis in (0, 1))
    components = arrays[0].shape[2:] or (1,)
    layers = np.zeros((len(arrays), height, width, *components), arrays[0].dtype)
    for layer, array in zip(layers, arrays, strict=True):
        layer[: array.shape[0], : array.shape[1]] = array.reshape(*array.shape[:2], *components)
    return layers
