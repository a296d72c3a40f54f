"""Measure how steady styles are: flicker in still scenes, changes other than motion, smear."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tools.steadiness.clips import Clip, find_motions, make_moving_disc, make_still_scene, restyle_clip
from tools.steadiness.warping import Motion, warping_error
from vidstyle.style import Style

NOISE_LEVELS = 4
"""Standard deviation of the noise in the still scene, in levels of 255."""
STILL_SCENE_FRAMES, SETTLING_FRAMES = 24, 8
"""Length of the still scene, and the frames at its start that are not measured."""
DISC_SCENE_FRAMES = 16
GHOST_WEIGHT = 0.7
"""Weight of the previous result in a frame with ghosts."""
MAX_QUIET_LEVELS = 2
"""Maximum change of a pixel of a quiet area from frame to frame, in levels of 255."""


@dataclass(frozen=True)
class Steadiness:
    """Measurements of one style at one value of `steady`.

    Attributes:
        still: mean difference between successive frames of the noisy still scene, in levels of 255.
        warping: mean warping error over the clips, for values 0..1; NaN without clips.
        ratio: `warping` divided by the warping error of the source.
        quiet: mean difference between successive frames where the source changes by at most
            `MAX_QUIET_LEVELS`, in levels of 255. Fixed marks have no reason to change there.
        smear: mean difference from the result at steady 0 around the edge of a moving disc, in levels of 255.
        ghost: smear of the result at steady 0 with ghosts, see `add_ghosts`.
    """

    still: float
    warping: float
    ratio: float
    quiet: float
    smear: float
    ghost: float


class Study:
    """Films on which the steadiness of styles is measured; their motion is estimated once.

    Args:
        photograph: H x W x 3 uint8 RGB, the source of the still scene and the moving disc.
        clips: parts of real films.
        device: "cpu" or "gpu".
    """

    def __init__(self, photograph: np.ndarray, clips: Sequence[Clip], device: str = "cpu") -> None:
        self._device = device
        self._still = make_still_scene(photograph, STILL_SCENE_FRAMES, NOISE_LEVELS)
        self._disc, self._edges = make_moving_disc(photograph, DISC_SCENE_FRAMES)
        self._clips = [(clip, find_motions(clip)) for clip in clips]
        self._source_error = mean_warping_error([(clip.frames, motions) for clip, motions in self._clips])

    @property
    def source(self) -> Steadiness:
        """Steadiness of the films without a style."""
        return Steadiness(
            still=measure_flicker(self._still.frames[SETTLING_FRAMES:]),
            warping=self._source_error,
            ratio=1,
            quiet=self._measure_quiet([clip.frames for clip, _ in self._clips]),
            smear=0,
            ghost=self._measure_ghost(self._disc.frames),
        )

    def measure(self, style: Style, steady: Sequence[float]) -> Iterator[Steadiness]:
        """Yield the steadiness of a style at each value of its field `steady`."""
        unsteady = self._restyle(replace(style, steady=0.0), self._disc)
        for each in (replace(style, steady=value) for value in steady):
            films = [self._restyle(each, clip) for clip, _ in self._clips]
            motions = [found for _, found in self._clips]
            error = mean_warping_error(list(zip(films, motions, strict=True)))
            yield Steadiness(
                still=measure_flicker(self._restyle(each, self._still)[SETTLING_FRAMES:]),
                warping=error,
                ratio=error / self._source_error if self._source_error else float("nan"),
                quiet=self._measure_quiet(films),
                smear=mean_difference(self._restyle(each, self._disc), unsteady, self._edges),
                ghost=self._measure_ghost(unsteady),
            )

    def _measure_quiet(self, films: Sequence[Sequence[np.ndarray]]) -> float:
        """Return the mean over the clips of `measure_quiet_flicker`; NaN without clips.

        Args:
            films: the frames of each clip, restyled or not.
        """
        flickers = [
            measure_quiet_flicker(frames, clip.frames)
            for frames, (clip, _) in zip(films, self._clips, strict=True)
        ]
        return float(np.mean(flickers)) if flickers else float("nan")

    def _measure_ghost(self, frames: Sequence[np.ndarray]) -> float:
        return mean_difference(list(add_ghosts(frames)), frames, self._edges)

    def _restyle(self, style: Style, clip: Clip) -> list[np.ndarray]:
        return restyle_clip(style, clip, self._device)


def measure_flicker(frames: Sequence[np.ndarray]) -> float:
    """Return the mean difference between successive frames, H x W x 3 uint8, in levels of 255.

    >>> measure_flicker([np.full((2, 2, 3), level, np.uint8) for level in (10, 13, 12)])
    2.0
    """
    pairs = zip(frames, frames[1:], strict=False)
    return float(np.mean([_levels_between(first, second).mean() for first, second in pairs]))


def measure_quiet_flicker(frames: Sequence[np.ndarray], source: Sequence[np.ndarray]) -> float:
    """Return the mean difference between successive frames in quiet areas of the source, in levels of 255.

    Args:
        frames, source: H x W x 3 uint8 each.

    Returns:
        0 if there are no quiet areas, where the source changes by at most `MAX_QUIET_LEVELS`.

    >>> source = [np.full((2, 2, 3), level, np.uint8) for level in (10, 11, 50)]
    >>> measure_quiet_flicker([3 * frame for frame in source], source)
    3.0
    """
    pairs = zip(source, source[1:], strict=False)
    quiet = [_levels_between(first, second).max(axis=2) <= MAX_QUIET_LEVELS for first, second in pairs]
    triples = [each for each in zip(frames, frames[1:], quiet, strict=False) if each[2].any()]
    differences = [_levels_between(one, other)[where].mean() for one, other, where in triples]
    return float(np.mean(differences)) if differences else 0.0


def add_ghosts(frames: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    """Mix the previous result into each frame, H x W x 3 uint8, with weight `GHOST_WEIGHT`.

    >>> frames = [np.full((2, 2, 3), level, np.uint8) for level in (0, 100)]
    >>> [int(frame[0, 0, 0]) for frame in add_ghosts(frames)]
    [0, 30]
    """
    ghost: np.ndarray = frames[0].astype(np.float32)
    for frame in frames:
        ghost = GHOST_WEIGHT * ghost + np.float32(1 - GHOST_WEIGHT) * frame
        yield np.rint(ghost).astype(np.uint8)


def mean_warping_error(films: Sequence[tuple[Sequence[np.ndarray], Sequence[Motion | None]]]) -> float:
    """Return the mean over films of their mean warping error; NaN without a pair of frames that counts."""
    errors = [_film_error(frames, motions) for frames, motions in films]
    known = [error for error in errors if not np.isnan(error)]
    return float(np.mean(known)) if known else float("nan")


def mean_difference(
    frames: Sequence[np.ndarray], others: Sequence[np.ndarray], where: Sequence[np.ndarray]
) -> float:
    """Return the mean difference of two films in the given pixels of each frame, in levels of 255.

    Args:
        frames, others: H x W x 3 uint8 each.
        where: H x W bool for each frame.
    """
    triples = zip(frames, others, where, strict=True)
    return float(np.mean([_levels_between(one, other)[place].mean() for one, other, place in triples]))


def _film_error(frames: Sequence[np.ndarray], motions: Sequence[Motion | None]) -> float:
    triples = zip(frames, frames[1:], motions, strict=False)
    errors = [warping_error(one, other, motion) for one, other, motion in triples if motion is not None]
    known = [error for error in errors if not np.isnan(error)]
    return float(np.mean(known)) if known else float("nan")


def _levels_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.abs(one.astype(np.int16) - other)
