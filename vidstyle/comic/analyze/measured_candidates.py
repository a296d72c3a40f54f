"""Candidates that are measured in other threads while a film is being decoded."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace

from vidstyle.comic.analyze.features import Candidate
from vidstyle.core.machine.cores import available_cores

_FACE_INTERVAL_SECONDS = 1.25
"""Interval between candidates in which faces are detected; the others get the faces of the nearest one."""
_MAX_WAITING_PER_CORE = 4
"""Maximum number of pictures per core that wait to be measured."""


class MeasuredCandidates:
    """The candidates of a film, which are measured while it is being decoded."""

    def __init__(self) -> None:
        self._futures: list[Future[Candidate]] = []
        self._looked: list[bool] = []
        self._last = -_FACE_INTERVAL_SECONDS
        self._max_waiting = _MAX_WAITING_PER_CORE * available_cores()

    def append(
        self, time: float, measure: Callable[[bool], Future[Candidate]], is_new_shot: bool = False
    ) -> None:
        """Add the next candidate.

        Args:
            time: in seconds.
            measure: starts its measurement, with or without faces.
            is_new_shot: whether there is a cut before it, so that earlier faces tell nothing.
        """
        looks = is_new_shot or time - self._last >= _FACE_INTERVAL_SECONDS - 1e-3
        if looks:
            self._last = time
        self._looked.append(looks)
        self._futures.append(measure(looks))
        if len(self._futures) > self._max_waiting:
            self._futures[-self._max_waiting].result()

    def candidates(self) -> list[Candidate]:
        """Return all candidates."""
        return [each.result() for each in self._futures]

    def fill_missing_faces(self, candidates: list[Candidate]) -> list[Candidate]:
        """Fill in missing faces from the nearest candidate of the same scene."""
        scenes: dict[int, list[Candidate]] = {}
        for each, looked in zip(candidates, self._looked, strict=True):
            if looked:
                scenes.setdefault(each.scene, []).append(each)
        return [
            each
            if looked or each.scene not in scenes
            else _with_faces_of(each, min(scenes[each.scene], key=lambda other: abs(other.time - each.time)))
            for each, looked in zip(candidates, self._looked, strict=True)
        ]


def _with_faces_of(candidate: Candidate, other: Candidate) -> Candidate:
    return replace(candidate, faces=other.faces, face_detail=other.face_detail)
