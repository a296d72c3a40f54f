"""The pictures that a style brings along, as array textures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import moderngl


class AssetTextures:
    """Array textures by the arrays that they hold. Whoever calls it owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._textures: dict[int, tuple[tuple[np.ndarray, ...], moderngl.TextureArray]] = {}

    def get(self, arrays: tuple[np.ndarray, ...]) -> moderngl.TextureArray:
        """One layer for each array, in its upper left corner; an empty one for none.

        Args:
            arrays: H x W float32, or H x W x 4 float16 or float32.
        """
        key = id(arrays)
        if key not in self._textures:
            # The arrays are kept with the texture, so that nothing else can come to have their identity.
            self._textures[key] = arrays, self._make(arrays or (np.zeros((1, 1), np.float32),))
        return self._textures[key][1]

    def release(self) -> None:
        """Let all go."""
        while self._textures:
            self._textures.popitem()[1][1].release()

    def _make(self, arrays: tuple[np.ndarray, ...]) -> moderngl.TextureArray:
        height, width = (max(array.shape[axis] for array in arrays) for axis in (0, 1))
        components, dtype = arrays[0].shape[2:] or (1,), arrays[0].dtype
        layers = np.zeros((len(arrays), height, width, *components), dtype)
        for layer, array in zip(layers, arrays, strict=True):
            layer[: array.shape[0], : array.shape[1]] = array.reshape(*array.shape[:2], *components)
        size, bits = (width, height, len(arrays)), f"f{dtype.itemsize}"
        texture = self._context.texture_array(size, components[0], layers.tobytes(), dtype=bits)
        texture.filter = self._context.NEAREST, self._context.NEAREST
        return texture
