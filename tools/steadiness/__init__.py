"""How steady styles are on films: what flickers while all is still, changes besides moving, or smears."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tools.steadiness.clips import Clip, motions_of, moving_disc, restyled, still_scene
from tools.steadiness.warping import Motion, warping_error
from vidstyle.style import Style

NOISE = 4
"""Standard deviation of the noise upon the still scene, in levels of 255."""
STILL_FRAMES, SETTLING = 24, 8
"""Frames of the still scene, and how many of them may pass before it counts."""
DISC_FRAMES = 16
GHOST = 0.7
QUIET = 2
"""The most that a pixel of a quiet part of a clip changes from frame to frame, in levels of 255."""


@dataclass(frozen=True)
class Figures:
    """How steady one style is at one value of `steady`.

    Attributes:
        still: mean difference of successive frames of the noisy still scene, in levels of 255.
        warping: mean warping error over the clips, of values 0..1; NaN without clips.
        ratio: that beside the clips' own.
        quiet: mean difference of successive frames where the clips' own is at most `QUIET`, as under a camera
            that pans past a wall: marks that lie still have no reason to change there.
        smear: mean difference from the same film at steady 0 around the edge of what moves, in levels of 255.
        ghost: what the smear were if `GHOST` of the last result were mixed into each where it lies.
    """

    still: float
    warping: float
    ratio: float
    quiet: float
    smear: float
    ghost: float


class Study:
    """The films on which styles are measured; the motion in them is found once.

    Args:
        photograph: H x W x 3 uint8 RGB, of which the still scene and the moving disc are made.
        clips: parts of real films.
    """

    def __init__(self, photograph: np.ndarray, clips: Sequence[Clip], device: str = "cpu") -> None:
        self._device = device
        self._still = still_scene(photograph, STILL_FRAMES, NOISE)
        self._disc, self._edges = moving_disc(photograph, DISC_FRAMES)
        self._clips = [(clip, motions_of(clip)) for clip in clips]
        self._untouched = mean_error([(clip.frames, motions) for clip, motions in self._clips])

    @property
    def untouched(self) -> Figures:
        """The figures of the films themselves."""
        still, clips = flicker(self._still.frames[SETTLING:]), [clip.frames for clip, _ in self._clips]
        return Figures(still, self._untouched, 1, self._quiet(clips), 0, self._ghost(self._disc.frames))

    def measure(self, style: Style, steady: Sequence[float]) -> Iterator[Figures]:
        """The figures of a style at each of the values of its field `steady`."""
        loose = self._restyled(replace(style, steady=0.0), self._disc)
        for each in (replace(style, steady=value) for value in steady):
            films = [self._restyled(each, clip) for clip, _ in self._clips]
            motions = [found for _, found in self._clips]
            error = mean_error(list(zip(films, motions, strict=True)))
            yield Figures(
                flicker(self._restyled(each, self._still)[SETTLING:]),
                error,
                error / self._untouched if self._untouched else float("nan"),
                self._quiet(films),
                difference(self._restyled(each, self._disc), loose, self._edges),
                self._ghost(loose),
            )

    def _quiet(self, films: Sequence[Sequence[np.ndarray]]) -> float:
        """The mean over clips of `quiet_flicker` of their restyled frames."""
        found = [
            quiet_flicker(frames, clip.frames) for frames, (clip, _) in zip(films, self._clips, strict=True)
        ]
        return float(np.mean(found)) if found else float("nan")

    def _ghost(self, frames: Sequence[np.ndarray]) -> float:
        return difference(list(ghosts(frames)), frames, self._edges)

    def _restyled(self, style: Style, clip: Clip) -> list[np.ndarray]:
        return restyled(style, clip, self._device)


def flicker(frames: Sequence[np.ndarray]) -> float:
    """The mean difference of successive frames, H x W x 3 uint8, in levels of 255.

    >>> flicker([np.full((2, 2, 3), level, np.uint8) for level in (10, 13, 12)])
    2.0
    """
    pairs = zip(frames, frames[1:], strict=False)
    return float(np.mean([_levels_between(first, second).mean() for first, second in pairs]))


def quiet_flicker(frames: Sequence[np.ndarray], source: Sequence[np.ndarray]) -> float:
    """The mean difference of successive frames, in levels of 255, where the source's is at most `QUIET`.

    Args:
        frames, source: H x W x 3 uint8 each.

    >>> source = [np.full((2, 2, 3), level, np.uint8) for level in (10, 11, 50)]
    >>> quiet_flicker([3 * frame for frame in source], source)
    3.0
    """
    pairs = zip(source, source[1:], strict=False)
    quiet = [_levels_between(first, second).max(axis=2) <= QUIET for first, second in pairs]
    triples = [each for each in zip(frames, frames[1:], quiet, strict=False) if each[2].any()]
    found = [_levels_between(one, other)[where].mean() for one, other, where in triples]
    return float(np.mean(found)) if found else 0.0


def ghosts(frames: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    """Frames, H x W x 3 uint8, into each of which `GHOST` of the last result is mixed.

    >>> [int(frame[0, 0, 0]) for frame in ghosts([np.full((2, 2, 3), level, np.uint8) for level in (0, 100)])]
    [0, 30]
    """
    ghost: np.ndarray = frames[0].astype(np.float32)
    for frame in frames:
        ghost = GHOST * ghost + np.float32(1 - GHOST) * frame
        yield np.rint(ghost).astype(np.uint8)


def mean_error(films: Sequence[tuple[Sequence[np.ndarray], Sequence[Motion | None]]]) -> float:
    """The mean over films of the mean warping error over their pairs of frames; NaN where there is none."""
    errors = [_film_error(frames, motions) for frames, motions in films]
    known = [error for error in errors if not np.isnan(error)]
    return float(np.mean(known)) if known else float("nan")


def difference(
    frames: Sequence[np.ndarray], others: Sequence[np.ndarray], where: Sequence[np.ndarray]
) -> float:
    """The mean difference of two films in the given pixels of each frame, H x W bool, in levels of 255."""
    triples = zip(frames, others, where, strict=True)
    return float(np.mean([_levels_between(one, other)[place].mean() for one, other, place in triples]))


def _film_error(frames: Sequence[np.ndarray], motions: Sequence[Motion | None]) -> float:
    triples = zip(frames, frames[1:], motions, strict=False)
    errors = [warping_error(one, other, motion) for one, other, motion in triples if motion is not None]
    known = [error for error in errors if not np.isnan(error)]
    return float(np.mean(known)) if known else float("nan")


def _levels_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.abs(one.astype(np.int16) - other)
