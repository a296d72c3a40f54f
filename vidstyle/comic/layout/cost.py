"""The cost function that page layouts minimize."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import content_box, least_window_ratio, main_face, required_box
from vidstyle.comic.layout.weights import LayoutWeights
from vidstyle.regions.boxes import Box

# The shape of panels.
MIN_PANEL_ASPECT, MAX_PANEL_ASPECT = 0.45, 3.2
"""Range of the aspect ratio (width / height) of panels; others are slivers."""
_ASPECT_SAFETY_FACTOR = 1.02
"""Safety factor on these limits, as sides are later rounded to whole pixels."""
_SLIVER_COST = 4.0
"""Cost of a sliver; ten times the square of its excess is added."""
_PICTURE_SHAPE_WEIGHT, _NEAR_PICTURE_SHAPE_WEIGHT = 0.8, 0.25
"""Weight of the picture's shape in the best shape; the rest is the shape of its main content.

The second value is for a close-up of a face.
"""

# The size of panels.
_MIN_IMPORTANCE_DEVIATION = 0.08
"""Minimum standard deviation of importance assumed."""
_AREA_LOG_FACTOR = 0.5
"""Logarithm of the factor on the wanted area per standard deviation of importance."""
_MIN_SPLASH_DEVIATIONS = 1.6
"""Standard deviations above the mean from which the most important key frame is a splash."""
_MIN_SPLASH_LEAD_DEVIATIONS = 0.4
"""Standard deviations by which a splash must also exceed the next key frame."""
_SPLASH_PAGE_SHARE = 0.36
"""Wanted share of a page for a splash."""
_SPLASH_SIZE_WEIGHT = 3.0
"""Factor on the weight of a splash's size."""

# The content of panels.
_FREE_CROP_LOG_RATIO = 0.5
"""Difference of the logarithms of the aspects of a panel and its picture up to which cropping is free."""
_CROP_WEIGHT = 3.0
"""Weight of the square of its excess."""
_LOST_FACE_COST, _MAX_LOST_FACE_SHARE = 3.0, 0.02
"""Cost of a panel that must cut large faces or the subject, and the lost share of them that is ignored."""


def wanted_areas(
    key_frames: Sequence[KeyFrame], paper_area: float, pages: float, weights: LayoutWeights
) -> np.ndarray:
    """Return the wanted area of each key frame in square pixels, on pages of `paper_area` each.

    A key frame that stands out among at least four is a splash and gets a large share of a page.
    """
    above = deviations(key_frames)
    main = int(above.argmax())
    if weights.jitter is not None:
        above = above + weights.jitter[:, 0]
        # In every variation the most important key frame stays the largest.
        above[main] = above.max()
    shares = np.exp(_AREA_LOG_FACTOR * np.clip(above, -2.0, 2.0))
    areas = shares / shares.sum() * paper_area * pages
    top = find_splash(key_frames)
    if top is not None:
        areas[top] = max(areas[top], _SPLASH_PAGE_SHARE * paper_area)
    return areas


def deviations(key_frames: Sequence[KeyFrame]) -> np.ndarray:
    """Return each key frame's importance above the mean, in standard deviations."""
    importance = np.array([key_frame.importance for key_frame in key_frames])
    return (importance - importance.mean()) / max(float(importance.std()), _MIN_IMPORTANCE_DEVIATION)


def find_splash(key_frames: Sequence[KeyFrame]) -> int | None:
    """Return the index of the key frame that stands out among at least four, or None."""
    above = deviations(key_frames)
    top = int(above.argmax())
    if len(key_frames) < 4 or above[top] < max(
        _MIN_SPLASH_DEVIATIONS, np.delete(above, top).max() + _MIN_SPLASH_LEAD_DEVIATIONS
    ):
        return None
    return top


