"""Selection of the key frames of a film."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.select.framing import (
    alternate_framing,
    approach_faces,
    merge_equal,
    remove_repeats,
    widen_soft_faces,
)
from vidstyle.comic.select.importance import equalize_places, importance, prefer_subjects
from vidstyle.comic.select.key_frame_options import KeyFrameOptions as KeyFrameOptions
from vidstyle.comic.select.panel_count import MAX_DEFAULT_PANELS
from vidstyle.comic.select.prune import prune
from vidstyle.comic.select.readable import Readability, ReadableSearch
from vidstyle.comic.select.refinement import Refinement
from vidstyle.comic.select.usable import usable_candidates
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress


def find_key_frames(
    film: Film,
    options: KeyFrameOptions | None = None,
    on_step: ProgressCallback = ignore_progress,
    readability: Readability | None = None,
) -> list[KeyFrame]:
    """Find the key frames of a film, in chronological order.

    There are fewer than requested if the film does not have that many frames.

    Args:
        film: the source.
        options: how they are chosen.
        on_step: called with the name of a step and its progress.
        readability: measures frames as they will be drawn; the others are replaced or left out.

    Raises:
        InputError: the film cannot be read, or contains no frame that can be printed.
        UsageError: the options contradict each other or the film.
    """
    options = options or KeyFrameOptions()
    options.check()
    survey = film.survey(on_step)
    forced = _find_requested(film, survey, options)
    left = [each for each in survey.candidates if not options.skips(each.time)]
    seen = replace(survey, candidates=left)
    if options.panels is None:
        forced = _add_panels_for_words(forced, left, options.words)
    search = ReadableSearch(Refinement(film, survey, options.skips, on_step), options, readability)

    def frame(found: Sequence[Candidate]) -> list[Candidate]:
        """Return the frames with their importance, as wide views or close-ups."""
        weights = [
            weight * search.legibility_of(each)
            for each, weight in zip(found, importance(found, survey), strict=True)
        ]
        weighted = [replace(each, importance=weight) for each, weight in zip(found, weights, strict=True)]
        if survey.is_folder:
            return weighted
        is_fixed = options.panels is not None
        return widen_soft_faces(alternate_framing(prefer_subjects(weighted), enlarges_small=is_fixed))

    def keep(found: Sequence[Candidate]) -> list[Candidate]:
        framed = frame(found)
        if options.min_panels:
            return prune(framed, options.min_panels)
        return prune(remove_repeats(framed), len(forced))

    better = search.run(seen, forced, keep)
    if not better:
        if left:
            raise InputError(film.name, *_describe_unusable(left))
        raise UsageError("--skip", "leaves no frame of the film")
    if survey.is_folder or options.panels is not None:
        return list(frame(better))
    kept = keep(better)
    return list(approach_faces(equalize_places(kept if options.min_panels else merge_equal(kept))))


def _describe_unusable(candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """Explain why no frame of a film can be printed, and what helps."""
    if all(each.blank or each.test_picture for each in candidates):
        return ("holds only blank frames",)
    return "holds no frame without damage, a dissolve or a fade", "print one nevertheless with --at SECONDS"


def _find_requested(film: Film, survey: Survey, options: KeyFrameOptions) -> list[Candidate]:
    last = max(survey.seconds, survey.candidates[-1].time)
    for time in options.at:
        if time > last + 1:
            raise UsageError("--at", f"{time:g} s is after the end", f"the film has {last:.1f} s")
    found = {}
    for time in options.at:
        each = film.at(time)
        scene = max(0, bisect_right(survey.scene_starts, each.time) - 1)
        found[each.time] = replace(each, scene=scene, forced=True)
    return [found[time] for time in sorted(found)]


def _add_panels_for_words(
    forced: Sequence[Candidate], candidates: Sequence[Candidate], words: Sequence[float]
) -> list[Candidate]:
    """Return the forced frames and, for each time of words, the nearest usable frame not yet taken."""
    found = {each.time: each for each in forced}
    usable = usable_candidates(candidates)
    for time in words:
        free = [each for each in usable if each.time not in found]
        if free and len(found) < MAX_DEFAULT_PANELS:
            nearest = min(free, key=lambda each: abs(each.time - time))
            found[nearest.time] = replace(nearest, forced=True)
    return [found[time] for time in sorted(found)]
