"""Detects scene cuts."""

from __future__ import annotations

import weakref
from collections.abc import Iterable

import cv2
import numpy as np

from vidstyle.core.block_matching import match_blocks
from vidstyle.core.kernels import compiled
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import small_luma

MIN_CUT_SHARE = 0.27
"""At a cut, at least this part of a picture has no match in the one before, 0..1, beyond the usual loss.

Chosen on a trailer of 70 s with 25 cuts, whip pans and gunfire, and on eleven short clips with one cut: cuts
are at 0.30 and above, all else at 0.24 and below.
"""
ACTION_FACTOR = 0.6
"""The part of the average loss that is expected in the next frame; the average is high in fast action."""
MAX_BLANKS = 8
"""Blank pictures in a row after which a scene begins; fewer count as a flash."""

_MAX_SIDE_PX = 96
"""Pixels of a small copy: blocks may move by a tenth of that."""
_MIN_DEVIATION = 0.012
"""A block with a smaller standard deviation shows only noise; 0..1."""
_MIN_BLOCKS = 2
"""A picture with fewer blocks that show something is blank."""
_BAR_LEVEL = 0.1
"""No pixel of a black bar is brighter."""


class SceneCutDetector:
    """Detects for each frame whether it begins a scene; the first one does.

    Block matching by normalized cross-correlation with the picture before, so that motion, fades and flashes
    are no cuts. Blank pictures (black, white, one tone) begin no scene; the picture after them is compared
    with the one before them. Dissolves are not detected.
    """

    def __init__(self) -> None:
        self._shape: tuple[int, ...] | None = None
        self._before: list[np.ndarray] = []
        self._blanks = 0
        self._average_loss = 0.0
        self._last: tuple[weakref.ref[np.ndarray], float, bool] | None = None

    def begins_scene(self, picture: Picture, time: float | None) -> bool:
        """Return whether a frame begins a scene; several renderers of a film may ask for the same frame.

        Args:
            picture: the next frame, or the last one again.
            time: its presentation time in seconds; None: of a picture that stands alone.
        """
        if time is None:
            return self.is_cut(small_luma(picture))
        plane = picture.luma if picture.color is None else picture.color
        assert plane is not None
        if self._last is None or self._last[0]() is not plane or self._last[1] != time:
            self._last = weakref.ref(plane), time, self.is_cut(small_luma(picture))
        return self._last[2]

    def is_cut(self, luma: np.ndarray) -> bool:
        """Return whether the next frame begins a scene; one of another size does.

        Args:
            luma: a small copy of the frame's luma, H x W float32, 0..1.
        """
        first, self._shape = luma.shape != self._shape, luma.shape
        if first:
            self._before, self._blanks, self._average_loss = [], 0, 0.0
        picture = _reduced(luma)
        inside = _inside_letterbox([picture, *self._before])
        # Kernels are compiled separately for contiguous pictures.
        shown, *before = (np.ascontiguousarray(each[inside]) for each in (picture, *self._before))
        count, match = match_blocks(shown, before[0] if before else shown, _MIN_DEVIATION)
        if count < _MIN_BLOCKS:
            self._blanks += 1
            return first
        pause, self._blanks = self._blanks >= MAX_BLANKS, 0
        if pause:
            self._before = []
        cut = bool(self._before) and self._is_new(1 - match, shown, before[1:])
        self._before = [picture, *self._before[:1]]
        return first or pause or cut

    def _is_new(self, lost: float, picture: np.ndarray, before: list[np.ndarray]) -> bool:
        """Whether a picture matches neither the last one nor, if that may be a flash, its previous one.

        Args:
            lost: the part of the picture without a match in the last one, 0..1.
            before: the picture before the last one, if there is one.
        """
        average = self._average_loss
        # Cuts count as well, up to the threshold, so that fast action after a cut is not all cuts.
        self._average_loss += (min(lost, MIN_CUT_SHARE) - average) / 2
        if lost <= MIN_CUT_SHARE + ACTION_FACTOR * average:
            return False
        matches = (match_blocks(picture, each, _MIN_DEVIATION)[1] for each in before)
        return all(1 - match > MIN_CUT_SHARE for match in matches)


class KnownCuts:
    """Scene cuts that were detected before, by the times of the frames that begin scenes, in seconds."""

    def __init__(self, times: Iterable[float]) -> None:
        self._times = set(times)

    def add(self, time: float) -> None:
        """Add a frame that begins a scene."""
        self._times.add(time)

    def begins_scene(self, picture: Picture, time: float | None) -> bool:
        """Return whether the frame of this time begins a scene; see `SceneCutDetector.begins_scene`."""
        return time in self._times


SceneCuts = SceneCutDetector | KnownCuts


def _reduced(luma: np.ndarray) -> np.ndarray:
    """Return a copy of at most `_MAX_SIDE_PX` pixels on a side, averaged, which reduces noise."""
    scale = min(1.0, _MAX_SIDE_PX / max(luma.shape))
    height, width = (max(1, round(side * scale)) for side in luma.shape)
    return np.array(cv2.resize(luma, (width, height), interpolation=cv2.INTER_AREA), np.float32)


def _inside_letterbox(pictures: list[np.ndarray]) -> tuple[slice, slice]:
    """Return the area inside the black bars of all pictures; edges of bars match in every scene."""
    height, width = pictures[0].shape
    rows, columns = np.ones(height, np.float32), np.ones(width, np.float32)
    first, second, third = (*pictures, *pictures, *pictures)[:3]
    _find_brightest(first, second, third, rows, columns)
    return _bright_span(rows), _bright_span(columns)


@compiled
def _find_brightest(first, second, third, rows, columns):  # type: ignore[no-untyped-def]
    """Find the brightest values of each row and column of three pictures."""
    rows[:], columns[:] = 0, 0
    for y in range(rows.size):
        for x in range(columns.size):
            brightest = max(first[y, x], max(second[y, x], third[y, x]))
            rows[y], columns[x] = max(rows[y], brightest), max(columns[x], brightest)


def _bright_span(line: np.ndarray) -> slice:
    """Return the part of a line between dark ends, less a pixel that mixes bar and picture."""
    lit = np.flatnonzero(line > _BAR_LEVEL)
    if len(lit) == 0 or 2 * (lit[-1] + 1 - lit[0]) < len(line):
        return slice(None)
    first, last = lit[0] + (lit[0] > 0), lit[-1] + (lit[-1] + 1 == len(line))
    return slice(first, last) if first < last else slice(None)
