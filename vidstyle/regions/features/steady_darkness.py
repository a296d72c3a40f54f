"""Steady drawings of faces in films: noise does not move the ink."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.features.windows import common_parts

MIN_CHANGE_WEIGHT = 0.2
"""Weight of the next frame where nothing moves."""
MOTION_RANGE, MOTION_SIGMA_PX = (0.04, 0.16), 2.0
"""Change of darkness that is noise, and from which it is motion; and standard deviation of the Gaussian that
averages noise before. Tuned on a still face of 82 lines with noise of 4 codes."""
MAX_STEP_PX = 1
"""Farthest motion of a window between two frames at which the face counts as still."""


class SteadyDarkness:
    """Averages the darkness of each face over time, where it does not move.

    A face that is drawn from a reduced copy stays unchanged.
    """

    def __init__(self) -> None:
        self._before: dict[int, Features] = {}

    def follow(self, features: list[Features]) -> list[Features]:
        """Return the features of the next frame."""
        steady = [self._steady(each) for each in features]
        self._before = {each.face.track: each for each in steady if not _is_reduced(each)}
        return steady

    def _steady(self, found: Features) -> Features:
        before = self._before.get(found.face.track)
        if before is None or _is_reduced(found) or not _is_still(before.window, found.window):
            return found
        darkness, window, place = found.darkness.copy(), found.window, before.window
        # A resting face has the same place on the page, and a moving face the same place in its window.
        places = dict.fromkeys((place, place.moved(window.left - place.left, window.top - place.top)))
        parts = [common_parts(darkness, window, before.darkness, each) for each in places]
        here, known = min(parts, key=lambda part: float(np.abs(part[0] - part[1]).mean()))
        change = here - known
        motion = np.abs(cv2.GaussianBlur(change, (0, 0), MOTION_SIGMA_PX))
        here[:] = known + np.maximum(ramp(motion, MOTION_RANGE), np.float32(MIN_CHANGE_WEIGHT)) * change
        return found._replace(darkness=darkness)


def _is_reduced(features: Features) -> bool:
    return features.darkness.shape != (features.window.height, features.window.width)


def _is_still(before: Rectangle, after: Rectangle) -> bool:
    return max(abs(new - old) for new, old in zip(after, before, strict=True)) <= MAX_STEP_PX
