"""A report of the frames of a film that no panel may show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from vidstyle.comic.analyze.features import Candidate

_REASONS = {
    "damaged": "damaged",
    "in_transition": "in dissolves or fades",
    "blurred": "blurred",
    "combed": "interlaced",
}
"""Attributes of candidates and what they are called; of several, the first one counts."""


def describe_refused(candidates: Sequence[Candidate]) -> str:
    """Return the number of a film's refused candidates and the reasons; empty if all are used."""
    reasons = Counter(next((name for name in _REASONS if getattr(each, name)), "") for each in candidates)
    shown = [f"{reasons[name]} {text}" for name, text in _REASONS.items() if reasons[name]]
    count = len(candidates) - reasons[""]
    return f"{count} of {len(candidates)} frames were not used: {', '.join(shown)}" if shown else ""


def describe_lack(candidates: Sequence[Candidate]) -> str:
    """Return why a film gives no second panel: most frames are refused, or the others differ too little."""
    refused = sum(each.is_flawed for each in candidates)
    if 2 * refused > len(candidates):
        return f"{refused} of its {len(candidates)} frames were not used"
    return "its other frames are too similar or less clear"
