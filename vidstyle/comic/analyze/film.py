"""Films and folders of pictures as sources of key frames, analysed in bounded memory."""

from __future__ import annotations

import os
from abc import abstractmethod
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from vidstyle.comic.analyze.faces import FaceFinder
from vidstyle.comic.analyze.features import SIDE, Candidate, Survey, extract_features
from vidstyle.comic.analyze.shots import KeyShots, ShotFinder
from vidstyle.comic.select.choose import default_panels
from vidstyle.core.closing import Closing
from vidstyle.core.convert import to_rgb
from vidstyle.core.measured import small_luma
from vidstyle.errors import InputError, UsageError, log
from vidstyle.media.read.sampler import FilmSampler, SampledFrame
from vidstyle.media.read.sequence import natural_order
from vidstyle.pipeline.progress import OnStep, unwatched

WHOLE = 2 * 10**9
"""Films of no more pixels in all are decoded whole, which takes seconds; of longer ones only key frames."""
SPARE = 2.5
"""Minimum of key frames per panel: with fewer, a long film is decoded whole nevertheless."""
MOST = 3600
"""Maximum of candidates, however long the film."""

KEPT_BYTES = 2**28
"""Full-size frames that are needed twice are held in memory up to this size."""
SUFFIXES = frozenset(".avif .bmp .gif .heic .jpeg .jpg .jxl .png .ppm .tif .tiff .webp".split())
"""Names of files in a folder that are read as pictures."""

_STEP = "looking through the film"
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


class Film(Closing):
    """A source of key frames; a context manager."""

    name: str

    def __init__(self) -> None:
        self._kept: dict[float, np.ndarray] = {}

    @abstractmethod
    def survey(self, on_step: OnStep = unwatched) -> Survey:
        """Analyse the whole film; tells its progress in seconds.

        Raises:
            InputError: it cannot be read, or no frame of it can be decoded.
        """

    @abstractmethod
    def around(self, candidate: Candidate) -> list[Candidate]:
        """The frames near a candidate in the same shot, itself included."""

    @abstractmethod
    def at(self, time: float) -> Candidate:
        """The frame shown at a time in seconds."""

    @abstractmethod
    def _image_at(self, time: float) -> np.ndarray:
        """Decode the frame shown at a time in full size."""

    def frames_at(self, times: Iterable[float], keep: bool = False) -> Iterator[np.ndarray]:
        """The frames shown at these times in full size: H x W x 3 uint8, upright, with square pixels.

        `keep`: hold each in memory, up to `KEPT_BYTES`, until it is requested again.
        """
        for time in times:
            frame = self._kept.pop(time, None)
            if frame is None:
                frame = self._image_at(time)
            if keep and sum(each.nbytes for each in self._kept.values()) + frame.nbytes <= KEPT_BYTES:
                self._kept[time] = frame
            yield frame

    def close(self) -> None:
        """Close the file."""
        self._kept.clear()


