"""Sideways films whose metadata have no rotation: only turned pictures show faces."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vidstyle.regions.faces import LARGE_FACE_HEIGHT_RATIO, FaceFinder, skin_shares

MAX_GLANCES, GLANCE_SIDE_PX = 24, 480
"""Number of pictures of a film that are searched, and their longer side."""
_MIN_GLANCES = 8
"""Number of pictures without a face after which the search ends."""
_MIN_TURNED_FACES, _MIN_TURNED_RATIO = 3, 3
"""Number of pictures with a face once they are turned from which a film is turned; relative to the number as
the film is, as a single one may be an error."""
_MIN_SKIN_SHARE = 0.4
"""Share of a face in a colourful picture that has the colours of skin; drawn balls with faces have 0.13."""
_TURN_DEGREES = 0, 90, 270, 180
"""Clockwise turns that are tried, the most likely one first."""


def find_turn(pictures: Iterable[np.ndarray], faces: FaceFinder) -> int:
    """Return by how many degrees clockwise a film must be turned so that its people are upright.

    It is 0 if few turned pictures show faces, or if the film shows faces as it is.

    Args:
        pictures: of the film, in any order, H x W x 3 uint8.
        faces: finds large faces.
    """
    found = dict.fromkeys(_TURN_DEGREES, 0)
    for number, picture in enumerate(pictures):
        if number == _MIN_GLANCES and not any(found.values()):
            break
        for turn in _TURN_DEGREES:
            turned = np.ascontiguousarray(np.rot90(picture, -turn // 90))
            found[turn] += _shows_person(turned, faces)
    turn = max(_TURN_DEGREES, key=lambda each: found[each])
    return turn if found[turn] >= max(_MIN_TURNED_FACES, _MIN_TURNED_RATIO * found[0] + 1) else 0


def _shows_person(picture: np.ndarray, faces: FaceFinder) -> bool:
    """Whether there is a large face with the colours of skin in a picture, or any in a gray one."""
    found = faces.find(picture, LARGE_FACE_HEIGHT_RATIO)
    return any(share >= _MIN_SKIN_SHARE for share in skin_shares(picture, found))
