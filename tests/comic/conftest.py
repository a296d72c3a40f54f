"""Fixtures for the tests of comic pages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vidstyle.comic.analyze import faces, film
from vidstyle.comic.analyze.face_networks import find_faces, load_networks
from vidstyle.comic.analyze.features import Candidate, Survey, extract_features
from vidstyle.comic.analyze.film import FilmFile
from vidstyle.media.read.decode_report import DecodeReport


@pytest.fixture(scope="package", autouse=True)
def pictures_are_measured_once() -> Iterator[None]:
    """Many tests look at the same films: what is found in a picture, or a file, is remembered."""
    surveys: dict[tuple[object, ...], tuple[Survey, DecodeReport]] = {}
    around: dict[tuple[object, ...], list[Candidate]] = {}
    found: dict[tuple[bytes, tuple[int, ...], float], np.ndarray] = {}
    measured: dict[tuple[bytes, object, float, object], Candidate] = {}

    def remembered_faces(color: np.ndarray, networks: Any, least: float) -> np.ndarray:
        key = color.tobytes(), color.shape, least
        if key not in found:
            found[key] = find_faces(color, networks, least)
        return found[key].copy()

    def remembered_features(color: np.ndarray, time: float, shape: tuple[int, int]) -> Candidate:
        key = color.tobytes(), color.shape, time, shape
        if key not in measured:
            measured[key] = extract_features(color, time, shape)
        return measured[key]

    def file_key(film: FilmFile) -> tuple[object, ...]:
        """Numbered pictures are no one file: theirs are measured each time."""
        path = Path(film.name)
        return (path, path.stat().st_mtime_ns, path.stat().st_size) if path.is_file() else (film,)

    survey_whole, look_around = FilmFile._survey_whole, FilmFile.around

    def remembered_survey(self: FilmFile, gap: float, on_time: Callable[[float], None]) -> Survey:
        key = *file_key(self), gap
        if key not in surveys:
            surveys[key] = survey_whole(self, gap, on_time), self.damage
        survey, self.damage = surveys[key]
        return survey

    def remembered_frames(self: FilmFile, candidate: Candidate) -> list[Candidate]:
        key = *file_key(self), candidate.time, candidate.scene, self._search_seconds
        if key not in around:
            around[key] = look_around(self, candidate)
        return list(around[key])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FilmFile, "_survey_whole", remembered_survey)
        patch.setattr(FilmFile, "around", remembered_frames)
        patch.setattr(faces, "find_faces", remembered_faces)
        patch.setattr(faces, "load_networks", cache(load_networks))
        patch.setattr(film, "extract_features", remembered_features)
        yield
