"""Shot detection: hard cuts, dissolves and fades."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import cv2
import numpy as np

from vidstyle.core.scene_cuts import SceneCutDetector

STEP = 0.075
"""Seconds between the pictures that are looked at for dissolves."""

FRAME = 1 / 24
"""Seconds; in them movement is measured."""

_SPANS = (3, 6, 12)
"""Steps to either side: a dissolve is seen with the span that reaches from one shot well into the other."""
_SIZE = (32, 18)
_MIN_STEPS = 3
"""Steps that a dissolve takes at least: less may be a picture or two of movement."""
_MAX_SECONDS = 2.0
"""Seconds that a dissolve takes at most."""
_NEAR = 3
"""Frames to either side of a cut."""
_STILL = 0.1
"""Seconds between frames, above which they are single pictures rather than a film that moves."""
_PEAK = 1.0
"""A cut changes the picture by more than this multiple of the motion beside it."""
_PAUSE = 0.5
"""Seconds between the middle of a dissolve and a cut within which they are one."""
_SAME_SCENE = 0.55
"""Key frames of one scene have more of their colour histogram in common, whatever has moved."""
_SIMILAR = 0.6
"""Pictures with a higher correlation belong to one shot."""
_DIFFERENT = 0.05
"""Minimum root mean square difference of two shots, 0..1."""
_MIXED = 0.4
"""A picture is a blend of two others if no larger share of their difference remains."""
_SHARE = (0.12, 0.88)
"""Range of the second picture's share in a blend."""
_FOUND = 0.75
"""Correlation above which template matching finds a part of a picture again."""


@dataclass
class _SceneCut:
    """A scene cut, and the motion in it and in the frames beside it."""

    time: float
    moved: float
    before: list[float]
    after: list[float] = field(default_factory=list)

    @property
    def is_whip(self) -> bool:
        """Whether there is as much motion beside it: a whip pan."""
        beside = max(np.median(moves) if len(moves) == _NEAR else 0.0 for moves in (self.before, self.after))
        return bool(self.moved < _PEAK * beside)


_Transition = tuple[float, np.ndarray, np.ndarray]
"""The time of a frame in a transition, and the frames shortly before and after."""


class ShotFinder:
    """Finds where the shots of a film begin; every frame is pushed.

    Attributes:
        transitions: first and last time, in seconds, of each dissolve and fade found so far.
    """

    def __init__(self) -> None:
        self._cuts = SceneCutDetector()
        self._found: list[_SceneCut] = []
        self._moves: deque[float] = deque(maxlen=_NEAR)
        self._recent: deque[tuple[float, np.ndarray]] = deque(maxlen=2 * _SPANS[-1] + 1)
        self._run: list[_Transition] = []
        self._last: tuple[float, np.ndarray] | None = None
        self._motion = 0.0
        self.transitions: list[tuple[float, float]] = []

    def push(self, time: float, luma: np.ndarray) -> float:
        """The next frame: seconds, and a small copy of its luma, H x W float32, 0..1.

        Returns:
            How much has moved since the frame before, in the time of a film's usual frame: the mean change,
            in standard deviations of the picture, or since the one before that if it was more, for in films
            whose rate was raised some frames come twice; 0 for the first frame of a shot.
        """
        cut, before, self._last = self._cuts.is_cut(luma), self._last, (time, luma)
        if cut:
            self._end_shot()
        if not self._recent or time - self._recent[-1][0] >= STEP - 1e-3:
            small = cv2.resize(luma, _SIZE, interpolation=cv2.INTER_AREA)
            # Without its mean: light that changes is no dissolve.
            self._recent.append((time, small - small.mean()))
            self._look(len(self._recent) - 1 - _SPANS[-1])
        moved = self._moved(before, time, luma)
        moves = before is not None and time - before[0] < _STILL
        if self._found and len(self._found[-1].after) < _NEAR:
            self._found[-1].after.append(moved if moves else 0.0)
        if cut:
            self._found.append(_SceneCut(time, moved if moves else math.inf, list(self._moves)))
        self._moves.append(moved if moves else 0.0)
        before_that, self._motion = self._motion, 0.0 if cut else moved
        return max(self._motion, 0.0 if cut else before_that)

    @staticmethod
    def _moved(before: tuple[float, np.ndarray] | None, time: float, luma: np.ndarray) -> float:
        if before is None or before[1].shape != luma.shape:
            return 0.0
        change = float(np.abs(luma - before[1]).mean()) / max(float(luma.std()), 0.02)
        return change * FRAME / max(time - before[0], 1e-3)

    def shots(self) -> list[float]:
        """When each shot begins, in seconds; a dissolve or fade ends one in its middle."""
        self._end_shot()
        middles = ((first + last) / 2 for first, last in self.transitions)
        cuts = [cut.time for number, cut in enumerate(self._found) if number == 0 or not cut.is_whip]
        alone = [each for each in middles if all(abs(each - cut) > _PAUSE for cut in cuts[1:])]
        return sorted([*cuts, *alone])

    def is_transition(self, time: float) -> bool:
        """Whether a time lies in a dissolve or a fade."""
        return any(first <= time <= last for first, last in self.transitions)

    def _look(self, middle: int) -> None:
        """Check whether the recent picture of this number lies in a transition."""
        if middle < 0:
            return
        time, picture = self._recent[middle]
        for span in _SPANS:
            if span <= middle < len(self._recent) - span and is_dissolve(
                self._recent[middle - span][1], picture, self._recent[middle + span][1]
            ):
                near = self._recent[middle - _SPANS[0]][1], self._recent[middle + _SPANS[0]][1]
                self._run.append((time, *near))
                return
        if self._run and time - self._run[-1][0] > 3 * STEP:
            self._end_transition()

    def _end_shot(self) -> None:
        """Check the pictures that wait for later ones: no dissolve crosses a cut."""
        for middle in range(max(0, len(self._recent) - _SPANS[-1]), len(self._recent)):
            self._look(middle)
        self._end_transition()
        self._recent.clear()

    def _end_transition(self) -> None:
        if len(self._run) >= _MIN_STEPS:
            (first, before, _), (last, _, after) = self._run[0], self._run[-1]
            if last - first < _MAX_SECONDS and not is_moved(before, after):
                self.transitions.append((first - STEP, last + STEP))
        self._run = []


