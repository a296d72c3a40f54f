"""The arrays of an asset as the layers of one texture."""

from __future__ import annotations

import hashlib
from base64 import b64encode
from dataclasses import dataclass
from typing import Any

import numpy as np

from vidstyle.core.color.film_colors import CONSTANTS, FilmTable

MAX_TEXTURES = 16
"""Number of textures from which on all are discarded; a style has up to eight."""

_textures: dict[int, AssetTexture] = {}


@dataclass(frozen=True)
class AssetTexture:
    """The texture of an asset in a plan of the form "es"; `name` stands for its content."""

    arrays: tuple[np.ndarray, ...]
    name: str

    @property
    def data(self) -> dict[str, Any]:
        """Its sizes and content as plain data; for the film's own colours, also how they are measured."""
        layers = layers_of(self.arrays)
        count, height, width, components = layers.shape
        film = {"film": CONSTANTS} if isinstance(self.arrays, FilmTable) else {}
        return film | {
            "size": [width, height, count],
            "components": components,
            "type": "half" if layers.dtype == np.float16 else "float",
            "data": b64encode(layers.tobytes()).decode("ascii"),
        }


def asset_texture(arrays: tuple[np.ndarray, ...]) -> AssetTexture:
    """Return the texture of some arrays; a tuple is read once, unless it holds a film's own colours."""
    if isinstance(arrays, FilmTable):
        return _read_texture(arrays)
    if id(arrays) not in _textures:
        if len(_textures) >= MAX_TEXTURES:
            _textures.clear()
        # The texture keeps the arrays, so that their identity is not reused.
        _textures[id(arrays)] = _read_texture(arrays)
    return _textures[id(arrays)]


def _read_texture(arrays: tuple[np.ndarray, ...]) -> AssetTexture:
    layers = layers_of(arrays)
    content = layers.tobytes() + repr((type(arrays), layers.shape)).encode()
    return AssetTexture(arrays, hashlib.sha256(content).hexdigest()[:16])


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
