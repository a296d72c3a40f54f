"""A strip for phones: one column of panels, with heights and pauses that vary."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.layout.cost import LayoutWeights, panel_costs, perturbed_weights, wanted_areas
from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.moment import Moment, Rectangle

_STEPS = 24
"""Heights are multiples of this part of the width."""
_HIGHEST = 2
"""Heights by the width."""
_USUAL = 1.5
"""Width by height of the average panel."""
_LIKE = 0.25
"""Heights are similar if the logarithm of their ratio is below this."""
_LONGEST = 3
"""Maximum pause, in gutters."""
_INSET = 0.72
"""Width of an inset panel, relative to the strip."""
_INSET_COST, _AGAIN, _PERTURBATION = 1.0, 0.6, 3.0
"""Cost of an inset panel, of a further one right after it, and the most that a seed takes off."""


def lay_out_strip(
    moments: Sequence[Moment], paper: Paper, seed: int, area_scales: Sequence[float]
) -> tuple[int, list[Rectangle], float]:
    """The panels of a strip, by the costs of a page with one panel in each row.

    Seeds vary which panels are inset, from alternating sides, and the pauses between panels.

    Returns:
        The strip's height, the panels' rectangles, and the cost without perturbation.
    """
    width = paper.width - 2 * paper.margin
    weights, heights = LayoutWeights(), np.tile(_heights(width), 2)
    is_inset = np.arange(len(heights)) >= len(heights) // 2
    logarithms = np.log(np.maximum(heights, 1.0))
    apart = np.abs(logarithms[:, None] - logarithms)
    after = weights.monotony * np.maximum(0.0, 1 - apart / _LIKE) + _AGAIN * (is_inset[:, None] & is_inset)
    panels = _panel_costs(moments, width, area_scales, weights)
    chosen = _panel_costs(moments, width, area_scales, perturbed_weights(seed, 0, len(moments), ()))
    random = np.random.default_rng((seed, len(moments)))
    perturbation = _PERTURBATION * random.random((len(moments), 1)) ** 2 * is_inset if seed else 0.0
    found = _best(chosen - perturbation, after)
    cost = float(panels[np.arange(len(found)), found].sum() + after[found[:-1], found[1:]].sum())
    rectangles, top = [], paper.margin
    aside = bool(random.integers(2))
    for size, pause in zip(found, [0, *_pauses(moments, random if seed else None)], strict=True):
        wide, high = round(_INSET * width) if is_inset[size] else width, round(heights[size])
        top += pause * paper.row_gutter
        left = paper.margin + (width - wide) * aside
        rectangles.append(Rectangle(left, top, left + wide, top + high))
        top += high
        aside ^= wide < width
    return top + paper.margin, rectangles, cost


def _panel_costs(
    moments: Sequence[Moment], width: int, area_scales: Sequence[float], weights: LayoutWeights
) -> np.ndarray:
    """The cost of each panel in each size: panel x (all heights of the full width, then of the narrower)."""
    areas = wanted_areas(moments, width * width / _USUAL, len(moments), weights) * np.asarray(area_scales)
    widths = np.array([1.0, _INSET * width, width])
    grid = panel_costs(moments, areas, widths, np.maximum(_heights(width), 1.0), weights)
    return np.concatenate([grid[:, 2], grid[:, 1] + _INSET_COST], axis=1)


def _heights(width: int) -> np.ndarray:
    return np.arange(_STEPS * _HIGHEST + 1) * (width / _STEPS)


def _best(panels: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The index of each panel's size, with the lowest total cost; dynamic programming."""
    cost, before = panels[0], []
    for panel in panels[1:]:
        all_of_them = cost[:, None] + after
        before.append(all_of_them.argmin(axis=0))
        cost = all_of_them.min(axis=0) + panel
    found = [int(cost.argmin())]
    for each in before[::-1]:
        found.append(int(each[found[-1]]))
    return np.array(found[::-1])


def _pauses(moments: Sequence[Moment], random: np.random.Generator | None) -> list[int]:
    """Gutters between each two panels: more where more time passes, and most where a scene ends.

    Args:
        random: lets some pauses be longer by a gutter.
    """
    pairs = list(zip(moments, moments[1:], strict=False))
    gaps = [float(after.time - before.time) for before, after in pairs]
    usual = float(np.median(gaps)) if gaps else 0.0
    longer = random.integers(0, 2, len(pairs)) if random else np.zeros(len(pairs), int)
    return [
        min(_LONGEST, 1 + (gap > usual) + (gap > usual and before.scene != after.scene) + int(more))
        for gap, more, (before, after) in zip(gaps, longer, pairs, strict=True)
    ]
