"""The motion around candidates, measured on all frames of a film or of a part of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.flaws.motion_blur import FlowMeter
from vidstyle.comic.analyze.moving.subject_motion import SubjectMotion
from vidstyle.comic.analyze.shots import ShotFinder
from vidstyle.core.sampling import small_luma
from vidstyle.media.read.sampler import SampledFrame

SHOT_SIDE_PX = 128
"""Longer side of the copies in which cuts and motion are measured."""


class CandidateMotion:
    """Finds cuts, and measures motion, flow and moving subjects at candidates.

    Attributes:
        shots: the cuts and transitions.
    """

    def __init__(self, has_subjects: bool = True) -> None:
        """`has_subjects`: whether moving subjects are followed."""
        self.shots = ShotFinder()
        self._meter, self._subjects = FlowMeter(), SubjectMotion() if has_subjects else None
        self._motions, self._flows = list[float](), list[np.ndarray | None]()
        self._is_first = False

    def push(self, sample: SampledFrame, is_candidate: bool) -> None:
        """Add the next frame; all frames are needed, though only candidates are measured."""
        time, luma = float(sample.time), small_luma(sample.picture(SHOT_SIDE_PX))
        motion, flow = (
            self.shots.push(time, luma),
            self._meter.push(time, luma, is_candidate or self._is_first),
        )
        begins = self.shots.begins_at(time)
        if self._is_first and not begins:
            # Nothing precedes the first frame of a shot: it moves as the second one does.
            self._motions[-1], self._flows[-1] = motion, flow
        if self._subjects:
            self._subjects.push(time, luma, is_candidate)
        if is_candidate:
            self._motions.append(motion)
            self._flows.append(flow)
        self._is_first = is_candidate and begins

    def add_to(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """Return the candidates, all of them in their order, with their motion and flow."""
        return [
            replace(each, motion=motion, flow=flow)
            for each, motion, flow in zip(candidates, self._motions, self._flows, strict=True)
        ]

    def masks(self) -> list[np.ndarray | None]:
        """Return for each candidate the mask of what moves; None if it is not known."""
        return (self._subjects.masks() if self._subjects else []) or [None] * len(self._motions)
