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
"""Maximum number of frames of which it is known whether they look alike."""


def describe_refused(candidates: Sequence[Candidate]) -> str:
    """Return the number of a film's refused candidates and the reasons; empty if all are used."""
    reasons = Counter(next((name for name in _REASONS if getattr(each, name)), "") for each in candidates)
    shown = [f"{reasons[name]} {text}" for name, text in _REASONS.items() if reasons[name]]
    count = len(candidates) - reasons[""]
    return f"{count} of {len(candidates)} frames were not used: {', '.join(shown)}" if shown else ""


def describe_lack(candidates: Sequence[Candidate]) -> str:
    """Return why a film gives no second panel: refused frames, or others that look alike or are unclear."""
    used = [each for each in candidates if not each.is_flawed]
    if 2 * len(used) < len(candidates):
        return f"{len(candidates) - len(used)} of its {len(candidates)} frames were not used"
    compared = used[:: -(-len(used) // _MAX_COMPARED_FRAMES)]
    is_alike = float(similarity([each.thumbnail for each in compared]).min()) > SAME_SIMILARITY
    return "its other frames look too similar" if is_alike else "its other frames are less clear"
