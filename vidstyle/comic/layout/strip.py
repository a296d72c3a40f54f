"""A strip for phones: one column of panels, with heights and pauses that vary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.cost import panel_costs, wanted_areas
from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.layout.weights import LayoutWeights, perturb_weights
from vidstyle.regions.boxes import Rectangle

# The size of panels.
_HEIGHT_STEPS_PER_WIDTH = 24
"""Heights are multiples of the width divided by this number."""
_MAX_HEIGHT_RATIO = 2
"""Maximum height, relative to the width."""
_MEAN_PANEL_ASPECT = 1.5
"""Width divided by height of the average panel."""
_SIMILAR_HEIGHT_LOG_RATIO = 0.25
"""Heights are similar if the logarithm of their ratio is below this."""

# Variety.
_MAX_PAUSE_GUTTERS = 3
"""Maximum pause between panels."""
_INSET_WIDTH_RATIO = 0.72
"""Width of an inset panel, relative to the strip."""
_INSET_COST, _REPEATED_INSET_COST = 1.0, 0.6
"""Cost of an inset panel, and additional cost of another one right after it."""
_MAX_PERTURBATION_COST = 3.0
"""Maximum that a seed subtracts from the cost of an inset panel."""


def lay_out_strip(
    key_frames: Sequence[KeyFrame], paper: Paper, seed: int, area_scales: Sequence[float]
) -> tuple[int, list[Rectangle], float]:
    """Return the panels of a strip, by the costs of a page with one panel in each row.

    Seeds vary which panels are inset, from alternating sides, and the pauses between panels.

    Returns:
        The strip's height, the panels' rectangles, and the cost without perturbation.
    """
    width = paper.width - 2 * paper.margin
    weights, heights = LayoutWeights(oversize=0.0), np.tile(_heights(width), 2)
    is_inset = np.arange(len(heights)) >= len(heights) // 2
    logarithms = np.log(np.maximum(heights, 1.0))
    apart = np.abs(logarithms[:, None] - logarithms)
    after = weights.monotony * np.maximum(
        0.0, 1 - apart / _SIMILAR_HEIGHT_LOG_RATIO
    ) + _REPEATED_INSET_COST * (is_inset[:, None] & is_inset)
    panels = _panel_costs(key_frames, width, area_scales, weights)
    perturbed = replace(perturb_weights(seed, 0, len(key_frames), ()), oversize=0.0)
    chosen = _panel_costs(key_frames, width, area_scales, perturbed)
    random = np.random.default_rng((seed, len(key_frames)))
    perturbation = (
        _MAX_PERTURBATION_COST * random.random((len(key_frames), 1)) ** 2 * is_inset if seed else 0.0
    )
    found = _choose_sizes(chosen - perturbation, after)
    cost = float(panels[np.arange(len(found)), found].sum() + after[found[:-1], found[1:]].sum())
    rectangles, top = [], paper.margin
    aside = bool(random.integers(2))
    for size, pause in zip(found, [0, *_pauses(key_frames, random if seed else None)], strict=True):
        wide, high = round(_INSET_WIDTH_RATIO * width) if is_inset[size] else width, round(heights[size])
        top += pause * paper.row_gutter
        left = paper.margin + (width - wide) * aside
        rectangles.append(Rectangle(left, top, left + wide, top + high))
        top += high
        aside ^= wide < width
    return top + paper.margin, rectangles, cost


def _panel_costs(
    key_frames: Sequence[KeyFrame], width: int, area_scales: Sequence[float], weights: LayoutWeights
) -> np.ndarray:
    """Return the cost of each panel in each size: panel x (heights at full width, then at inset width)."""
    areas = wanted_areas(
        key_frames, width * width / _MEAN_PANEL_ASPECT, len(key_frames), weights
    ) * np.asarray(area_scales)
    widths = np.array([1.0, _INSET_WIDTH_RATIO * width, width])
    grid = panel_costs(key_frames, areas, widths, np.maximum(_heights(width), 1.0), weights)
    return np.concatenate([grid[:, 2], grid[:, 1] + _INSET_COST], axis=1)


def _heights(width: int) -> np.ndarray:
    return np.arange(_HEIGHT_STEPS_PER_WIDTH * _MAX_HEIGHT_RATIO + 1) * (width / _HEIGHT_STEPS_PER_WIDTH)


def _choose_sizes(panels: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the index of each panel's size, with the lowest total cost; dynamic programming."""
    cost, before = panels[0], []
    for panel in panels[1:]:
        totals = cost[:, None] + after
        before.append(totals.argmin(axis=0))
        cost = totals.min(axis=0) + panel
    found = [int(cost.argmin())]
    for each in before[::-1]:
        found.append(int(each[found[-1]]))
    return np.array(found[::-1])


def _pauses(key_frames: Sequence[KeyFrame], random: np.random.Generator | None) -> list[int]:
    """Return the gutters between successive panels: more if more time passes, most at the end of a scene.

    Args:
        key_frames: in the order of time.
        random: lengthens some pauses by a gutter.
    """
    pairs = list(zip(key_frames, key_frames[1:], strict=False))
    gaps = [float(after.time - before.time) for before, after in pairs]
    usual = float(np.median(gaps)) if gaps else 0.0
    longer = random.integers(0, 2, len(pairs)) if random else np.zeros(len(pairs), int)
    return [
        min(_MAX_PAUSE_GUTTERS, 1 + (gap > usual) + (gap > usual and before.scene != after.scene) + int(more))
        for gap, more, (before, after) in zip(gaps, longer, pairs, strict=True)
    ]
