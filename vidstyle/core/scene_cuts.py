"""Finds cuts: frames that begin a new scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

LOST = 0.27
"""How much of a picture, 0..1, is not found in the one before at a cut, beyond what is lost anyway.

Chosen on a trailer of 70 s with 25 cuts, whip pans and gunfire, and on eleven short clips with one cut: there
cuts are at 0.30 and above, all else at 0.24 and below, so that each cut is found and nothing besides.
"""
ACTION = 0.6
"""How much of what was lost of late is expected to be lost again: in wild action that is much."""
PAUSE = 8
"""After so many blank pictures in a row a scene begins; fewer are a flash."""

_SIDE = 96
_BLOCK = 16
_REACH = 10
"""Pixels that a block may have moved since the frame before: a tenth of the picture's longer side."""
_FLAT = 0.012
"""A block that deviates less from its mean shows nothing but noise; 0..1."""
_BLANK = 2
"""A picture of which fewer blocks show something is blank."""
_BAR = 0.1
"""No pixel of a black bar is brighter."""

_Block = tuple[int, int, np.ndarray, float]
"""Top, left, pixels and their standard deviation."""


@dataclass(frozen=True)
class Scene:
    """A part of a film between two cuts.

    Attributes:
        start, end: seconds; `end` is the start of the next scene, or the time of the film's last frame.
        frames: how many.
    """

    start: float
    end: float
    frames: int


def find_scenes(frames: Iterable[tuple[float, np.ndarray]]) -> Iterator[Scene]:
    """The scenes of a film, each as soon as it is over.

    Args:
        frames: time in seconds and small luma, as for `SceneCutDetector.is_cut`, of every frame in order.

    >>> still = np.tile(np.linspace(0, 1, 96, dtype=np.float32), (54, 1))
    >>> other = np.ascontiguousarray(still[:, ::-1])
    >>> list(find_scenes((number / 10, still if number < 3 else other) for number in range(5)))
    [Scene(start=0.0, end=0.3, frames=3), Scene(start=0.3, end=0.4, frames=2)]
    """
    detector = SceneCutDetector()
    start, time, count = 0.0, 0.0, 0
    for time, luma in frames:
        if detector.is_cut(luma):
            if count:
                yield Scene(start, time, count)
            start, count = time, 0
        count += 1
    if count:
        yield Scene(start, time, count)


class SceneCutDetector:
    """Says for each frame whether it begins a scene; the first one does.

    Each block of a picture is looked for in the picture before, around its place and at any brightness and
    contrast: what has moved, faded or been lit by a flash is found again, what a cut brings is not. Blank
    pictures (black, white, one tone) begin no scene; what comes after them is compared with what came
    before. Dissolves are not found, for in them each picture is much like the one before.
    """

    def __init__(self) -> None:
        self._shape: tuple[int, ...] | None = None
        self._before: list[np.ndarray] = []
        self._blanks = 0
        self._usual = 0.0

    def is_cut(self, luma: np.ndarray) -> bool:
        """Whether the next frame begins a scene; one of another size does.

        Args:
            luma: a small copy of the frame's luma, H x W float32, 0..1.
        """
        first, self._shape = luma.shape != self._shape, luma.shape
        if first:
            self._before, self._blanks, self._usual = [], 0, 0.0
        picture = _reduced(luma)
        inside = _without_bars([picture, *self._before])
        blocks = list(_blocks(picture[inside]))
        if len(blocks) < _BLANK:
            self._blanks += 1
            return first
        pause, self._blanks = self._blanks >= PAUSE, 0
        if pause:
            self._before = []
        cut = bool(self._before) and self._is_new(blocks, [before[inside] for before in self._before])
        self._before = [picture, *self._before[:1]]
        return first or pause or cut

    def _is_new(self, blocks: list[_Block], before: list[np.ndarray]) -> bool:
        """Whether the blocks are found neither in the last picture nor, if that was a flash, before it."""
        lost, usual = 1 - _found(blocks, before[0]), self._usual
        # Cuts count as well, as far as action may go, so that what is wild from now on is not all cuts.
        self._usual += (min(lost, LOST) - usual) / 2
        return lost > LOST + ACTION * usual and all(1 - _found(blocks, each) > LOST for each in before[1:])


def _reduced(luma: np.ndarray) -> np.ndarray:
    """A copy whose sides are at most `_SIDE`; its pixels are means, which hold little noise."""
    scale = min(1.0, _SIDE / max(luma.shape))
    height, width = (max(1, round(side * scale)) for side in luma.shape)
    return np.array(cv2.resize(luma, (width, height), interpolation=cv2.INTER_AREA), np.float32)


def _without_bars(pictures: list[np.ndarray]) -> tuple[slice, slice]:
    """The rows and columns between black bars that all the pictures have: their edges are in every scene."""
    brightest = np.max(pictures, axis=0)
    return _lit(brightest.max(axis=1)), _lit(brightest.max(axis=0))


def _lit(line: np.ndarray) -> slice:
    """Where a line is not dark at its ends, less a pixel into which bar and picture were mixed."""
    lit = np.flatnonzero(line > _BAR)
    if len(lit) == 0 or 2 * (lit[-1] + 1 - lit[0]) < len(line):
        return slice(None)
    first, last = lit[0], lit[-1] + 1
    return slice(first + (first > 0), last - (last < len(line)))


def _blocks(picture: np.ndarray) -> Iterator[_Block]:
    """The blocks of a picture that show something."""
    tall, wide = (min(_BLOCK, side) for side in picture.shape)
    for top in range(picture.shape[0] % tall // 2, picture.shape[0] - tall + 1, tall):
        for left in range(picture.shape[1] % wide // 2, picture.shape[1] - wide + 1, wide):
            block = picture[top : top + tall, left : left + wide]
            deviation = float(cv2.meanStdDev(block)[1][0, 0])
            if deviation > _FLAT:
                yield top, left, block, deviation


def _found(blocks: list[_Block], before: np.ndarray) -> float:
    """How well the blocks correlate with the picture before where each does so best: their mean, 0..1."""
    tall, wide = blocks[0][2].shape
    wider = np.pad(before, _REACH, mode="edge")
    means, squares = (
        each(wider, cv2.CV_64F, (wide, tall), anchor=(0, 0)) for each in (cv2.boxFilter, cv2.sqrBoxFilter)
    )
    # Not below half of what counts as flat: noise would be taken for whatever is looked for.
    deviations = np.sqrt(np.maximum(squares - means**2, (_FLAT / 2) ** 2))
    likeness = []
    for top, left, block, deviation in blocks:
        place = slice(top, top + 2 * _REACH + 1), slice(left, left + 2 * _REACH + 1)
        around = wider[top : top + tall + 2 * _REACH, left : left + wide + 2 * _REACH]
        products = cv2.matchTemplate(around, block, cv2.TM_CCOEFF) / block.size
        likeness.append(max(0.0, float((products / deviations[place]).max()) / deviation))
    return float(np.mean(likeness))
