"""Pictures and styles for the tests of focus."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pictures import FACE

from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.feature_lifting import Features, lift_features
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.patches import Patch
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.renderer import restyle_array
from vidstyle.style import Style

PLACE = FACE.moved(250, 150)
"""Position of the face in `picture_with_face`."""
WINDOW = Box(280, 140, 390, 260)
"""A window around this face."""
EYES = np.s_[48:60, 40:64]
"""The eyes in the window."""


def without(style: Style) -> Style:
    return replace(style, focus=0.0)


def focused_on(faces: list[Box[float]], picture: np.ndarray, style: Style) -> np.ndarray:
    """Return a picture restyled with focus on these faces."""
    known = KnownFaces({each.scaled(1 / picture.shape[0]): USUAL_LANDMARKS for each in faces})
    with FocusRenderer(style, lambda style, _: CpuRenderer(style), known) as renderer:
        return restyle_array(renderer, picture).astype(int)


def below_white(picture: Picture) -> Picture:
    """Return a picture that is white below the face, which changes percentiles around it."""
    assert picture.color is not None
    color = picture.color.copy()
    color[int(PLACE.bottom) + 6 :] = 255
    return Picture.from_array(color)


def planes(picture: Picture) -> list[np.ndarray]:
    found: list[np.ndarray] = []
    picture.map_planes(lambda plane, kind: (found.append(plane), plane)[1] if kind != "alpha" else plane)
    return found


def lifted(picture: Picture, amount: float = 1.0) -> tuple[np.ndarray, list[Features]]:
    """Return the luma of `WINDOW` without the features of the face, and these."""
    copied = picture.map_planes(lambda plane, _: plane.copy())
    faces = lift_features(copied, [Patch(WINDOW, WINDOW, Face(0, PLACE))], amount)
    return luma_in(copied, WINDOW), [each.features() for each in faces]
