"""In which candidates of a film faces are detected, and that no frame is measured twice."""

from __future__ import annotations

import shutil
from concurrent.futures import Future
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from stories import story, write_film

from vidstyle.comic.analyze import film as film_file
from vidstyle.comic.analyze.features import Candidate, extract_features
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.measured_candidates import MeasuredCandidates


def test_faces_are_detected_at_intervals_and_after_each_cut() -> None:
    measured, searched = MeasuredCandidates(), list[float]()
    for time in np.arange(0, 3, 0.25):

        def measure(finds_faces: bool, time: float = float(time)) -> Future[Candidate]:
            if finds_faces:
                searched.append(time)
            result = Future[Candidate]()
            result.set_result(extract_features(np.zeros((36, 64, 3), np.uint8), time, (36, 64)))
            return result

        measured.append(float(time), measure, is_new_shot=time in (0.5, 2.0))
    assert searched == [0.0, 0.5, 1.75, 2.0]


def test_frames_near_a_candidate_are_measured_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    times = list[float]()

    def measure(color: np.ndarray, time: float, shape: tuple[int, int]) -> Candidate:
        times.append(time)
        return extract_features(color, time, shape)

    monkeypatch.setattr(film_file, "extract_features", measure)
    path = write_film(tmp_path / "film.mp4", story(1, 60))
    other = shutil.copy(path, tmp_path / "other.mp4")  # tests measure no file twice
    with open_film(path) as surveyed, open_film(other) as opened:
        seen = surveyed.survey().candidates
        candidate = seen[len(seen) // 2]
        fresh = opened.around(candidate)
        times.clear()
        again = surveyed.around(candidate)
        assert times and {each.time for each in seen}.isdisjoint(times)
    assert len(fresh) == len(again)
    for one, same in zip(fresh, again, strict=True):
        for each in fields(Candidate):
            np.testing.assert_equal(getattr(one, each.name), getattr(same, each.name), each.name)
