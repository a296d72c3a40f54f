"""Working textures, and textures of assets."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.core.color.film_colors import FilmTable
from vidstyle.gpu.compile.asset_texture import layers_of
from vidstyle.gpu.compile.shader_nodes import Format
from vidstyle.style.nodes import Shape

if TYPE_CHECKING:
    import moderngl


def new_texture(context: moderngl.Context, shape: Shape, coding: Format) -> moderngl.Texture:
    """Return a texture of a height and width, read without interpolation."""
    texture = context.texture((shape[1], shape[0]), coding.components, dtype=coding.dtype)
    texture.filter = context.NEAREST, context.NEAREST
    texture.repeat_x = texture.repeat_y = False
    return texture


class AssetTextures:
    """Array textures of assets, cached by identity. The caller owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._textures: dict[int, tuple[tuple[np.ndarray, ...], moderngl.TextureArray]] = {}

    def get(self, arrays: tuple[np.ndarray, ...]) -> moderngl.TextureArray:
        """Return the layers of the arrays, see `layers_of`; of a film's palette, its current colours."""
        key = id(arrays)
        if key not in self._textures:
            # The arrays are kept with the texture, so that their identity is not reused.
            self._textures[key] = arrays, self._make(layers_of(arrays))
        texture = self._textures[key][1]
        if isinstance(arrays, FilmTable):
            texture.write(layers_of(arrays).tobytes())
        return texture

    def trim(self, used: Iterable[tuple[np.ndarray, ...]]) -> None:
        """Release all textures except the textures of these arrays."""
        for key in self._textures.keys() - {id(arrays) for arrays in used}:
            self._textures.pop(key)[1].release()

    def _make(self, layers: np.ndarray) -> moderngl.TextureArray:
        count, height, width, components = layers.shape
        size, bits = (width, height, count), f"f{layers.dtype.itemsize}"
        texture = self._context.texture_array(size, components, layers.tobytes(), dtype=bits)
        texture.filter = self._context.NEAREST, self._context.NEAREST
        return texture
