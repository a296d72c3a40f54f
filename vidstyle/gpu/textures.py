"""Working textures, used again by what comes later."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vidstyle.gpu.formats import Format
from vidstyle.gpu.nodes import Shape

if TYPE_CHECKING:
    import moderngl

WASTE = 2
"""A texture serves for a picture of at least this part of its own area."""


class TexturePool:
    """Textures that nobody uses at the moment. Whoever calls it owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._free: list[tuple[Format, moderngl.Texture]] = []

    def take(self, shape: Shape, coding: Format, exact: bool = False) -> moderngl.Texture:
        """A texture of at least this height and width: the smallest that is free, else a new one.

        Args:
            exact: it must not be larger, because it will be read as a whole.
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
        """Take a texture back."""
        self._free.append((coding, texture))

    def clear(self) -> None:
        """Let go of all textures that nobody has taken."""
        for _, texture in self._free:
            texture.release()
        self._free.clear()


def fits(texture: moderngl.Texture, shape: Shape, exact: bool) -> bool:
    """Whether a texture serves for a picture of this height and width."""
    size = texture.height, texture.width
    if exact:
        return size == shape
    enough = size[0] >= shape[0] and size[1] >= shape[1]
    return enough and size[0] * size[1] <= WASTE * shape[0] * shape[1]
