"""A pool of working textures, and textures of assets."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.gpu.compile.formats import Format
from vidstyle.gpu.compile.slots import fits
from vidstyle.style.nodes import Shape

if TYPE_CHECKING:
    import moderngl


class TexturePool:
    """Free textures for reuse. Whoever calls it owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._free: list[tuple[Format, moderngl.Texture]] = []

    def take(self, shape: Shape, coding: Format, exact: bool = False) -> moderngl.Texture:
        """A texture of at least this height and width: the smallest free one, else a new one.

        Args:
            exact: it must not be larger.
        """
        fitting = [free for free in self._free if free[0] == coding and fits(free[1], shape, exact)]
        if fitting:
            best = min(fitting, key=lambda free: free[1].width * free[1].height)
            self._free.remove(best)
            return best[1]
        texture = self._context.texture((shape[1], shape[0]), coding.components, dtype=coding.dtype)
        texture.filter = self._context.NEAREST, self._context.NEAREST
        texture.repeat_x = texture.repeat_y = False
        return texture

    def give(self, texture: moderngl.Texture, coding: Format) -> None:
        """Return a texture to the pool."""
        self._free.append((coding, texture))

    def clear(self) -> None:
        """Release all free textures."""
        for _, texture in self._free:
            texture.release()
        self._free.clear()


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
