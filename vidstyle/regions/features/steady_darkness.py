"""Steady drawings of faces in films: noise does not move the ink."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.patches import plane_area

MIN_CHANGE_WEIGHT = 0.2
"""Weight of the next frame where nothing moves."""
MOTION_RANGE, MOTION_SIGMA_PX = (0.04, 0.16), 2.0
"""Change of darkness that is noise, and from which it is motion; and standard deviation of the Gaussian that
averages noise before. On a still face of 82 lines with noise of 4 codes."""
MAX_STEP_PX = 1
"""Farthest motion of a window between frames at which a face is still."""


class SteadyDarkness:
    """Averages the darkness of each face over time, where it does not move."""

    def __init__(self) -> None:
        self._before: dict[int, tuple[Rectangle, np.ndarray]] = {}

    def follow(self, features: list[Features]) -> list[Features]:
        """Return the features of the next frame."""
        steady = [self._steady(each) for each in features]
        self._before = {each.face.track: (each.window, each.darkness) for each in steady}
        return steady

    def _steady(self, found: Features) -> Features:
        window, before = found.window, self._before.get(found.face.track)
        if before is None or before[1].shape != (before[0].height, before[0].width):
            return found
        is_still = max(abs(new - old) for new, old in zip(window, before[0], strict=True)) <= MAX_STEP_PX
        if not is_still or found.darkness.shape != (window.height, window.width):
            return found
        darkness = found.darkness.copy()
        # A face that rests is where it was on the page; one that moves, where it was in its window.
        moved = before[0].moved(window.left - before[0].left, window.top - before[0].top)
        parts = [_common(darkness, window, before[1], each) for each in (before[0], moved)]
        here, known = min(parts, key=lambda part: float(np.abs(part[0] - part[1]).mean()))
        change = here - known
        motion = np.abs(cv2.GaussianBlur(change, (0, 0), MOTION_SIGMA_PX))
        here[:] = known + np.maximum(ramp(motion, MOTION_RANGE), np.float32(MIN_CHANGE_WEIGHT)) * change
        return found._replace(darkness=darkness)


def _common(
    plane: np.ndarray, window: Rectangle, other: np.ndarray, place: Rectangle
) -> tuple[np.ndarray, np.ndarray]:
    """Return the common parts of two planes, which lie in `window` and at `place`."""
    box = window.intersection(place)
    first, second = (
        each[plane_area(box.moved(-at.left, -at.top), (1, 1))]
        for each, at in ((plane, window), (other, place))
    )
    return first, second
