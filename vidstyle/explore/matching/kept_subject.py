"""Tells whether a rendering of a photograph keeps its subject and its faces."""

from __future__ import annotations

import numpy as np

from vidstyle.explore.crops.crop_measures import ComparedCrop
from vidstyle.explore.crops.full_size import comparable_faces
from vidstyle.explore.gates import BLURRED_FAULT, FULL_SIZE_GATES, NO_SUBJECT_FAULT, faults
from vidstyle.explore.measure import Original
from vidstyle.regions.still_faces import StillFaces

LOST_SUBJECT_FAULTS = frozenset({BLURRED_FAULT, NO_SUBJECT_FAULT})
"""Faults of variations that are not offered, however near: the distance does not depend on the subject."""
KEPT_FACE_SHARE = 0.9
"""Share of the likeness of faces in the nearest known style that variations must keep."""
MAX_FACE_LIMIT = next(gate.low for gate in FULL_SIZE_GATES if gate.measure == "face")
"""Likeness from which a face is not lost, even if the known style keeps more."""


class KeptSubject:
    """The subject and the faces of a photograph, H x W x 3 uint8, as a known rendering keeps them.

    Args:
        known: the photograph in the nearest known style: a medium that shows small faces as blots may do so.
    """

    def __init__(self, photograph: np.ndarray, known: np.ndarray) -> None:
        self._original = Original(photograph)
        faces = comparable_faces(StillFaces().find("", lambda: photograph), photograph.shape[0])
        self._faces = ComparedCrop(photograph, list(faces))
        self._face_limit = min(MAX_FACE_LIMIT, KEPT_FACE_SHARE * self._faces.face_likeness(known))

    def is_lost(self, rendering: np.ndarray) -> bool:
        """Whether the subject or a face of the photograph is lost in a rendering of it."""
        if LOST_SUBJECT_FAULTS.intersection(faults(self._original.measure(rendering))):
            return True
        return self._faces.face_likeness(rendering) < self._face_limit
