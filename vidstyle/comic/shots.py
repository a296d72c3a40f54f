"""Where the shots of a film begin and end: cuts, dissolves and fades."""

from __future__ import annotations

from collections import deque

import cv2
import numpy as np

from vidstyle.cuts import CutDetector

STEP = 1 / 12
"""Seconds between the pictures that are looked at for dissolves."""

FRAME = 1 / 24
"""Seconds; in them movement is measured."""

_SPANS = (3, 6, 12)
"""Steps to either side: a dissolve is seen with the span that reaches from one shot well into the other."""
_SIZE = (32, 18)
_ALIKE = 0.6
"""Pictures that correlate better are of one shot, between which nothing dissolves."""
_UNLIKE = 0.06
"""The root mean square by which two shots differ at least, 0..1."""
_MIXED = 0.3
"""A picture is a mixture of two if no more of their difference is left beside it."""
_SHARE = (0.12, 0.88)
_LEAST = 3
"""Steps that a dissolve takes at least: less may be a picture or two of movement."""
_PAUSE = 0.5
"""Seconds between the middle of a dissolve and a cut within which they are one."""
_TONES = 0.55
"""Key frames of one scene have more of their tones in common, though all in them may have moved."""


class ShotFinder:
    """Is shown every frame of a film, and says at the end where its shots begin.

    Attributes:
        mixtures: first and last time, in seconds, of each dissolve and fade found so far.
    """

    def __init__(self) -> None:
        self._cuts = CutDetector()
        self._begins: list[float] = []
        self._recent: deque[tuple[float, np.ndarray]] = deque(maxlen=2 * _SPANS[-1] + 1)
        self._mixed: list[float] = []
        self._last: tuple[float, np.ndarray] | None = None
        self.mixtures: list[tuple[float, float]] = []

    def push(self, time: float, luma: np.ndarray) -> float:
        """The next frame: seconds, and a small copy of its luma, H x W float32, 0..1.

        Returns:
            How much has moved since the frame before, in the time of a film's usual frame: the mean change,
            in standard deviations of the picture; 0 for the first frame of a shot.
        """
        cut, before, self._last = self._cuts.is_cut(luma), self._last, (time, luma)
        if cut:
            self._begins.append(time)
            self._end_mixture()
        if not self._recent or time - self._recent[-1][0] >= STEP - 1e-3:
            small = cv2.resize(luma, _SIZE, interpolation=cv2.INTER_AREA)
            self._recent.append((time, small))
            self._look()
        if cut or before is None or before[1].shape != luma.shape:
            return 0.0
        change = float(np.abs(luma - before[1]).mean()) / max(float(luma.std()), 0.02)
        return change * FRAME / max(time - before[0], 1e-3)

    def shots(self) -> list[float]:
        """When each shot begins, in seconds; a dissolve or fade ends one in its middle."""
        self._end_mixture()
        middles = ((first + last) / 2 for first, last in self.mixtures)
        alone = [each for each in middles if all(abs(each - cut) > _PAUSE for cut in self._begins)]
        return sorted([*self._begins, *alone])

    def is_mixed(self, time: float) -> bool:
        """Whether the picture at a time shows two shots, or one that fades."""
        return any(first <= time <= last for first, last in self.mixtures)

    def _look(self) -> None:
        """Whether the picture in the middle of the recent ones is a mixture."""
        middle = len(self._recent) - 1 - _SPANS[-1]
        if middle < 0:
            return
        time, picture = self._recent[middle]
        for span in _SPANS:
            if middle >= span and self._is_mixture(
                self._recent[middle - span][1], picture, self._recent[middle + span][1]
            ):
                self._mixed.append(time)
                return
        if self._mixed and time - self._mixed[-1] > 3 * STEP:
            self._end_mixture()

    @staticmethod
    def _is_mixture(before: np.ndarray, picture: np.ndarray, after: np.ndarray) -> bool:
        change = after - before
        strength = float(np.sqrt(np.mean(change**2)))
        if strength < _UNLIKE or _likeness(before, after) > _ALIKE:
            return False
        share = float(np.mean((picture - before) * change)) / strength**2
        if not _SHARE[0] < share < _SHARE[1]:
            return False
        rest = picture - before - share * change
        return float(np.sqrt(np.mean(rest**2))) < _MIXED * strength

    def _end_mixture(self) -> None:
        if len(self._mixed) >= _LEAST:
            self.mixtures.append((self._mixed[0] - STEP, self._mixed[-1] + STEP))
        self._mixed = []


def _likeness(one: np.ndarray, other: np.ndarray) -> float:
    """The correlation of two pictures; 0 where one is blank."""
    one, other = one - one.mean(), other - other.mean()
    energy = float(np.sqrt(np.mean(one**2) * np.mean(other**2)))
    return float(np.mean(one * other)) / energy if energy > 1e-4 else 0.0


class KeyShots:
    """Is shown the key frames of a film, seconds apart, and says where scenes begin, as well as that allows.

    Attributes:
        begins: seconds.
    """

    def __init__(self) -> None:
        self._cuts = CutDetector()
        self._tones: np.ndarray | None = None
        self.begins: list[float] = []

    def push(self, time: float, luma: np.ndarray, tones: np.ndarray) -> None:
        """The next key frame: its small luma, as for `ShotFinder`, and the shares of its tones."""
        moved = self._cuts.is_cut(luma)
        before, self._tones = self._tones, tones
        if before is None or (moved and float(np.minimum(before, tones).sum()) < _TONES):
            self.begins.append(time)
