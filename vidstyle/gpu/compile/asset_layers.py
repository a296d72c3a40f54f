"""The arrays of an asset as the layers of one texture."""

from __future__ import annotations

import numpy as np


def layers_of(arrays: tuple[np.ndarray, ...]) -> np.ndarray:
    """One layer for each array, in its upper left corner; a single empty pixel for none.

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
