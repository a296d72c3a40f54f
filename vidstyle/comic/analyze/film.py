"""Films as sources of key frames, analysed in bounded memory."""

from __future__ import annotations

import math
import os
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import groupby
from pathlib import Path

import numpy as np

from vidstyle.comic.analyze.candidate_motion import SHOT_SIDE_PX, CandidateMotion
from vidstyle.comic.analyze.faces.face_search import add_faces
from vidstyle.comic.analyze.features import (
    MEASURED_SIDE_PX,
    Candidate,
    Survey,
    cut_bars,
    extract_features,
)
from vidstyle.comic.analyze.flaws.combs import is_combed
from vidstyle.comic.analyze.flaws.defects import measure_blockiness
from vidstyle.comic.analyze.flaws.film_defects import FilmDefects
from vidstyle.comic.analyze.flaws.motion_blur import mark_fast_faces
from vidstyle.comic.analyze.key_frame_source import STEP_NAME, Film
from vidstyle.comic.analyze.measured_candidates import MeasuredCandidates
from vidstyle.comic.analyze.moving.action import add_actions
from vidstyle.comic.analyze.moving.subject_motion import add_moving_subjects, follow_subject
from vidstyle.comic.analyze.moving.subject_sharpness import compare_subjects
from vidstyle.comic.analyze.picture_folder import PictureFolder
from vidstyle.comic.analyze.shots import KeyShots, is_in_transition
from vidstyle.comic.analyze.upright import GLANCE_SIDE_PX, MAX_GLANCES, find_turn
from vidstyle.comic.select.panel_count import default_panels
from vidstyle.core.convert import to_rgb
from vidstyle.core.sampling import small_luma
from vidstyle.errors import InputError, UsageError, log
from vidstyle.media.read.sampler import FilmSampler, SampledFrame, exact_time
from vidstyle.pipeline.progress import ProgressCallback
from vidstyle.regions.faces import FaceFinder

# How much of a film is decoded.
MAX_WHOLE_PIXELS = 2 * 10**9
"""Films with at most this many pixels in all frames are decoded whole; of longer ones only key frames."""
MIN_KEYS_PER_PANEL = 2.5
"""Minimum number of key frames per panel; a long film with fewer is decoded whole nevertheless."""

# Candidates.
MAX_CANDIDATES = 3600
"""Maximum number of candidates, however long the film."""
_MIN_CANDIDATE_SECONDS = 1 / 4
"""Minimum interval between candidates."""
_SHORT_FILM_CANDIDATES = 8
"""Number of candidates of a film that is shorter than this many intervals."""

# The search for a better frame near a candidate.
_CUT_MARGIN_SECONDS = 0.1
"""Time around a cut without key frames: compressed pictures are worst there, and may mix two shots."""
_CONTEXT_SECONDS = 0.2
"""Additional time that is decoded, in which cuts and the motion of subjects are seen."""
_SEARCH_SECONDS, _MOVING_SEARCH_SECONDS, _KEY_SEARCH_SECONDS = 0.5, 0.7, 0.8
"""Time around a candidate that is searched; the second value if its subject moves, and the third one if only
key frames were decoded before."""
_SEARCH_STEP_SECONDS = 1 / 15
"""Minimum interval of the frames that are compared there."""
_KEY_CONTEXT_SECONDS = 1.2
"""Additional time in which cuts and dissolves are then detected."""


