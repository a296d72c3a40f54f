"""Layers that draw a face in ink: solid features on bare paper, and the style's own marks in the shade.

An illustrator draws a small face like this: brows, lids, nostrils and the line between the lips are black
shapes, the shade is one area of the medium's dots or lines, and nothing else is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from vidstyle.core.sampling import sampled_quantile
from vidstyle.regions.features.areas import feature_parts
from vidstyle.regions.features.blurring import enlarged
from vidstyle.regions.features.calm_skin import skin_luma
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.feature_marks import FeatureMarks
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.rasters import PageRaster, cell_means, divided_cell

MIN_DEPTH, MIN_LIGHT = 0.4, 0.25
"""Darkness relative to the skin nearby from which a pixel is ink; and the least light of that skin. All
values here were tuned on 18 faces of 47 to 240 lines in nine photographs."""
SMALL_HEIGHT_PX, MIN_DEPTH_WEIGHT = 50.0, 0.5
"""Height of a face below which this darkness is in proportion to it, as its features are blurred; at least
this share."""
EDGE_DEPTH_PX, MAX_EDGE_DEPTH = 14.0, 0.25
"""Range of this darkness in which a pixel is gray, times the face's height, and at most: about one pixel."""
STROKE_SHARE, STROKE_RATIO, MAX_PALE_FACTOR = 0.97, 0.6, 2.5
"""Quantile of this darkness in an eye, the mouth or the nose that is a stroke; its share that is ink in a
pale feature; and the largest factor of pale features."""
BARE_SHARE, MIN_DARK_FACTOR = 0.72, 0.5
"""Share of such a part that stays bare, so that an eye in the shade is no disc; and the least factor of depth
that leaves it bare."""
MIN_DARKNESS = 0.75
"""Darkness from which a pixel is ink, also in large dark shapes."""
SHADE_RANGE = 0.26, 0.3
"""Darkness of the skin up to which it is bare, and from which it has the marks of the style."""
HAIR_RANGE = 0.5, 0.56
"""The same for hair, which keeps the marks of the style next to features too."""
GAP_RATIO, MIN_GAP_PX, GAP_RANGE = 0.03, 1.0, (0.05, 0.1)
"""Standard deviation of the Gaussian of features, relative to the face's height, and the least; and the level
after it from which there are no marks of the style: in shade, features have a narrow bare edge."""
SCREEN_GAP_RATIO, MIN_SCREEN_GAP_PX, SCREEN_GAP_RANGE = 0.01, 1.4, (0.12, 0.2)
"""The same where skin has marks everywhere: a wide edge would be a mask."""
EDGE_RANGE = 0.4, 0.6
"""Weight of a face, relative to the largest, at which bare skin ends: half of a line would be gray."""
INK_LUMA_RANGE, COLORED_LUMA_RANGE = (0.6, 0.95), (0.05, 0.35)
"""Luma, between ink and paper, at which a mark of the style counts as ink, and from which it is ground; and
the same among dots of several inks."""
OUTLINE_RATIO = 0.012
"""Width of outlines in light ink, relative to the face's height."""
CELL_RATIO = 1 / 60
"""Side of the squares of features in a style of squares, relative to the face's height, at most."""


def ink_marks(
    each: Features,
    weight: np.ndarray,
    luma: np.ndarray,
    ends: tuple[float, float],
    raster: PageRaster,
    medium: Medium,
) -> FeatureMarks:
    """Return the layers that draw a face in ink.

    Args:
        each: the face.
        weight: how much is drawn, H x W float32, 0..1.
        luma: of the page in its window, in the same way.
        ends: luma of ink and of paper.
        raster: dots, lines and squares of the style.
        medium: of the style.
    """
    ink, paper = ends
    height = each.face.box.height
    solid, shade = solid_features(each, luma.shape)
    if ink > paper:
        solid = outlines(solid, height)
    most = np.float32(weight.max() or 1)
    drawn = most * ramp(weight / most, EDGE_RANGE)
    kept = _is_apart(solid, height, medium)
    if medium is Medium.INK:
        kept = kept * ramp(shade, SHADE_RANGE)
    clear, inked = drawn * (1 - np.maximum(kept, ramp(shade, HAIR_RANGE))), drawn * solid
    if raster.cell:
        cell = divided_cell(raster.cell, CELL_RATIO * height)
        clear, inked = (most * (cell_means(plane, each.window, cell) > most / 2) for plane in (clear, inked))
    luma_range = COLORED_LUMA_RANGE if raster.has_colors else INK_LUMA_RANGE
    ground = ramp((luma - np.float32(ink)) / np.float32(paper - ink or 1), luma_range)
    return FeatureMarks(clear, ground, ink=inked)


def solid_features(each: Features, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return coverage by dark features, and the darkness of the skin without them, H x W float32.

    Args:
        each: the face.
        shape: height and width of its window.
    """
    darkness, height = enlarged(each.darkness, shape), each.face.box.height
    shade = 1 - skin_luma(1 - darkness, height)
    depth = (darkness - shade) / np.maximum(1 - shade, np.float32(MIN_LIGHT))
    least = MIN_DEPTH * min(1.0, max(MIN_DEPTH_WEIGHT, height / SMALL_HEIGHT_PX))
    depth = _raised(depth, feature_parts(each.face, each.window), least)
    edge = min(MAX_EDGE_DEPTH, EDGE_DEPTH_PX / height) / 2
    ends = ((middle - edge, middle + edge) for middle in (least, MIN_DARKNESS))
    return np.maximum(*map(ramp, (depth, darkness), ends)), shade


def _raised(depth: np.ndarray, parts: Sequence[np.ndarray], least: float) -> np.ndarray:
    """Return depth where each eye, the mouth and the nose have strokes, pale lips too, and bare parts."""
    raised = depth
    for mask in parts:
        inside = depth[mask > 0.5]
        strokes, rest = (
            max(1e-3, sampled_quantile(inside, share, default=1.0)) for share in (STROKE_SHARE, BARE_SHARE)
        )
        factor = min(MAX_PALE_FACTOR, max(1.0, least / (STROKE_RATIO * strokes)))
        factor *= max(MIN_DARK_FACTOR, min(1.0, least / (factor * rest)))
        raised = raised * (1 + np.float32(factor - 1) * mask)
    return raised


def outlines(solid: np.ndarray, height: float) -> np.ndarray:
    """Return coverage by lines along the inner edges of features: thin ones are lines themselves.

    In light ink, white eyes would make a face a negative.
    """
    side = 2 * round(max(1.0, OUTLINE_RATIO * height)) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return solid - cv2.erode(solid, disc)


def _is_apart(solid: np.ndarray, height: float, medium: Medium) -> np.ndarray:
    """Return where marks of the style are far enough from features, H x W float32, 0..1."""
    ratio, least, ends = (
        (GAP_RATIO, MIN_GAP_PX, GAP_RANGE)
        if medium is Medium.INK
        else (SCREEN_GAP_RATIO, MIN_SCREEN_GAP_PX, SCREEN_GAP_RANGE)
    )
    return 1 - ramp(cv2.GaussianBlur(solid, (0, 0), max(least, ratio * height)), ends)
