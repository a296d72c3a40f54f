"""Pictures of looks on the start screen: the part of a frame that shows a style best."""

from __future__ import annotations

from functools import cached_property

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
FACE_RATIO, MAX_ENLARGEMENT = 0.4, 2.0
"""Height of the largest face, relative to the tile, up to which the frame is enlarged, and by how much."""
LARGE_FACE_RATIO, MAX_GROUP_RATIO = 0.6, 0.9
"""Faces of this height, relative to the largest one, are kept if they take at most this part of the width."""


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
    """Return the part of a picture of height 1 that a tile shows: around the largest faces, else the middle.

    Args:
        aspect: width divided by height of the picture.
        faces: faces in it, the largest first.
    """
    width = min(aspect, TILE_ASPECT)
    if not faces:
        return _placed(aspect, width, (aspect / 2, 0.5))
    largest = faces[0]
    enlargement = FACE_RATIO * width / TILE_ASPECT / largest.height
    width /= min(max(enlargement, 1.0), MAX_ENLARGEMENT)
    group = largest
    for face in faces[1:]:
        joined = group.union(face)
        if face.height >= LARGE_FACE_RATIO * largest.height and joined.width <= MAX_GROUP_RATIO * width:
            group = joined
    return _placed(aspect, width, group.center)


def _placed(aspect: float, width: float, center: tuple[float, float]) -> Box[float]:
    """Return the window of this width nearest to a point that is inside the picture."""
    height = min(width / TILE_ASPECT, 1.0)
    left = min(max(center[0] - width / 2, 0.0), aspect - width)
    top = min(max(center[1] - height / 2, 0.0), 1.0 - height)
    return Box(left, top, left + width, top + height)
