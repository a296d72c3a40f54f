"""Folders of pictures as sources of key frames."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from vidstyle.comic.analyze.faces.face_search import add_faces
from vidstyle.comic.analyze.features import (
    MEASURED_SIDE_PX,
    Candidate,
    Survey,
    add_saliency,
    extract_features,
)
from vidstyle.comic.analyze.key_frame_source import STEP_NAME, Film
from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError, log
from vidstyle.media.read.sampler import FilmSampler
from vidstyle.media.read.sequence import natural_sort_key
from vidstyle.pipeline.progress import ProgressCallback
from vidstyle.regions.faces import FaceFinder

PICTURE_SUFFIXES = frozenset(".avif .bmp .gif .heic .jpeg .jpg .jxl .png .ppm .tif .tiff .webp".split())
"""Suffixes of files in a folder that are read as pictures."""


class PictureFolder(Film):
    """A folder of pictures as a film: each is a scene of one second, sorted by name in natural order.

    Pictures of subfolders, such as one for each chapter, follow in the order of the subfolders' names.
    """

    def __init__(self, path: Path, faces: FaceFinder, rotate: int | None = None) -> None:
        """List the pictures; other files are skipped.

        Raises:
            InputError: there are none.
        """
        super().__init__(faces, rotate)
        self.name = str(path)
        self._has_warned = False
        self._paths = sorted(
            (
                each
                for pattern in ("*", "*/*")
                for each in path.glob(pattern)
                if each.suffix.lower() in PICTURE_SUFFIXES and each.is_file()
            ),
            key=lambda each: (
                each.parent != path,
                natural_sort_key(each.parent.name),
                natural_sort_key(each.name),
            ),
        )
        if not self._paths:
            raise InputError(path, "holds no pictures")

    def _survey(self, on_step: ProgressCallback) -> Survey:
        candidates = []
        measured = [self._pool.submit(self._features, number) for number in range(len(self._paths))]
        for number, each in enumerate(measured):
            on_step(STEP_NAME, number, len(self._paths))
            try:
                candidates.append(each.result())
                self.damage.decoded += 1
            except InputError as error:
                self.damage.lost += 1
                log.warning("skipped: %s", error)
        if not candidates:
            raise InputError(self.name, "holds no readable pictures")
        begins = [float(number) for number in range(len(self._paths))]
        return Survey(candidates, begins, float(len(self._paths)), is_folder=True)

    def around(self, candidate: Candidate) -> list[Candidate]:
        return [candidate]

    def at(self, time: float) -> Candidate:
        return self._features(self._number(time))

    def _decode_image(self, time: float) -> np.ndarray:
        with FilmSampler(self._paths[self._number(time)], self.rotate) as sampler:
            return sampler.image_at(0)

    def _features(self, number: int) -> Candidate:
        with FilmSampler(self._paths[number], self.rotate) as sampler:
            sample = next(sampler.frames(), None)
            if sample is None:
                raise InputError(self._paths[number], "no frame could be decoded")
            small = to_rgb(sample.picture(MEASURED_SIDE_PX))
            if not self._has_warned:
                self._has_warned = sampler.warn_if_hdr()
        candidate = add_faces(extract_features(small, number, sample.shape, is_photograph=True), self._faces)
        return replace(add_saliency(candidate), scene=number, edges=None)

    def _number(self, time: float) -> int:
        return min(max(0, int(time)), len(self._paths) - 1)
