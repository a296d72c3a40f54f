"""Pictures of looks on the start screen: one frame in each."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.media.resize import reduce_picture
from vidstyle.preview.clip import Clip
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.style import Style

TILE_WIDTH_PX, TILE_HEIGHT_PX = 640, 360
"""The size of tiles of 16:9; tiles of other shapes have the same number of pixels."""


class LookTiles:
    """Renders one frame in any style, and keeps the tiles: a page may be loaded again."""

    def __init__(self, clip: Clip, number: int, faces: KnownFaces) -> None:
        """`faces`: the faces of the frame."""
        self.clip, self.number, self._faces = clip, number, faces
        self._rendered: dict[str, tuple[Style, int, np.ndarray]] = {}

    def render(self, style: Style, width: int = TILE_WIDTH_PX) -> np.ndarray:
        """Return the tile of a style, H x W x 3 uint8.

        Args:
            width: the maximum width in pixels; a browser would scale fine dots to false patterns.

        Raises:
            StyleError: the style does not fit the clip.
        """
        earlier, at, tile = self._rendered.get(style.name, (None, 0, None))
        if tile is None or (earlier, at) != (style, width):
            styled = restyle_picture(self._frame, style, self._faces, min(self.clip.size))
            rows, columns = styled.shape[:2]
            tile = reduce_picture(styled, round(width * max(1.0, rows / columns)))
            self._rendered[style.name] = style, width, tile
        return tile

    @cached_property
    def _frame(self) -> np.ndarray:
        columns, rows = self.clip.size
        side = max(1, round((TILE_WIDTH_PX * TILE_HEIGHT_PX * min(columns / rows, rows / columns)) ** 0.5))
        return np.ascontiguousarray(self.clip.frame(self.number, side))
