"""Shot detection: hard cuts, dissolves and fades."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.comic.analyze.dissolve import DISSOLVE_SIZE_PX, dissolve_share, is_camera_move
from vidstyle.core.scene_cuts import SceneCutDetector

# Dissolves and fades.
DISSOLVE_STEP_SECONDS = 0.075
"""Interval of the pictures in which dissolves are detected."""
_DISSOLVE_SPAN_STEPS = (3, 6, 12)
"""Steps to either side: a dissolve is seen with the span that reaches from one shot well into the next."""
_MIN_DISSOLVE_STEPS = 3
"""Minimum length of a dissolve in steps; anything shorter may be one or two pictures of movement."""
_MIN_SHARE_RISE = 0.06
"""Minimum growth of the second shot's share during a dissolve; in other motion it stays the same."""
_MAX_DISSOLVE_SECONDS = 2.0
"""Maximum length of a dissolve."""
_TRANSITION_TOLERANCE_SECONDS = 0.2
"""Time before and after a dissolve in which a frame may still show a trace of the other shot."""

# Cuts and motion.
MOTION_FRAME_SECONDS = 1 / 24
"""Motion is measured per frame of this duration."""
_CUT_CONTEXT_FRAMES = 3
"""Number of frames before and after a cut whose motion is compared with the cut."""
_STILL_FRAME_SECONDS = 0.1
"""Frames further apart are separate stills, not motion."""
_MIN_CUT_MOTION_RATIO = 1.0
"""A cut changes the picture by more than this multiple of the motion around it."""
_MAX_CUT_DISTANCE_SECONDS = 0.5
"""Maximum time between a cut and the middle of a dissolve that are treated as one."""
_SAME_SCENE_COLOR_SHARE = 0.55
"""Key frames of one scene share more than this part of their colour histogram, even if objects move."""


@dataclass
class _SceneCut:
    """A scene cut, its motion, and the motion of the frames around it."""

    time: float
    moved: float
    before: list[float]
    after: list[float] = field(default_factory=list)

    @property
    def is_whip(self) -> bool:
        """Whether there is as much motion around it: then it is a whip pan."""
        motion = max(
            np.median(moves) if len(moves) == _CUT_CONTEXT_FRAMES else 0.0
            for moves in (self.before, self.after)
        )
        return bool(self.moved < _MIN_CUT_MOTION_RATIO * motion)


class _Mixture(NamedTuple):
    """A frame that may be in a transition.

    Attributes:
        time: in seconds.
        before: the picture shortly before it.
        after: the picture shortly after it.
        shares: of the second shot, for each span; None where it is no mixture.
    """

    time: float
    before: np.ndarray
    after: np.ndarray
    shares: list[float | None]


def _largest_rise(run: Sequence[_Mixture]) -> float:
    """Return by how much the second shot's share grows within a run, by the span that tells most."""
    spans = zip(*(each.shares for each in run), strict=True)
    known = ([share for share in shares if share is not None] for shares in spans)
    return max(
        (later - earlier for shares in known for earlier, later in combinations(shares, 2)), default=0.0
    )


