"""The thirds of a film: its beginning, its middle and its end, each of which a page should show."""

from __future__ import annotations

from collections.abc import Sequence

from vidstyle.comic.analyze.features import Candidate

_THIRD_COUNT = 3
_MIN_FILM_SECONDS = 3.0
"""Duration from which the thirds of a film are different moments."""


def film_thirds(candidates: Sequence[Candidate], seconds: float) -> list[int]:
    """Return the third in which each candidate is: 0, 1 or 2; all 0 in a shorter film than three seconds."""
    if seconds < _MIN_FILM_SECONDS:
        return [0] * len(candidates)
    return [min(_THIRD_COUNT - 1, max(0, int(_THIRD_COUNT * each.time / seconds))) for each in candidates]
