"""Fixtures for the tests of comic pages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vidstyle.comic.analyze import film
from vidstyle.comic.analyze.features import Candidate, Survey, extract_features
from vidstyle.comic.analyze.film import FilmFile
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.regions import faces
from vidstyle.regions.face_detection.face_networks import find_faces, load_networks


@pytest.fixture(scope="package", autouse=True)
def measure_pictures_once() -> Iterator[None]:
    """Cache the results of analysing a picture or a film; most tests use the same films."""
    surveys: dict[tuple[object, ...], tuple[Survey, DecodeReport]] = {}
    around: dict[tuple[object, ...], list[Candidate]] = {}
    found: dict[tuple[bytes, tuple[int, ...], tuple[float, ...]], np.ndarray] = {}
    measured: dict[tuple[bytes, object, float, object], Candidate] = {}

    def find_faces_once(color: np.ndarray, networks: Any, *limits: float) -> np.ndarray:
        key = color.tobytes(), color.shape, limits
        if key not in found:
            found[key] = find_faces(color, networks, *limits)
        return found[key].copy()

    def extract_features_once(
        color: np.ndarray, time: float, shape: tuple[int, int], is_photograph: bool = False
    ) -> Candidate:
        key = color.tobytes(), color.shape, time, (shape, is_photograph)
        if key not in measured:
            measured[key] = extract_features(color, time, shape, is_photograph)
        return measured[key]

    def file_key(film: FilmFile) -> tuple[object, ...]:
        """Return a cache key; numbered pictures are not one file, so they are measured each time."""
        path, turned = Path(film.name), film._sampler._turned
        return (path, path.stat().st_mtime_ns, path.stat().st_size, turned) if path.is_file() else (film,)

    survey_whole, look_around = FilmFile._survey_whole, FilmFile.around

    def survey_once(self: FilmFile, gap: float, on_time: Callable[[float], None]) -> Survey:
        key = *file_key(self), gap
        if key not in surveys:
            surveys[key] = survey_whole(self, gap, on_time), self.damage
        survey, self.damage = surveys[key]
        return survey

    def look_around_once(self: FilmFile, candidate: Candidate) -> list[Candidate]:
        key = *file_key(self), candidate.time, candidate.scene, bool(candidate.action), self._search_seconds
        if key not in around:
            around[key] = look_around(self, candidate)
        return list(around[key])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FilmFile, "_survey_whole", survey_once)
        patch.setattr(FilmFile, "around", look_around_once)
        patch.setattr(faces, "find_faces", find_faces_once)
        patch.setattr(faces, "load_networks", cache(load_networks))
        patch.setattr(film, "extract_features", extract_features_once)
        yield
