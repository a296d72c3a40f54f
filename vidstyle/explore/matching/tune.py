"""Tunes the values of a style so that a distance gets smaller: a pattern search over its sliders."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vidstyle.explore.tuning_pad import moved_value, sliders_of
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.style import Style, set_values

FIRST_SHARE, ROUND_COUNT = 0.12, 4
"""Share of its range by which a value is moved in the first round, halved in each further one."""
MIN_GAIN = 1e-3
"""Smallest gain of distance for which a value is moved."""

Distances = Callable[[Sequence[Style]], Sequence[float]]
"""Returns the distance of each style; infinite for styles that are invalid."""


def tune_style(
    style: Style,
    distances: Distances,
    rounds: int = ROUND_COUNT,
    on_step: ProgressCallback = ignore_progress,
) -> tuple[Style, float]:
    """Return the style with values at which its distance is smaller, and this distance.

    Each round moves every value in both directions, one at a time. The best move is made, and all moves
    that helped together if this is still better. The result depends only on the arguments.
    """
    (nearest,) = distances([style])
    share = FIRST_SHARE
    for number in range(rounds):
        moves = [
            (slider["path"], value)
            for slider in sliders_of(style)
            for value in (moved_value(slider, share), moved_value(slider, -share))
            if value != slider["value"]
        ]
        tried = [set_values(style, {path: value}) for path, value in moves]
        found = sorted(zip(distances(tried), range(len(moves)), strict=True))
        helpful = [moves[place] for distance, place in found if distance < nearest - MIN_GAIN]
        if helpful:
            # Of two moves of one value, the better one counts: it comes last in the reversed order.
            together = set_values(style, dict(reversed(helpful)))
            best = tried[found[0][1]]
            nearest, _, style = min(
                (found[0][0], 0, best), (distances([together])[0], 1, together), key=lambda each: each[:2]
            )
        share /= 2
        on_step("tuning values", number + 1, rounds)
    return style, nearest
