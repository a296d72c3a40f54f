"""In which candidates of a film faces are detected."""

from __future__ import annotations

from concurrent.futures import Future

import numpy as np

from vidstyle.comic.analyze.features import Candidate, extract_features
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