class FilmFile(Film):
    """A film, an animation or numbered pictures."""

    def __init__(self, source: str | os.PathLike[str], faces: FaceFinder, rotate: int | None = None) -> None:
        super().__init__(faces, rotate)
        self.name = str(source)
        self._sampler = FilmSampler(source, rotate)
        self._search_seconds = _SEARCH_SECONDS
        self._defects = FilmDefects()
        self._may_turn = rotate is None
        self._transitions: list[tuple[float, float]] = []
        self._measured: dict[float, Candidate] = {}

    def close(self) -> None:
        super().close()
        self._sampler.close()

    def _survey(self, on_step: ProgressCallback) -> Survey:
        found = self._survey_as_it_is(on_step)
        return self._survey_as_it_is(on_step) if self._turn_upright(found) else found

    def _turn_upright(self, survey: Survey) -> bool:
        """Turn a film without faces if it shows people sideways; return whether it was turned."""
        if not (self._may_turn and self._faces.has_model) or any(each.faces for each in survey.candidates):
            return False
        turn = find_turn(self._glance(survey), self._faces)
        self._may_turn, rotate = False, self._sampler.turn(turn) if turn else None
        if rotate is None:
            return False
        self.rotate, self._defects = rotate, FilmDefects()
        log.info(
            "turned by %d degrees, as people are upright only then; --rotate %d leaves the film sideways",
            *(turn, (rotate - turn) % 360),
        )
        return True

    def _glance(self, survey: Survey) -> Iterator[np.ndarray]:
        """Yield small pictures of the film: first a few from all over it."""
        times = [
            each.time for each in survey.candidates[:: max(1, -(-len(survey.candidates) // MAX_GLANCES))]
        ]
        for time in (time for first in range(3) for time in times[first::3]):
            sample = next(self._sampler.frames(exact_time(time)), None)
            if sample is not None:  # a damaged film may end earlier
                yield to_rgb(sample.picture(GLANCE_SIDE_PX))

    def _survey_as_it_is(self, on_step: ProgressCallback) -> Survey:
        seconds = float(self._sampler.seconds)
        self._measured.clear()

        def on_time(time: float) -> None:
            on_step(STEP_NAME, time, seconds)

        gap = max(min(_MIN_CANDIDATE_SECONDS, seconds / _SHORT_FILM_CANDIDATES), seconds / MAX_CANDIDATES)
        if self._sampler.pixels > MAX_WHOLE_PIXELS:
            found = self._survey_keys(max(gap, 0.5), on_time)
            if len(found.candidates) >= MIN_KEYS_PER_PANEL * default_panels(len(found.scene_starts), seconds):
                self._search_seconds = _KEY_SEARCH_SECONDS
                return found
        return self._survey_whole(gap, on_time)

    def around(self, candidate: Candidate) -> list[Candidate]:
        reach = max(self._search_seconds, _MOVING_SEARCH_SECONDS if candidate.action is not None else 0.0)
        context = _KEY_CONTEXT_SECONDS if reach == _KEY_SEARCH_SECONDS else _CONTEXT_SECONDS
        motion, measured = CandidateMotion(candidate.action is not None), list[Future[Candidate]]()
        start, end, last = candidate.time - reach - context, candidate.time + (reach + context), -math.inf
        for sample in self._sampler.frames(Fraction(max(0.0, start)), Fraction(end)):
            time = float(sample.time)
            is_near = abs(time - candidate.time) <= reach
            is_near &= time - last >= _SEARCH_STEP_SECONDS - 1e-3 or time == candidate.time
            motion.push(sample, is_near)
            if is_near:
                last = time
                measured.append(self._measure(sample))
        begins = motion.shots.shots()
        shot = bisect_right(begins, candidate.time)
        # Transitions of the whole film, too: a part of a long one does not look like one.
        transitions = [*motion.shots.transitions, *self._transitions]
        candidates = motion.add_to([each.result() for each in measured])
        followed = follow_subject(candidate.action, candidates, motion.masks()) if candidate.action else []
        actions = {each.time: each.action for each in followed}
        return [
            self._defects.mark(
                replace(
                    each,
                    scene=candidate.scene,
                    in_transition=is_in_transition(each.time, transitions),
                    action=actions.get(each.time),
                )
            )
            for each in candidates
            if bisect_right(begins, each.time) == shot and not _is_near_cut(each.time, begins)
        ] or [replace(self.at(candidate.time), scene=candidate.scene)]

    def at(self, time: float) -> Candidate:
        start = exact_time(time)
        if sample := next(self._sampler.frames(start, start + Fraction(1, 1000)), None):
            return self._measure(sample).result()
        raise InputError(self.name, f"has no picture at {time:g} s")

    def _decode_image(self, time: float) -> np.ndarray:
        return self._sampler.image_at(time)

    def _survey_whole(self, gap: float, on_time: Callable[[float], None]) -> Survey:
        motion, measured, runs, run = CandidateMotion(), MeasuredCandidates(), list[int](), 0
        time, last, is_new_shot = 0.0, -gap, False
        for sample in self._sampler.frames():
            time = float(sample.time)
            on_time(time)
            is_candidate = time - last >= gap - 1e-3
            motion.push(sample, is_candidate)
            run += sample.is_key
            is_new_shot |= motion.shots.begins_at(time)
            if is_candidate:
                measured.append(time, partial(self._measure, sample), is_new_shot)
                runs.append(run)
                # The first picture after a cut may be a remainder of the shot before.
                last, is_new_shot = time, motion.shots.begins_at(time)
        self.damage = self._sampler.damage
        begins = motion.shots.shots()
        self._transitions = motion.shots.transitions
        mixed = [
            replace(each, key_run=run, in_transition=motion.shots.is_transition(each.time))
            for each, run in zip(motion.add_to(measured.candidates()), runs, strict=True)
        ]
        placed = _mark_cut_frames(self._assign_scenes(mixed, begins), begins)
        moving = dict(zip((each.time for each in placed), motion.masks(), strict=True))
        shots_of = groupby(placed, key=lambda each: each.scene)
        tracked = [
            each
            for _, group in shots_of
            for shot in [list(group)]
            for each in add_moving_subjects(shot, [moving[other.time] for other in shot])
        ]
        compared, sharpest = compare_subjects(tracked)
        return Survey(
            mark_fast_faces(measured.fill_missing_faces(compared)), begins, time, sharpest_subjects=sharpest
        )

    def _survey_keys(self, gap: float, on_time: Callable[[float], None]) -> Survey:
        shots, measured, lumas, time = KeyShots(), MeasuredCandidates(), list[np.ndarray](), 0.0
        for sample in self._sampler.key_frames(Fraction(gap)):
            time = float(sample.time)
            on_time(time)
            measured.append(time, partial(self._measure, sample))
            lumas.append(small_luma(sample.picture(SHOT_SIDE_PX)))
        self.damage = self._sampler.damage
        candidates = measured.candidates()
        for each, luma in zip(candidates, lumas, strict=True):
            shots.push(each.time, luma, each.histogram)
        compared, sharpest = compare_subjects(self._assign_scenes(candidates, shots.scene_starts))
        return Survey(
            measured.fill_missing_faces(compared), shots.scene_starts, time, sharpest_subjects=sharpest
        )

    def _assign_scenes(self, candidates: list[Candidate], starts: list[float]) -> list[Candidate]:
        if not candidates:
            raise InputError(self.name, "no frame could be decoded")
        self._sampler.warn_if_hdr()
        scenes = [max(0, bisect_right(starts, each.time) - 1) for each in candidates]
        placed = [replace(each, scene=scene) for each, scene in zip(candidates, scenes, strict=True)]
        shots = [list(shot) for _, shot in groupby(placed, key=lambda each: each.scene)]
        marked = self._defects.mark_all([each for shot in shots for each in add_actions(shot, shot)])
        if self._defects.is_interlaced:
            self._sampler.deinterlace_all()
        return marked

    def _measure(self, sample: SampledFrame, finds_faces: bool | None = None) -> Future[Candidate]:
        """Start measuring the features of a frame; frames without errors are measured once.

        `finds_faces`: whether to detect large faces, without keeping the small copy; None: keep it.
        """
        small, time, shape = to_rgb(sample.picture(MEASURED_SIDE_PX)), float(sample.time), sample.shape
        is_damaged, is_interlaced = sample.is_damaged, sample.is_interlaced
        known = None if is_damaged else self._measured.get(time)
        if known is not None and finds_faces is None:
            return self._pool.submit(lambda: replace(known, small=cut_bars(small)))
        luma = sample.stored_luma()

        def measure() -> Candidate:
            candidate = extract_features(small, time, shape)
            candidate = replace(
                candidate,
                damaged=candidate.damaged or is_damaged,
                combed=not is_interlaced and is_combed(luma),
                blockiness=measure_blockiness(luma),
            )
            if not is_damaged:
                self._measured[time] = replace(candidate, small=None)
            if finds_faces is None:
                return candidate
            return replace(
                add_faces(candidate, self._faces, only_large=True) if finds_faces else candidate, small=None
            )

        return self._pool.submit(measure)


def _is_near_cut(time: float, starts: Sequence[float]) -> bool:
    """Whether a time is so close to the start of a later shot that its frame may mix both."""
    return any(abs(time - start) < _CUT_MARGIN_SECONDS for start in starts[1:])


def _mark_cut_frames(candidates: list[Candidate], starts: list[float]) -> list[Candidate]:
    """Mark candidates at cuts as transitions, unless their scene has no others, as in a slide show."""
    lasting = {each.scene for each in candidates if not _is_near_cut(each.time, starts)}
    return [
        replace(each, in_transition=True)
        if each.scene in lasting and _is_near_cut(each.time, starts)
        else each
        for each in candidates
    ]


def open_film(
    source: str | os.PathLike[str], faces: FaceFinder | None = None, rotate: int | None = None
) -> Film:
    """Open a film, an animation, numbered pictures ("%05d.png") or a folder of pictures.

    Args:
        source: its path.
        faces: detects faces.
        rotate: degrees clockwise, a multiple of 90, instead of the rotation in the metadata.

    Raises:
        InputError: it cannot be read, is a pipe or a device, or the folder contains no pictures.
        UsageError: it is standard input, which cannot be rewound.
    """
    if str(source) == "-":
        raise UsageError("standard input", "can be read only once", "save the film to a file")
    if os.path.exists(source) and not (os.path.isfile(source) or os.path.isdir(source)):
        raise InputError(source, "is neither a file nor a folder", "save the film to a file")
    faces = faces or FaceFinder()
    kind = PictureFolder if os.path.isdir(source) else FilmFile
    return kind(Path(source), faces, rotate)
