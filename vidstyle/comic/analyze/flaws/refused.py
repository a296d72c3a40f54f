"""A report of the frames of a film that no panel may show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, similarity

_REASONS = {
    "damaged": "damaged",
    "in_transition": "in dissolves or fades",
    "blurred": "blurred",
    "combed": "interlaced",
}
"""Attributes of candidates and what they are called; of several, the first one counts."""

_MAX_COMPARED_FRAMES = 40
"""Maximum number of frames that are compared with the panels."""


def describe_refused(candidates: Sequence[Candidate]) -> str:
    """Return the number of a film's refused candidates and the reasons; empty if all are used."""
    reasons = Counter(next((name for name in _REASONS if getattr(each, name)), "") for each in candidates)
    shown = [f"{reasons[name]} {text}" for name, text in _REASONS.items() if reasons[name]]
    count = len(candidates) - reasons[""]
    return f"{count} of {len(candidates)} frames were not used: {', '.join(shown)}" if shown else ""


def describe_lack(candidates: Sequence[Candidate], times: Sequence[float]) -> str:
    """Return why a film gives only the panels of these times, in seconds.

    The other frames are refused, or they show the same view, though something may move in it, or else they
    have lower scores.
    """
    used = [each for each in candidates if not each.is_flawed]
    if 2 * len(used) < len(candidates):
        return f"{len(candidates) - len(used)} of its {len(candidates)} frames were not used"
    nearest = [min(used, key=lambda each: abs(each.time - time)) for time in times]
    others = [each for each in used if each.time not in {shown.time for shown in nearest}]
    if not others:
        return "no other usable frame"
    compared = others[:: -(-len(others) // _MAX_COMPARED_FRAMES)]
    like = similarity([each.thumbnail for each in (*nearest, *compared)])[: len(nearest), len(nearest) :]
    share = float((like.max(axis=0) > SAME_SIMILARITY).mean())
    view = "view" if len(times) == 1 else "views"
    if share <= 0.5:
        return "its other views were rated lower"
    return f"{'its' if share == 1 else 'most of its'} other frames show the same {view}"
