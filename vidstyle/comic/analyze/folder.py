"""A folder of pictures as a film: each is a scene of one second, in the order of their names."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from vidstyle.comic.analyze.faces import FaceFinder
from vidstyle.comic.analyze.features import SIDE, Candidate, judge
from vidstyle.comic.analyze.survey import Survey
from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader
from vidstyle.media.read.samples import sample_all
from vidstyle.media.resize import square_pixels

log = logging.getLogger("vidstyle")

SUFFIXES = frozenset(".avif .bmp .gif .heic .jpeg .jpg .jxl .png .ppm .tif .tiff .webp".split())


class Folder:
    """See `Film`; files whose names do not say that they are pictures are passed over."""

    def __init__(self, path: Path, faces: FaceFinder, options: ReadOptions | None = None) -> None:
        """Look what is there.

        Raises:
            InputError: no pictures.
        """
        self.name = str(path)
        self._faces, self._options = faces, options
        self._paths = sorted(
            (each for each in path.iterdir() if each.suffix.lower() in SUFFIXES and each.is_file()),
            key=lambda each: _natural(each.name),
        )
        if not self._paths:
            raise InputError(path, "a folder without pictures")

    def survey(self) -> Survey:
        """See `Film`."""
        candidates = []
        for number in range(len(self._paths)):
            try:
                candidates.append(self._judged(number))
            except InputError as error:
                log.warning("left out: %s", error)
        if not candidates:
            raise InputError(self.name, "none of its pictures can be read")
        begins = [float(number) for number in range(len(self._paths))]
        return Survey(candidates, begins, float(len(self._paths)), pictures=True)

    def around(self, candidate: Candidate) -> list[Candidate]:
        """See `Film`: there is nothing else."""
        return [candidate]

    def at(self, time: float) -> Candidate:
        """See `Film`."""
        return self._judged(self._number(time))

    def frames_at(self, times: Iterable[float]) -> Iterator[np.ndarray]:
        """See `Film`."""
        for time in times:
            with open_reader(self._paths[self._number(time)], self._options) as reader:
                picture = next(item for item in reader if isinstance(item, Frame)).picture
                yield square_pixels(to_rgb(picture), reader.info.sample_aspect)

    def _judged(self, number: int) -> Candidate:
        sample = next(sample_all(self._paths[number], options=self._options), None)
        if sample is None:
            raise InputError(self._paths[number], "no frame could be decoded")
        return replace(judge(to_rgb(sample.picture(SIDE)), number, sample.shape, self._faces), scene=number)

    def _number(self, time: float) -> int:
        return min(max(0, int(time)), len(self._paths) - 1)


def _natural(name: str) -> list[tuple[int, str]]:
    """So that picture 10 comes after picture 9.

    >>> sorted(["10.png", "9.png"], key=_natural)
    ['9.png', '10.png']
    """
    return [(int(part), "") if part.isdigit() else (-1, part.lower()) for part in re.split(r"([0-9]+)", name)]
