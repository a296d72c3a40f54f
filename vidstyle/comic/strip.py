"""A strip for phones: one column of panels, with heights and pauses that vary."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.cost import Taste, panel_costs, taste, wanted_areas
from vidstyle.comic.moment import Moment
from vidstyle.comic.paper import Paper, Rectangle

_STEPS = 24
"""Heights are multiples of this part of the width."""
_HIGHEST = 2
"""Heights by the width."""
_USUAL = 1.5
"""Width by height of the mean panel, where the pictures do not ask for another."""
_LIKE = 0.25
"""Heights are alike if the natural logarithm of their quotient is below this."""


def strip_of(
    moments: Sequence[Moment], paper: Paper, seed: int, growth: Sequence[float]
) -> tuple[int, list[Rectangle], float]:
    """The panels of a strip, by the costs of a page: rows are single panels, and alike if their heights are.

    Returns:
        The strip's height, the panels' rectangles, and the cost without what the seed adds.
    """
    width = paper.width - 2 * paper.margin
    heights = np.arange(_STEPS * _HIGHEST + 1) * (width / _STEPS)
    chosen = _costs(moments, width, heights, growth, taste(seed, 0, len(moments), ()))
    found = _best(*chosen)
    panels, after = _costs(moments, width, heights, growth, Taste())
    cost = float(panels[np.arange(len(found)), found].sum() + after[found[:-1], found[1:]].sum())
    rectangles, top = [], paper.margin
    for steps, pause in zip(found, [0, *_pauses(moments)], strict=True):
        top += pause * paper.row_gutter
        bottom = top + round(heights[steps])
        rectangles.append(Rectangle(paper.margin, top, paper.margin + width, bottom))
        top = bottom
    return top + paper.margin, rectangles, cost


def _costs(
    moments: Sequence[Moment], width: int, heights: np.ndarray, growth: Sequence[float], taste: Taste
) -> tuple[np.ndarray, np.ndarray]:
    """The cost of each panel in each height, and of each height after each."""
    each = width * width / _USUAL
    areas = wanted_areas(moments, each, len(moments), taste) * np.asarray(growth)
    widths = np.array([1.0, width])
    panels = panel_costs(moments, areas, widths, np.maximum(heights, 1.0), taste)[:, 1]
    logarithms = np.log(np.maximum(heights, 1.0))
    apart = np.abs(logarithms[:, None] - logarithms)
    return panels, taste.monotony * np.maximum(0.0, 1 - apart / _LIKE)


def _best(panels: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The number of each panel's height, of those that cost least together."""
    cost, before = panels[0], []
    for panel in panels[1:]:
        all_of_them = cost[:, None] + after
        before.append(all_of_them.argmin(axis=0))
        cost = all_of_them.min(axis=0) + panel
    found = [int(cost.argmin())]
    for each in before[::-1]:
        found.append(int(each[found[-1]]))
    return np.array(found[::-1])


def _pauses(moments: Sequence[Moment]) -> list[int]:
    """Gutters between each two panels: more where more time passes, and most where a scene ends."""
    pairs = list(zip(moments, moments[1:], strict=False))
    gaps = [float(after.time - before.time) for before, after in pairs]
    usual = float(np.median(gaps)) if gaps else 0.0
    return [
        1 + (gap > usual) + (gap > usual and before.scene != after.scene)
        for gap, (before, after) in zip(gaps, pairs, strict=True)
    ]
