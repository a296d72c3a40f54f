"""Finds the scenes of a film, with a picture of each."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import small_luma
from vidstyle.core.scene_cuts import SceneCutDetector
from vidstyle.errors import InputError, UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader


@dataclass(frozen=True)
class Scene:
    """A scene of a film.

    Attributes:
        start, end: in seconds.
        still: a frame from its second half, or its only one: H x W x 3 uint8.
    """

    start: Fraction
    end: Fraction
    still: np.ndarray


def find_scenes(
    source: str | Path,
    read: ReadOptions | None = None,
    pictures: bool = True,
) -> tuple[list[Scene], Fraction | None]:
    """Read a film once, and return its scenes and its rate in frames per second, if it is constant.

    Args:
        source: a film; it is read again later, so it must be a file.
        pictures: whether stills are needed; otherwise they are empty.

    Raises:
        UsageError: the source is a pipe.
        InputError: it cannot be read, or has no frames.
    """
    if str(source) == "-":
        raise UsageError(
            "standard input", "cannot be read twice, as scenes need", "name a file, or use --by 30s"
        )
    detector, found = SceneCutDetector(), list[_OpenScene]()
    with open_reader(source, read or ReadOptions()) as reader:
        for frame in (item for item in reader if isinstance(item, Frame)):
            if detector.is_cut(small_luma(frame.picture)) or not found:
                found.append(_OpenScene(frame.time))
            found[-1].add(frame, pictures)
        rate = reader.info.rate
    if not found:
        raise InputError(source, "has no frames")
    return [each.scene() for each in found], rate


class _OpenScene:
    """A scene that is being read."""

    def __init__(self, start: Fraction) -> None:
        self._start = self._end = start
        self._count = 0
        self._picture: Picture | None = None

    def add(self, frame: Frame, pictures: bool) -> None:
        """Add its next frame."""
        self._count += 1
        self._end = frame.time + (frame.duration or 0) * frame.time_base
        # The last power of two is in the second half, for every length of a scene.
        if pictures and self._count & (self._count - 1) == 0:
            self._picture = frame.picture

    def scene(self) -> Scene:
        """Return the scene, which has ended."""
        still = np.empty((0, 0, 3), np.uint8) if self._picture is None else to_rgb(self._picture)
        return Scene(self._start, self._end, still)
