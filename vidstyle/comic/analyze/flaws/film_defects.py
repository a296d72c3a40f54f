"""Marks the defects of a film's candidates, and later of single frames by the same limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.flaws.defect_limits import DefectLimits, damaged_spans, fill_damage, spread_damage

# Films that are interlaced, though their frames lack the flag.
_MIN_COMBED_MOTION, _MIN_COMBED_SHARE = 0.02, 0.5
"""Motion from which a frame would be combed, and share of combed frames, above the 0.4 of telecined films."""


class FilmDefects:
    """The defects of a film; before `mark_all`, single frames are unchanged.

    Attributes:
        is_interlaced: whether most moving frames are combed: the film is interlaced without the flag.
    """

    def __init__(self) -> None:
        self.is_interlaced = False
        self._limits: DefectLimits | None = None
        self._damaged_spans: list[tuple[float, float]] = []

    def mark_all(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """Mark damaged and blurred candidates, compared with the film, and remember the limits."""
        moving = [each.combed for each in candidates if each.motion > _MIN_COMBED_MOTION]
        self.is_interlaced = sum(moving) > _MIN_COMBED_SHARE * len(moving)
        if self.is_interlaced:
            candidates = [replace(each, combed=False) for each in candidates]
        self._limits = DefectLimits.of(candidates)
        is_reported = any(each.damaged and not each.broken for each in candidates)
        spread = spread_damage if is_reported else fill_damage
        marked = spread([self._limits.mark(each) for each in candidates])
        self._damaged_spans = damaged_spans(marked)
        return marked

    def mark(self, candidate: Candidate) -> Candidate:
        """Mark a single frame as `mark_all` marks candidates."""
        marked = self._limits.mark(candidate) if self._limits else candidate
        is_damaged = any(first <= candidate.time <= last for first, last in self._damaged_spans)
        is_combed = marked.combed and not self.is_interlaced
        return replace(marked, damaged=marked.damaged or is_damaged, combed=is_combed)
