"""Pictures of looks on the start screen: all the width of a frame."""

from __future__ import annotations

from functools import cached_property, reduce

import numpy as np

from vidstyle.explore.crops.full_size import Crop, tones_of
from vidstyle.explore.measure import MAX_DRAWN_SIDE_PX
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.media.resize import reduce_picture
from vidstyle.preview.clip import Clip
from vidstyle.regions.boxes import Box
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.style import Style
from vidstyle.style.resolve import masks_read

TILE_WIDTH_PX, TILE_ASPECT = 640, 16 / 9
"""Width at which tiles are rendered, and their width divided by their height."""
FACE_MARGIN_RATIO = 0.15
"""Room above and below the faces, relative to the height of all."""
TOP_RATIO = 0.25
"""The part of what a tile leaves out that is above it, without faces: heads are rarely at the bottom."""


class LookTiles:
    """Renders a part of one frame in any style, with lengths and percentiles of the whole frame."""

    def __init__(self, clip: Clip, number: int, faces: KnownFaces) -> None:
        """`faces`: the faces of the frame."""
        self._clip, self._number, self._faces = clip, number, faces

    def render(self, style: Style, width: int = TILE_WIDTH_PX) -> np.ndarray:
        """Return the tile of a style, H x W x 3 uint8.

        Args:
            width: the maximum width in pixels; a browser would scale fine dots to false patterns.

        Raises:
            StyleError: the style does not fit the clip.
        """
        if any("file" in style.masks.get(name, {}) for name in masks_read(style)):
            return reduce_picture(self._whole(style), width)
        return reduce_picture(self._crop.render(style, tones_of(style, self._small)), width)

    def _whole(self, style: Style) -> np.ndarray:
        """Render the whole frame, which the masks cover; return the part that the tile shows."""
        frame, part = self._view
        styled = restyle_picture(frame, style, self._faces, min(self._clip.size))
        return styled[part.top : part.bottom, part.left : part.right]

    @cached_property
    def _crop(self) -> Crop:
        frame, part = self._view
        faces = {box.scaled(frame.shape[0]): marks for box, marks in self._faces.boxes.items()}
        return Crop(frame, part, faces, self._faces.detail, min(self._clip.size))

    @cached_property
    def _view(self) -> tuple[np.ndarray, Box[int]]:
        """The frame, and the part of it that the tile shows."""
        aspect = self._clip.size[0] / self._clip.size[1]
        window = tile_window(aspect, list(self._faces.boxes))
        side = round(TILE_WIDTH_PX / window.width * min(1.0, aspect))
        frame = np.ascontiguousarray(self._clip.frame(self._number, side))
        rows, columns = frame.shape[:2]
        left, top, right, bottom = (round(each) for each in window.scaled(rows))
        return frame, Box(left, top, max(min(right, columns), left + 1), max(bottom, top + 1))

    @cached_property
    def _small(self) -> np.ndarray:
        """The whole frame, on which styles take their measurements."""
        small = np.ascontiguousarray(self._clip.frame(self._number, MAX_DRAWN_SIDE_PX))
        return reduce_picture(small, MAX_DRAWN_SIDE_PX)


def tile_window(aspect: float, faces: list[Box]) -> Box[float]:
    """Return the part of a picture of height 1 that a tile shows: all its width, so that nobody is cut off.

    It is higher than a tile if the faces need it.

    Args:
        aspect: width divided by height of the picture.
        faces: faces in it.
    """
    height = min(aspect / TILE_ASPECT, 1.0)
    if not faces:
        top = TOP_RATIO * (1.0 - height)
        return Box(0.0, top, aspect, top + height)
    group = reduce(Box.union, faces)
    height = min(max(height, (1 + 2 * FACE_MARGIN_RATIO) * group.height), 1.0)
    top = min(max(group.center[1] - height / 2, 0.0), 1.0 - height)
    return Box(0.0, top, aspect, top + height)
