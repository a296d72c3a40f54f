"""The candidates that panels may show."""

from __future__ import annotations

from collections.abc import Sequence

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.select.movers import is_cut_off


def usable_candidates(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates that panels may show: without defects, if the film has any.

    A scene with combed frames only shows these: fine lines of a still picture look like combs. A film without
    a single good frame shows those in which the decoder reported errors, then blurred ones. Blank and test
    pictures, visible damage and blends of two shots are never shown, nor are frames with reported errors if
    the film has visible damage.
    """
    shown = [
        each
        for each in candidates
        if not (each.blank or each.test_picture or each.broken or each.in_transition)
    ]
    whole = [each for each in shown if not each.damaged]
    if any(each.broken for each in candidates):
        shown = whole
    steady = [each for each in whole if not each.blurred]
    sharp = [each for each in shown if not each.blurred]
    whole_scenes = {each.scene for each in steady if not each.combed}
    return [each for each in steady if not (each.combed and each.scene in whole_scenes)] or sharp or shown


def keep_whole_subjects(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates without those whose subject has left the picture or is cut off by its edge.

    Of a scene that has only such candidates, those with a cut subject are kept; or else all, if a film has
    nothing else. A person whose face is seen has not left: only the hands have moved.
    """
    shown = [each for each in candidates if each.faces or not (each.action and each.action.is_gone)]
    shown = shown or list(candidates)
    whole = [each for each in shown if not is_cut_off(each)]
    scenes = {each.scene for each in whole}
    return [each for each in shown if each.scene not in scenes] + whole