class FilmFile(Film):
    """A film, an animation or numbered pictures."""

    def __init__(self, source: str | os.PathLike[str], faces: FaceFinder) -> None:
        super().__init__()
        self.name = str(source)
        self._sampler, self._faces = FilmSampler(source), faces
        self._reach = _REACH

    def close(self) -> None:
        super().close()
        self._sampler.close()

    def survey(self, on_step: OnStep = unwatched) -> Survey:
        seconds = float(self._sampler.seconds)

        def on_time(time: float) -> None:
            on_step(_STEP, time, seconds)

        gap = max(min(_GAP, seconds / _LEAST), seconds / MOST)
        if self._sampler.pixels > WHOLE:
            found = self._survey_keys(max(gap, 0.5), on_time)
            if len(found.candidates) >= SPARE * default_panels(len(found.scene_starts), seconds):
                self._reach = _KEY_REACH
                return found
        return self._survey_whole(gap, on_time)

    def around(self, candidate: Candidate) -> list[Candidate]:
        context = _CONTEXT if self._reach == _KEY_REACH else _EDGE
        shots, candidates = ShotFinder(), []
        start, end = candidate.time - self._reach - context, candidate.time + (self._reach + context)
        for sample in self._sampler.frames(Fraction(max(0.0, start)), Fraction(end)):
            time = float(sample.time)
            motion = shots.push(time, small_luma(sample.picture(_SHOT_SIDE)))
            if abs(time - candidate.time) <= self._reach:
                candidates.append(replace(self._features(sample), motion=motion))
        begins = shots.shots()
        shot = bisect_right(begins, candidate.time)
        return [
            replace(each, scene=candidate.scene, in_transition=shots.is_transition(each.time))
            for each in candidates
            if bisect_right(begins, each.time) == shot
            and all(abs(each.time - begin) >= _EDGE for begin in begins[1:])
        ] or [candidate]

    def at(self, time: float) -> Candidate:
        start = Fraction(time)
        if sample := next(self._sampler.frames(start, start + Fraction(1, 1000)), None):
            return self._features(sample)
        raise InputError(self.name, f"has no picture at {time:g} s")

    def _image_at(self, time: float) -> np.ndarray:
        return self._sampler.image_at(time)

    def _survey_whole(self, gap: float, on_time: Callable[[float], None]) -> Survey:
        shots, candidates, time, last = ShotFinder(), list[Candidate](), 0.0, -gap
        for sample in self._sampler.frames():
            time = float(sample.time)
            on_time(time)
            motion = shots.push(time, small_luma(sample.picture(_SHOT_SIDE)))
            if time - last >= gap - 1e-3:
                candidates.append(replace(self._features(sample), motion=motion))
                last = time
        begins = shots.shots()
        mixed = [replace(each, in_transition=shots.is_transition(each.time)) for each in candidates]
        return Survey(self._in_scenes(mixed, begins), begins, time)

    def _survey_keys(self, gap: float, on_time: Callable[[float], None]) -> Survey:
        shots, candidates, time = KeyShots(), list[Candidate](), 0.0
        for sample in self._sampler.key_frames(Fraction(gap)):
            time = float(sample.time)
            on_time(time)
            candidates.append(self._features(sample))
            shots.push(time, small_luma(sample.picture(_SHOT_SIDE)), candidates[-1].histogram)
        return Survey(self._in_scenes(candidates, shots.scene_starts), shots.scene_starts, time)

    def _in_scenes(self, candidates: list[Candidate], starts: list[float]) -> list[Candidate]:
        if not candidates:
            raise InputError(self.name, "no frame could be decoded")
        self._sampler.warn_if_hdr()
        return [replace(each, scene=max(0, bisect_right(starts, each.time) - 1)) for each in candidates]

    def _features(self, sample: SampledFrame) -> Candidate:
        return extract_features(to_rgb(sample.picture(SIDE)), float(sample.time), sample.shape, self._faces)


class PictureFolder(Film):
    """A folder of pictures as a film: each is a scene of one second, in natural order of their names."""

    def __init__(self, path: Path, faces: FaceFinder) -> None:
        """List the pictures; files of other names are left out.

        Raises:
            InputError: there are none.
        """
        super().__init__()
        self.name = str(path)
        self._faces = faces
        self._has_warned = False
        self._paths = sorted(
            (each for each in path.iterdir() if each.suffix.lower() in SUFFIXES and each.is_file()),
            key=lambda each: natural_order(each.name),
        )
        if not self._paths:
            raise InputError(path, "holds no pictures")

    def survey(self, on_step: OnStep = unwatched) -> Survey:
        candidates = []
        for number in range(len(self._paths)):
            on_step(_STEP, number, len(self._paths))
            try:
                candidates.append(self._features(number))
            except InputError as error:
                log.warning("left out: %s", error)
        if not candidates:
            raise InputError(self.name, "none of its pictures can be read")
        begins = [float(number) for number in range(len(self._paths))]
        return Survey(candidates, begins, float(len(self._paths)), is_folder=True)

    def around(self, candidate: Candidate) -> list[Candidate]:
        return [candidate]

    def at(self, time: float) -> Candidate:
        return self._features(self._number(time))

    def _image_at(self, time: float) -> np.ndarray:
        with FilmSampler(self._paths[self._number(time)]) as sampler:
            return sampler.image_at(0)

    def _features(self, number: int) -> Candidate:
        with FilmSampler(self._paths[number]) as sampler:
            sample = next(sampler.frames(), None)
            if sample is None:
                raise InputError(self._paths[number], "no frame could be decoded")
            small = to_rgb(sample.picture(SIDE))
            if not self._has_warned:
                self._has_warned = sampler.warn_if_hdr()
        return replace(extract_features(small, number, sample.shape, self._faces), scene=number)

    def _number(self, time: float) -> int:
        return min(max(0, int(time)), len(self._paths) - 1)


def open_film(source: str | os.PathLike[str], faces: FaceFinder | None = None) -> Film:
    """A film, an animation, numbered pictures ("%05d.png") or a folder of pictures.

    Raises:
        InputError: it cannot be read, or the folder holds no picture.
        UsageError: it is a pipe, which cannot be rewound.
    """
    if str(source) == "-":
        raise UsageError("standard input", "can be read only once", "save the film to a file")
    faces = faces or FaceFinder()
    return PictureFolder(Path(source), faces) if Path(source).is_dir() else FilmFile(source, faces)
