"""Tells letters from other thin strokes: by size, by contrast, and by the letters beside them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.sampling import percentiles

MIN_COVERAGE = 0.3
"""Coverage from which a pixel belongs to a stroke."""
HEIGHT_RATIO_RANGE, MAX_LENGTH_RATIO = (0.6, 6.0), 25
"""Height of a letter, at least and at most, and longest side of a joined word, at most, relative to the width
of strokes that count as thin."""
MIN_CONTRAST_RATIO = 0.5
"""Contrast of a letter relative to that of the strongest letters of its group, at least."""
MAX_THICK_SHARE = 0.1
"""Share of the outline of a letter that may touch something dark that is wider than strokes."""
GAP_RATIO = 1.2
"""Gap between letters of a group, at most, in the same way."""
WORD_GAP_RATIO = 4
"""Distance from such a group within which all strokes of its contrast belong to it, in the same way."""
MAX_WORD_LETTERS, SPACED_GAP_RATIO = 12, 8
"""Letters of a spaced word that are added to a group one after the other, at most; and their distance, in the
same way."""
MIN_WORD_SHARE = 0.75
"""Share of the strokes of a word that are found, at least."""
MIN_LETTERS, MAX_HEIGHT_FACTOR, MIN_SIMILAR_SHARE = 4, 2.0, 0.6
"""Letters in a group, at least; how many times the median height counts as similar;
and share of similar ones, at least."""
MIN_LINE_SHARE, LINE_LENGTH_FACTOR, LINE_OFFSET_FACTOR = 0.3, 8, 0.35
"""Share of letters with two others on their line, at least, across or down; and how far letters of a line are
from each other along it and across it, at most, relative to their median height. Leaves form no lines."""
MAX_COMPARED_LETTERS = 400
"""Letters of a group that are searched for lines, at most: those at the top."""
MAX_WIDTH_VARIATION = 0.3
"""Standard deviation of the widths of strokes in a group relative to their mean, at most: a pen has one."""
MAX_SLENDERNESS_RATIO, MAX_SLENDER_SHARE = 5, 0.5
"""Height of a part relative to its mean width from which it is slender, as `l` and blades of grass are; and
share of slender letters in a group, at most."""
FULLNESS_PERCENTILE, MIN_FULLNESS_RATIO = 75, 0.88
"""Percentile over the letters of a group of their area relative to diagonal times greatest width, at least.

