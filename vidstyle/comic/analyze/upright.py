"""Films that lie on their side although their metadata do not report it: only turned pictures show faces."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vidstyle.regions.faces import LARGE_FACE_HEIGHT_RATIO, FaceFinder

MAX_GLANCES, GLANCE_SIDE_PX = 24, 480
"""Number of pictures of a film that are searched, and their longer side."""
_MIN_GLANCES = 8
"""Number of pictures after which the search ends if none of them shows a face."""
_MIN_TURNED_FACES, _MIN_TURNED_RATIO = 3, 3
"""Number of pictures with a face once they are turned from which a film is turned; relative to the number as
the film is, as a single one may be an error."""
_TURN_DEGREES = 0, 90, 270, 180
"""Clockwise turns that are tried, the most likely one first."""


def find_turn(pictures: Iterable[np.ndarray], faces: FaceFinder) -> int:
    """Return by how many degrees clockwise a film must be turned so that its people are upright.

    It is 0 if few turned pictures show faces, or many as the film is.

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
            found[turn] += bool(faces.find(turned, LARGE_FACE_HEIGHT_RATIO))
    turn = max(_TURN_DEGREES, key=lambda each: found[each])
    return turn if found[turn] >= max(_MIN_TURNED_FACES, _MIN_TURNED_RATIO * found[0] + 1) else 0