class ShotFinder:
    """Finds where the shots of a film begin; takes every frame.

    Attributes:
        transitions: first and last time, in seconds, of each dissolve and fade found so far.
    """

    def __init__(self) -> None:
        self._cuts = SceneCutDetector()
        self._found: list[_SceneCut] = []
        self._moves: deque[float] = deque(maxlen=_CUT_CONTEXT_FRAMES)
        self._recent: deque[tuple[float, np.ndarray]] = deque(maxlen=2 * _DISSOLVE_SPAN_STEPS[-1] + 1)
        self._run: list[_Mixture] = []
        self._last: tuple[float, np.ndarray] | None = None
        self._motion = 0.0
        self.transitions: list[tuple[float, float]] = []

    def push(self, time: float, luma: np.ndarray) -> float:
        """Add the next frame.

        Args:
            time: in seconds.
            luma: a small copy of the frame's luma, H x W float32, 0..1.

        Returns:
            The motion since the previous frame, scaled to the duration of a usual frame: the mean change in
            standard deviations of the picture. It is the motion of the previous frame if that is larger,
            because some frames come twice in films with a raised frame rate. 0 for the first frame of a shot.
        """
        cut, before, self._last = self._cuts.is_cut(luma), self._last, (time, luma)
        if not self._recent or time - self._recent[-1][0] >= DISSOLVE_STEP_SECONDS - 1e-3:
            small = cv2.resize(luma, DISSOLVE_SIZE_PX, interpolation=cv2.INTER_AREA)
            # Without its mean, as a change of light is no dissolve.
            self._recent.append((time, small - small.mean()))
            self._check_transition(len(self._recent) - 1 - _DISSOLVE_SPAN_STEPS[-1])
        moved = self._measure_motion(before, time, luma)
        moves = before is not None and time - before[0] < _STILL_FRAME_SECONDS
        if self._found and len(self._found[-1].after) < _CUT_CONTEXT_FRAMES:
            self._found[-1].after.append(moved if moves else 0.0)
        if cut:
            self._found.append(_SceneCut(time, moved if moves else math.inf, list(self._moves)))
        self._moves.append(moved if moves else 0.0)
        before_that, self._motion = self._motion, 0.0 if cut else moved
        return max(self._motion, 0.0 if cut else before_that)

    @staticmethod
    def _measure_motion(before: tuple[float, np.ndarray] | None, time: float, luma: np.ndarray) -> float:
        if before is None or before[1].shape != luma.shape:
            return 0.0
        change = float(np.abs(luma - before[1]).mean()) / max(float(luma.std()), 0.02)
        return change * MOTION_FRAME_SECONDS / max(time - before[0], 1e-3)

    def begins_at(self, time: float) -> bool:
        """Whether the frame of this time, the last one, begins a shot."""
        return bool(self._found) and self._found[-1].time == time

    def shots(self) -> list[float]:
        """Return the start time of each shot in seconds; a dissolve or fade ends a shot in its middle."""
        self._check_rest()
        middles = ((first + last) / 2 for first, last in self.transitions)
        cuts = [cut.time for number, cut in enumerate(self._found) if number == 0 or not cut.is_whip]
        separate = [
            time for time in middles if all(abs(time - cut) > _MAX_CUT_DISTANCE_SECONDS for cut in cuts[1:])
        ]
        return sorted([*cuts, *separate])

    def is_transition(self, time: float) -> bool:
        """Whether a time is in a dissolve or fade, or close to it."""
        return is_in_transition(time, self.transitions)

    def _check_transition(self, middle: int) -> None:
        """Check whether the recent picture with this index is in a transition."""
        if middle < 0:
            return
        time, picture = self._recent[middle]
        shares = [
            dissolve_share(self._recent[middle - span][1], picture, self._recent[middle + span][1])
            if span <= middle < len(self._recent) - span
            else None
            for span in _DISSOLVE_SPAN_STEPS
        ]
        if any(share is not None for share in shares):
            near = _DISSOLVE_SPAN_STEPS[0]
            before, after = (self._recent[number][1] for number in (middle - near, middle + near))
            self._run.append(_Mixture(time, before, after, shares))
        elif self._run and time - self._run[-1].time > 3 * DISSOLVE_STEP_SECONDS:
            self._end_transition()

    def _check_rest(self) -> None:
        """Check the pictures that still wait for later ones."""
        for middle in range(max(0, len(self._recent) - _DISSOLVE_SPAN_STEPS[-1]), len(self._recent)):
            self._check_transition(middle)
        self._end_transition()
        self._recent.clear()

    def _end_transition(self) -> None:
        if len(self._run) >= _MIN_DISSOLVE_STEPS and _largest_rise(self._run) >= _MIN_SHARE_RISE:
            first, last = self._run[0], self._run[-1]
            if last.time - first.time < _MAX_DISSOLVE_SECONDS and not is_camera_move(
                first.before, last.after
            ):
                span = first.time - DISSOLVE_STEP_SECONDS, last.time + DISSOLVE_STEP_SECONDS
                self.transitions.append(span)
        self._run = []


class KeyShots:
    """Estimates where scenes begin from the key frames of a film, which are seconds apart.

    Attributes:
        scene_starts: seconds.
    """

    def __init__(self) -> None:
        self._cuts = SceneCutDetector()
        self._histogram: np.ndarray | None = None
        self.scene_starts: list[float] = []

    def push(self, time: float, luma: np.ndarray, histogram: np.ndarray) -> None:
        """Add the next key frame: its small luma, as for `ShotFinder`, and its colour histogram."""
        moved = self._cuts.is_cut(luma)
        before, self._histogram = self._histogram, histogram
        if before is None or (moved and float(np.minimum(before, histogram).sum()) < _SAME_SCENE_COLOR_SHARE):
            self.scene_starts.append(time)


def is_in_transition(time: float, transitions: Sequence[tuple[float, float]]) -> bool:
    """Whether a time is in one of the transitions, see `ShotFinder`, or close to it."""
    margin = _TRANSITION_TOLERANCE_SECONDS
    return any(first - margin <= time <= last + margin for first, last in transitions)