Blades of grass taper, and have 0.65 to 0.85; print and handwriting have 0.99 to 1.34.
"""


class _Parts(NamedTuple):
    """The connected parts of a mask.

    Attributes:
        labels: number of the part of each pixel, H x W int32; 0 outside.
        sizes: width, height and area of each part, N x 3; of the first one, the outside, 0.
        centers: of each part, N x 2 float64, across and down.
    """

    labels: np.ndarray
    sizes: np.ndarray
    centers: np.ndarray

    def means(self, plane: np.ndarray) -> np.ndarray:
        """Return the mean of a plane, H x W, in each part."""
        total = np.bincount(self.labels.ravel(), plane.ravel(), len(self.sizes))
        return total / np.maximum(self.sizes[:, 2], 1)

    def widths(self, mask: np.ndarray) -> np.ndarray:
        """Return half the width of each part of `mask` where it is widest, float32; 0 for other parts."""
        widths, (rows, columns) = np.zeros(len(self.sizes), np.float32), np.nonzero(mask)
        distances = cv2.distanceTransform(mask, cv2.DIST_L2, 3)
        np.maximum.at(widths, self.labels[rows, columns].astype(np.intp), distances[rows, columns])
        return widths


def letter_mask(
    coverage: np.ndarray,
    strokes: np.ndarray,
    contrast: np.ndarray,
    wide: Callable[[], np.ndarray],
    thickness: int,
) -> np.ndarray | None:
    """Return which strokes are letters: H x W bool; None if no strokes are.

    Args:
        coverage: by strokes of writing, H x W float32, 0..1.
        strokes: coverage by any strokes, in the same way.
        contrast: of strokes to their ground, H x W uint8.
        wide: returns where something wider than strokes has their tone, H x W uint8, 0 or 255.
        thickness: width of strokes that count as thin, in pixels.
    """
    parts = _parts((coverage >= MIN_COVERAGE).astype(np.uint8))
    least, possible = _sizes(parts, thickness)
    if np.count_nonzero(least & possible) < MIN_LETTERS:
        return None
    thin = parts.means(cv2.dilate(wide(), np.ones((3, 3), np.uint8)) > 0) <= MAX_THICK_SHARE
    letters, strength = thin & least & possible, parts.means(contrast)
    if np.count_nonzero(letters) < MIN_LETTERS:
        return None
    limits = _least_strengths(parts, letters, strength, thickness)
    if not limits.any():
        return None
    strong = (strokes >= MIN_COVERAGE) & (contrast >= limits[limits > 0].min())
    # Dots, accents, broken strokes and short words belong to the letters beside them.
    limits = _spread(limits, parts, letters, strength, thickness)
    limit = parts.means(cv2.dilate(limits[parts.labels], _square(WORD_GAP_RATIO * thickness)))
    kept = (thin & possible & (limit > 0) & (strength >= limit))[parts.labels]
    kept &= _whole_words(kept, strong, thickness)
    return cv2.dilate(kept.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0


def _spread(
    limits: np.ndarray, parts: _Parts, letters: np.ndarray, strength: np.ndarray, thickness: int
) -> np.ndarray:
    """Return limits for the letters of spaced words too, one after the other, from a letter with a limit."""
    for _ in range(MAX_WORD_LETTERS):
        near = cv2.dilate(limits[parts.labels], _square(SPACED_GAP_RATIO * thickness))
        limit = limits.max() * (parts.means(near) > 0)
        found = letters & (limits == 0) & (limit > 0) & (strength >= limit)
        if not found.any():
            break
        limits = np.where(found, limit, limits).astype(np.float32)
    return limits


def _whole_words(kept: np.ndarray, strokes: np.ndarray, thickness: int) -> np.ndarray:
    """Return where most strokes of a word are kept, H x W bool: a word is drawn as a whole, or not at all.

    Args:
        kept: which pixels belong to letters.
        strokes: which pixels belong to any strokes of the contrast of letters.
        thickness: see `letter_mask`.
    """
    every = kept | strokes
    _, words = cv2.connectedComponents(cv2.dilate(every.astype(np.uint8), _square(GAP_RATIO * thickness)))
    total, found = (np.bincount(words[each], minlength=words.max() + 1) for each in (every, kept))
    return (found >= MIN_WORD_SHARE * total)[words]


def _sizes(parts: _Parts, thickness: int) -> tuple[np.ndarray, np.ndarray]:
    """Return which parts are high enough for a letter alone, and which are small enough."""
    width, height, _ = parts.sizes.T
    low, high = (each * thickness for each in HEIGHT_RATIO_RANGE)
    shorter, longer = np.minimum(width, height), np.maximum(width, height)
    return longer >= low, (shorter <= high) & (longer <= MAX_LENGTH_RATIO * thickness)


def _least_strengths(parts: _Parts, letters: np.ndarray, strength: np.ndarray, thickness: int) -> np.ndarray:
    """Return the contrast from which strokes belong to the group of each letter, float32; 0 without a group.

    A group has several letters of similar height and contrast.
    """
    mask = letters[parts.labels].astype(np.uint8)
    widths = parts.widths(mask)
    _, groups = cv2.connectedComponents(cv2.dilate(mask, _square(GAP_RATIO * thickness)))
    rows, columns = np.nonzero(mask)
    group_of = np.zeros(len(letters), np.int64)
    group_of[parts.labels[rows, columns]] = groups[rows, columns]
    limits = np.zeros(len(letters), np.float32)
    for group in range(1, groups.max() + 1):
        members = np.flatnonzero(letters & (group_of == group))
        limit = (
            MIN_CONTRAST_RATIO * np.float32(percentiles(strength[members], (80,))[0]) if members.size else 0
        )
        members = members[strength[members] >= limit]
        heights = parts.sizes[members, 1]
        if members.size < MIN_LETTERS or _is_grass(parts.sizes[members], widths[members]):
            continue
        if _is_one_hand(widths[members]) and _has_lines(parts.centers[members], heights):
            limits[members] = limit
    # Beside print, grain of the paper looks like pale letters.
    return np.where(limits >= MIN_CONTRAST_RATIO * limits.max(), limits, np.float32(0))


def _is_grass(sizes: np.ndarray, half_widths: np.ndarray) -> bool:
    """Return whether most strokes of a group are slender or taper, see `_Parts` and `MIN_FULLNESS_RATIO`."""
    across, heights, areas = sizes.T
    slender = heights**2 > MAX_SLENDERNESS_RATIO * areas
    fullness = percentiles(areas / (2 * half_widths * np.hypot(across, heights)), (FULLNESS_PERCENTILE,))[0]
    return bool(slender.mean() > MAX_SLENDER_SHARE or fullness < MIN_FULLNESS_RATIO)


def _is_one_hand(widths: np.ndarray) -> bool:
    return bool(widths.std() <= MAX_WIDTH_VARIATION * widths.mean())


def _has_lines(centers: np.ndarray, heights: np.ndarray) -> bool:
    """Return whether letters of similar height form lines, across or down."""
    ratio = heights / np.median(heights)
    similar = (ratio <= MAX_HEIGHT_FACTOR) & (ratio >= 1 / MAX_HEIGHT_FACTOR)
    if similar.mean() < MIN_SIMILAR_SHARE:
        return False
    centers = centers[:MAX_COMPARED_LETTERS]
    across, down = np.abs(centers[:, None] - centers).transpose(2, 0, 1) / np.median(heights)
    on_line = (
        (along <= LINE_LENGTH_FACTOR) & (aside <= LINE_OFFSET_FACTOR)
        for along, aside in ((across, down), (down, across))
    )
    return any(np.mean(each.sum(axis=1) > 2) >= MIN_LINE_SHARE for each in on_line)


def _parts(mask: np.ndarray) -> _Parts:
    _, labels, found, centers = cv2.connectedComponentsWithStats(mask)
    sizes = found[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT, cv2.CC_STAT_AREA]]
    sizes[0] = 0
    return _Parts(labels, sizes, centers)


def _square(side: float) -> np.ndarray:
    length = max(1, 2 * int(side / 2) + 1)
    return np.ones((length, length), np.uint8)
