"""Faces of still pictures, found once and used at every size and in every style."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.regions.automatic_detail import face_detail
from vidstyle.regions.face_tracks import MIN_PICTURE_SIDE_PX, Face, find_boxes
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.landmarks import MarkedFaces

MIN_FACE_PX = 8.0
"""Faces of fewer lines have no features that finer detail could show."""
MAX_KEPT_PICTURES = 512


@dataclass(frozen=True)
class KnownFaces:
    """Faces that have been found; implements `FaceSource`.

    Attributes:
        boxes: faces in a picture of height 1, the largest first.
        detail: see `FaceSource`.
    """

    boxes: MarkedFaces = field(default_factory=dict)
    detail: float = 1.0

    def follow(self, picture: Picture, time: float | None) -> tuple[Face, ...]:
        """Return the faces in a copy of the picture of any size."""
        height = picture.shape[0]
        faces = (
            Face(number, box.scaled(height), 1.0, marks)
            for number, (box, marks) in enumerate(self.boxes.items())
        )
        return tuple(face for face in faces if face.box.height >= MIN_FACE_PX)

    def close(self) -> None:
        """Do nothing."""


NO_FACES = KnownFaces()


class StillFaces:
    """Remembers the faces of pictures by keys, such as frame numbers.

    It implements `FaceSource` for copies of the picture that is shown.
    """

    def __init__(self) -> None:
        self._finder = FaceFinder()
        self._known: OrderedDict[Hashable, KnownFaces] = OrderedDict()
        self._shown = KnownFaces()

    def find(self, key: Hashable, picture: Callable[[], np.ndarray]) -> KnownFaces:
        """Return the faces of a picture; search it only if they are not known.

        Args:
            picture: returns the picture at its full size, H x W x 3 uint8.
        """
        if key not in self._known:
            self._known[key] = self._search(picture()) if self._finder.has_model else KnownFaces()
            while len(self._known) > MAX_KEPT_PICTURES:
                self._known.popitem(last=False)
        return self._known[key]

    @property
    def detail(self) -> float:
        """See `FaceSource`."""
        return self._shown.detail

    def show(self, key: Hashable) -> bool:
        """Use the faces of this picture from now on, none if they are not known; return whether they are."""
        self._shown = self._known.get(key, KnownFaces())
        return key in self._known

    def follow(self, picture: Picture, time: float | None) -> tuple[Face, ...]:
        """Return the faces in a copy of the shown picture of any size."""
        return self._shown.follow(picture, time)

    def close(self) -> None:
        """Do nothing."""

    def _search(self, color: np.ndarray) -> KnownFaces:
        height = color.shape[0]
        if min(color.shape[:2]) < MIN_PICTURE_SIDE_PX:
            return KnownFaces()
        boxes = find_boxes(self._finder, Picture.from_array(color), searches_crowds=True)
        known = {box.scaled(1 / height): marks for box, marks in boxes.items()}
        return KnownFaces(known, face_detail(boxes, min(color.shape[:2])))
