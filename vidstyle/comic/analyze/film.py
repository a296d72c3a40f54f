"""A film as the chooser of key frames sees it: small copies of frames, judged, in bounded memory."""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from vidstyle.comic.analyze.faces import FaceFinder
from vidstyle.comic.analyze.features import SIDE, Candidate, judge
from vidstyle.comic.analyze.folder import Folder
from vidstyle.comic.analyze.shots import KeyShots, ShotFinder
from vidstyle.comic.analyze.survey import Film, Survey
from vidstyle.comic.select.choose import usual_panels
from vidstyle.core.convert import to_rgb
from vidstyle.core.measured import small_luma
from vidstyle.errors import InputError, UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader
from vidstyle.media.read.samples import SampledFrame, measure_extent, sample_all, sample_keys
from vidstyle.media.resize import square_pixels

WHOLE = 2 * 10**9
"""Films of no more pixels in all are decoded whole, which takes seconds; of longer ones only key frames."""
SPARE = 2.5
"""Key frames for each panel: with fewer of them a long film has to be decoded whole nevertheless."""
MOST = 3600
"""Candidates that are kept of a film, however long."""

_SHOT_SIDE = 128
"""Pixels of the longer side of the copies in which cuts are looked for."""
_GAP = 1 / 4
"""Seconds between candidates at least."""
_LEAST = 8
"""Candidates of a film that is shorter than that many gaps."""
_EDGE = 0.1
"""Seconds around a cut in which no candidate lies: there compressed pictures are at their worst."""
_REACH, _KEY_REACH = 0.3, 0.8
"""Seconds around a candidate in which a better picture is looked for; more where only keys were seen."""
_CONTEXT = 1.2
"""Seconds beside that in which a cut or a dissolve is noticed."""


def open_film(
    source: str | os.PathLike[str], faces: FaceFinder | None = None, options: ReadOptions | None = None
) -> Film:
    """A film, an animation, numbered pictures ("%05d.png") or a folder of pictures.

    Raises:
        InputError: the folder holds no picture.
        UsageError: it is a pipe, in which one cannot go back.
    """
    if str(source) == "-":
        raise UsageError("-", "a pipe can be read only once", "save the film to a file")
    faces = faces or FaceFinder()
    return Folder(Path(source), faces, options) if Path(source).is_dir() else FilmFile(source, faces, options)


class FilmFile:
    """See `Film`."""

    def __init__(
        self, source: str | os.PathLike[str], faces: FaceFinder, options: ReadOptions | None = None
    ) -> None:
        self.name = str(source)
        self._source, self._faces, self._options = source, faces, options
        self._reach = _REACH

    def survey(self) -> Survey:
        """See `Film`.

        Raises:
            InputError: it cannot be read, or no frame of it can be decoded.
        """
        extent = measure_extent(self._source, self._options)
        seconds = float(extent.seconds)
        gap = max(min(_GAP, seconds / _LEAST), seconds / MOST)
        if extent.frames * extent.pixels > WHOLE:
            found = self._survey_keys(max(gap, 0.5))
            panels = usual_panels(len(found.begins), seconds)
            if len(found.candidates) >= SPARE * panels:
                self._reach = _KEY_REACH
                return found
        return self._survey_whole(gap)

    def around(self, candidate: Candidate) -> list[Candidate]:
        """See `Film`."""
        context = _CONTEXT if self._reach == _KEY_REACH else _EDGE
        shots, judged = ShotFinder(), []
        for sample in self._samples(candidate.time - self._reach - context, self._reach + context, candidate):
            time = float(sample.time)
            motion = shots.push(time, small_luma(sample.picture(_SHOT_SIDE)))
            if abs(time - candidate.time) <= self._reach:
                judged.append(replace(self._judged(sample), motion=motion))
        begins = shots.shots()
        shot = bisect_right(begins, candidate.time)
        return [
            replace(each, scene=candidate.scene, mixed=shots.is_mixed(each.time))
            for each in judged
            if bisect_right(begins, each.time) == shot and _clear(each.time, begins)
        ] or [candidate]

    def at(self, time: float) -> Candidate:
        """See `Film`."""
        start = Fraction(time)
        for sample in sample_all(self._source, start, start + Fraction(1, 1000), self._options):
            return self._judged(sample)
        raise InputError(self.name, f"has no picture at {time:g} s")

    def frames_at(self, times: Iterable[float]) -> Iterator[np.ndarray]:
        """See `Film`."""
        for time in times:
            read = replace(self._options or ReadOptions(), start=Fraction(time) if time > 0 else None)
            with open_reader(self._source, read) as reader:
                frame = next(item for item in reader if isinstance(item, Frame))
                yield square_pixels(to_rgb(frame.picture), reader.info.sample_aspect)

    def _survey_whole(self, gap: float) -> Survey:
        shots, judged, time, last = ShotFinder(), list[Candidate](), 0.0, -gap
        for sample in sample_all(self._source, options=self._options):
            time = float(sample.time)
            motion = shots.push(time, small_luma(sample.picture(_SHOT_SIDE)))
            if time - last >= gap - 1e-3:
                judged.append(replace(self._judged(sample), motion=motion))
                last = time
        begins = shots.shots()
        mixed = [replace(each, mixed=shots.is_mixed(each.time)) for each in judged]
        return Survey(self._in_scenes(mixed, begins), begins, time)

    def _survey_keys(self, gap: float) -> Survey:
        shots, judged, time = KeyShots(), list[Candidate](), 0.0
        for sample in sample_keys(self._source, Fraction(gap), self._options):
            time = float(sample.time)
            judged.append(self._judged(sample))
            shots.push(time, small_luma(sample.picture(_SHOT_SIDE)), judged[-1].tones)
        return Survey(self._in_scenes(judged, shots.begins), shots.begins, time)

    def _in_scenes(self, judged: list[Candidate], begins: list[float]) -> list[Candidate]:
        if not judged:
            raise InputError(self.name, "no frame could be decoded")
        return [replace(each, scene=max(0, bisect_right(begins, each.time) - 1)) for each in judged]

    def _judged(self, sample: SampledFrame) -> Candidate:
        return judge(to_rgb(sample.picture(SIDE)), float(sample.time), sample.shape, self._faces)

    def _samples(self, start: float, after: float, candidate: Candidate) -> Iterator[SampledFrame]:
        begin, end = Fraction(max(0.0, start)), Fraction(candidate.time + after)
        return sample_all(self._source, begin, end, self._options)


def _clear(time: float, begins: list[float]) -> bool:
    return all(abs(time - begin) >= _EDGE for begin in begins[1:])