def panel_costs(
    key_frames: Sequence[KeyFrame],
    areas: np.ndarray,
    widths: np.ndarray,
    heights: np.ndarray,
    weights: LayoutWeights,
) -> np.ndarray:
    """Return the cost of the panel of each key frame in each size.

    Returns:
        Key frame x width x height; infinite for the first width and the first height, which are 0.
    """
    aspect, area = widths[:, None] / heights, widths[:, None] * heights
    shapes = np.zeros(len(key_frames)) if weights.jitter is None else weights.jitter[:, 1]
    size = np.full(len(key_frames), weights.size)
    top = find_splash(key_frames)
    if top is not None:
        size[top] *= _SPLASH_SIZE_WEIGHT
    costs = np.stack(
        [
            weights.shape * (np.log(aspect) - best_shape(key_frame) - shape) ** 2
            + counts * np.log(area / wanted) ** 2
            + minor * np.maximum(0.0, np.log(area / wanted)) ** 2
            + _content_cost(key_frame, aspect, weights)
            + weights.small * _face_shortfall(key_frame, aspect, heights, weights.face_px) ** 2
            for key_frame, wanted, counts, minor, shape in zip(
                key_frames, areas, size, _oversize_weights(key_frames, weights), shapes, strict=True
            )
        ]
    )
    over = np.maximum(
        np.log(aspect * _ASPECT_SAFETY_FACTOR / MAX_PANEL_ASPECT),
        np.log(MIN_PANEL_ASPECT * _ASPECT_SAFETY_FACTOR / aspect),
    )
    costs += np.where(over > 0, _SLIVER_COST + 10 * over**2, 0.0)
    costs[:, 0], costs[:, :, 0] = np.inf, np.inf
    return costs


def _oversize_weights(key_frames: Sequence[KeyFrame], weights: LayoutWeights) -> np.ndarray:
    """Return the additional weight of an area above the wanted one: unimportant panels stay small.

    So do places next to people or movers. If there are only places, the first one may be large.
    """
    found = weights.oversize * np.clip(-deviations(key_frames), 0.0, 1.0)
    has_figure = np.array([bool(each.faces) or each.subject is not None for each in key_frames])
    if has_figure.any():
        found[~has_figure] = weights.oversize
    else:
        found[0] = 0.0
    return found


def best_shape(key_frame: KeyFrame) -> float:
    """Return the natural logarithm of the best aspect ratio for a key frame."""
    height, width = key_frame.shape
    kept = content_box(key_frame)
    own = math.log(width / height)
    inner = math.log(max(kept.width, 1.0) / max(kept.height, 1.0))
    share = (
        _NEAR_PICTURE_SHAPE_WEIGHT
        if key_frame.framing == "near" and key_frame.faces
        else _PICTURE_SHAPE_WEIGHT
    )
    return share * own + (1 - share) * min(own + 1.5, max(own - 1.5, inner))


def _face_shortfall(
    key_frame: KeyFrame, aspect: np.ndarray, heights: np.ndarray, wanted: float
) -> np.ndarray | float:
    """Return the logarithm of the wanted height of the main face over its height in each panel, or 0.

    The panel may show as little as `crop` allows around the large faces.
    """
    face = main_face(key_frame)
    if face is None or not wanted:
        return 0.0
    height, width = key_frame.shape
    down = np.minimum(height, width / np.maximum(aspect, 1e-6))
    kept = required_box(key_frame)
    least = np.maximum(kept.height, kept.width / np.maximum(aspect, 1e-6))
    shown = np.minimum(down, np.maximum(least, least_window_ratio(key_frame) * down))
    return np.log(np.maximum(1.0, wanted * shown / np.maximum(face.height * heights, 1e-6)))


def _content_cost(key_frame: KeyFrame, aspect: np.ndarray, weights: LayoutWeights) -> np.ndarray:
    """Return the cost of the content that a window of an aspect cannot show."""
    height, width = key_frame.shape
    across = np.minimum(width, height * aspect)
    down = across / aspect

    def lost(box: Box) -> np.ndarray:
        shown = np.minimum(1, across / max(box.width, 1.0)) * np.minimum(1, down / max(box.height, 1.0))
        return 1 - shown

    kept = required_box(key_frame)
    cropped = np.maximum(0, np.abs(np.log(aspect * height / width)) - _FREE_CROP_LOG_RATIO) ** 2
    cost = _CROP_WEIGHT * cropped * (key_frame.framing != "near") + weights.saliency * lost(
        key_frame.saliency.union(kept)
    )
    if main_face(key_frame) is None and key_frame.subject is None:
        return cost
    return cost + weights.face * lost(kept) + _LOST_FACE_COST * (lost(kept) > _MAX_LOST_FACE_SHARE)