class KeyShots:
    """Estimates where scenes begin from key frames of a film, which are seconds apart.

    Attributes:
        scene_starts: seconds.
    """

    def __init__(self) -> None:
        self._cuts = SceneCutDetector()
        self._histogram: np.ndarray | None = None
        self.scene_starts: list[float] = []

    def push(self, time: float, luma: np.ndarray, histogram: np.ndarray) -> None:
        """The next key frame: its small luma, as for `ShotFinder`, and its colour histogram."""
        moved = self._cuts.is_cut(luma)
        before, self._histogram = self._histogram, histogram
        if before is None or (moved and float(np.minimum(before, histogram).sum()) < _SAME_SCENE):
            self.scene_starts.append(time)


def is_dissolve(before: np.ndarray, picture: np.ndarray, after: np.ndarray) -> bool:
    """Whether the picture is a blend of the two others, as in a dissolve or a fade; all H x W, mean 0."""
    change = after - before
    strength = float(np.sqrt(np.mean(change**2)))
    if strength < _DIFFERENT or (_correlation(before, after) > _SIMILAR and not _fades(before, after)):
        return False
    share = float(np.mean((picture - before) * change)) / strength**2
    if not _SHARE[0] < share < _SHARE[1]:
        return False
    rest = picture - before - share * change
    return float(np.sqrt(np.mean(rest**2))) < _MIXED * strength


def is_moved(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether the middle of one is found in the other by template matching: a camera move."""
    if _fades(before, after):
        return False
    down, across = before.shape[0] // 4, before.shape[1] // 4
    for one, other in ((before, after), (after, before)):
        middle = np.ascontiguousarray(one[down:-down, across:-across])
        if cv2.matchTemplate(other, middle, cv2.TM_CCOEFF_NORMED).max() > _FOUND:
            return True
    return False


def _fades(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether one picture has much less contrast than the other."""
    lower, higher = sorted((float(before.std()), float(after.std())))
    return lower < 0.6 * higher


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    """The correlation of two pictures of mean 0; 0 where one is blank."""
    energy = float(np.sqrt(np.mean(one**2) * np.mean(other**2)))
    return float(np.mean(one * other)) / energy if energy > 1e-4 else 0.0
