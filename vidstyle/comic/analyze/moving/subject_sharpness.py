"""Sharpness of what moves, compared with the same subject in other frames: the rest may be still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

import cv2
import numpy as np

from vidstyle.comic.analyze.edges import edge_width_sharpness
from vidstyle.comic.analyze.features import Candidate

_STRONG_EDGE_SHARE = 0.15
"""Share of the cells of a subject, those with the strongest edges, on which its sharpness is measured."""
_MIN_CELLS, _MIN_MOVER_RATIO = 6, 0.3
"""Number of cells from which the sharpness of a mover is known, and minimum area relative to the largest."""
_SHARP_PERCENTILE = 85
"""Percentile of the sharpness of a subject in its shot, or near a frame, that is called sharp."""
_MIN_COMPARED = 4
"""Number of frames from which they can be compared."""
_SMEARED_RATIO = 0.7
"""Fraction of this sharpness below which a subject is smeared.

It comes from two films only, one of animals and one of figures before a plain wall. In 120 of their frames,
which were looked at, smeared subjects have up to 0.75 of the sharpness that others have, turned ones from 0.8
on. The value is below both, as the limit of other films is not known.
"""


def subject_sharpness(candidate: Candidate) -> float | None:
    """Return the sharpness of the moving subject of a frame, 0..1; None if it is not known.

    Of several movers, the least sharp one counts.
    """
    edges, action = candidate.edges, candidate.action
    if edges is None or action is None or action.is_gone:
        return None
    size = edges.shape[:1:-1]
    inside = cv2.resize(action.places.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    inside = cv2.dilate(inside, np.ones((3, 3), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(inside)
    areas = stats[1:, cv2.CC_STAT_AREA]
    least = max(_MIN_CELLS, _MIN_MOVER_RATIO * areas.max(initial=0))
    movers = [labels == number for number, area in enumerate(areas, start=1) if area >= least]
    return min((_sharpness_inside(edges, mover) for mover in movers), default=None)


def _sharpness_inside(edges: np.ndarray, inside: np.ndarray) -> float:
    fine, coarse = (list(slopes[:, inside].astype(np.float32)) for slopes in edges)
    return edge_width_sharpness(fine, coarse, _STRONG_EDGE_SHARE)


def compare_subjects(candidates: Sequence[Candidate]) -> tuple[list[Candidate], dict[int, float]]:
    """Compare the moving subject of each candidate with the sharp ones of its scene.

    Returns:
        The candidates, see `compare_subject`, and the sharpness of the sharp ones of each scene.
    """
    scenes = groupby(candidates, key=lambda each: each.scene)
    sharpest = {scene: _sharpest_subject(list(shot)) for scene, shot in scenes}
    return [compare_subject(each, sharpest[each.scene]) for each in candidates], sharpest


def _sharpest_subject(shot: Sequence[Candidate]) -> float:
    """Return the sharpness of the moving subject in the sharp frames of a scene; 0 if it is not known."""
    found = [subject_sharpness(each) for each in shot if each.action is not None and not each.is_flawed]
    known = [each for each in found if each is not None]
    return float(np.percentile(known, _SHARP_PERCENTILE)) if len(known) >= _MIN_COMPARED else 0.0


def compare_subject(candidate: Candidate, sharpest: float) -> Candidate:
    """Return a frame with the relative sharpness of its moving subject, marked as blurred if that is smeared.

    Its edges, which take more memory than its other features, are dropped.

    `sharpest`: of the sharp frames of its scene; 0 if it is not known.
    """
    own = subject_sharpness(candidate) if candidate.action is not None and sharpest > 0 else None
    ratio = 1.0 if own is None else min(1.0, own / sharpest)
    is_blurred = candidate.blurred or ratio < _SMEARED_RATIO
    return replace(candidate, sharp_subject=ratio, blurred=is_blurred, edges=None)
