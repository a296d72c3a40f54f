"""Working textures, and textures of assets."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.gpu.compile.shader_nodes import Format
from vidstyle.style.nodes import Shape

if TYPE_CHECKING:
    import moderngl


def new_texture(context: moderngl.Context, shape: Shape, coding: Format) -> moderngl.Texture:
    """A texture of a height and width, whose texels are read as they are."""
    texture = context.texture((shape[1], shape[0]), coding.components, dtype=coding.dtype)
    texture.filter = context.NEAREST, context.NEAREST
    texture.repeat_x = texture.repeat_y = False
    return texture


class AssetTextures:
    """Array textures of assets, cached by identity. Whoever calls it owns the context."""

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
            # The arrays are kept with the texture, so that nothing else can get their identity.
            self._textures[key] = arrays, self._make(arrays or (np.zeros((1, 1), np.float32),))
        return self._textures[key][1]

    def trim(self, used: Iterable[tuple[np.ndarray, ...]]) -> None:
        """Release all textures but those of these arrays."""
        for key in self._textures.keys() - {id(arrays) for arrays in used}:
            self._textures.pop(key)[1].release()

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
