"""A key frame and the boxes in it: plain data that selection passes to layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from vidstyle.regions.boxes import Box, Point
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS, Landmarks

if TYPE_CHECKING:
    import numpy as np

Framing = Literal["usual", "wide", "near"]
"""How much of its picture a panel shows: a suitable part, as much as possible, or only the main part."""


@dataclass(frozen=True)
class KeyFrame:
    """A key frame of the film, shown by one panel.

    Attributes:
        time: presentation time of the frame in seconds.
        shape: height and width of the picture, upright, with square pixels and without letterbox bars.
        importance: 0..1, relative to the most important key frame; 0 before key frames are chosen.
        saliency: box around the salient area, in pixels of that picture.
        faces: boxes of the faces, the largest first.
        scene: index of its scene.
        blobs: boxes of small conspicuous objects that no panel edge should cut.
        offset: left and top of the picture in its frame, greater than 0 if the frame has letterbox bars.
        trimmed: empty rows at the top of the picture that are not shown; a part of `offset`.
        framing: whether the panel shows a wide view or a close-up, if key frames look alike.
        landmarks: of those faces for which they are known.
        light: mean luma of the picture, 0..1.
        subject: box of what moves in the picture, if it is known.
    """

    time: float
    shape: tuple[int, int]
    importance: float
    saliency: Box
    faces: tuple[Box, ...]
    scene: int
    blobs: tuple[Box, ...] = ()
    offset: tuple[int, int] = (0, 0)
    trimmed: int = 0
    framing: Framing = "usual"
    landmarks: Mapping[Box, Landmarks] = field(default_factory=dict)
    light: float = 0.5
    subject: Box | None = None

    def mouth(self, face: Box) -> Point:
        """Return the mouth of a face: its detected position, or else its usual one."""
        return self.landmarks.get(face, USUAL_LANDMARKS).mouth(face)

    def picture(self, frame: np.ndarray) -> np.ndarray:
        """Return the picture without letterbox bars from its frame, H x W x 3."""
        left, top = self.offset
        return frame[top : top + self.shape[0], left : left + self.shape[1]]
