"""Layers of ink, light and even ground that show features of a face, in the medium of a style."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.screens import screened
from vidstyle.regions.features.tones import MAX_SPECK_PX, SPECK_RATIO, in_steps, without_specks
from vidstyle.regions.patches import plane_area
from vidstyle.regions.rasters import PageRaster

CORE_RANGE = 0.45, 0.95
"""Darkness at which a pixel begins to be ink, and from which it is, relative to the strongest nearby."""
CORE_WEIGHT = 0.7
"""Opacity of ink over tones."""
FULL_INK_WEIGHT = 0.33
"""Weight of features from which strokes are full ink: line drawings have no gray."""
LIGHT_WEIGHT = 0.8
"""Opacity of whites of eyes and teeth between lines."""
SKIN_WEIGHT = 0.45
"""How far dots and hatching on lit skin are replaced: the rest shows the medium."""
SHADE_FACTOR, INK_SHADE_FACTOR = 1.5, 2.3
"""Factors of shade between light lines; and in hatching or dots, which leave paper between them."""
INK_WEIGHT = 0.95
"""Opacity of ink without tones."""
SKIN_LIGHT_SHARE, SKIN_LIGHT_WEIGHT = 0.5, 0.8
"""How much of lit skin between light lines is hatched, and the opacity of this hatching: it must stay behind
the lines."""
SKIN_SHADE_WEIGHT = 0.5
"""How much darker features are between light lines."""
CLEAR_WEIGHT = 0.5
"""How far scan lines are cleared under features."""


class FeatureMarks(NamedTuple):
    """Layers over the page, H x W float32, in this order: a factor, and coverage.

    Attributes:
        factor: of the page; None: 1.
        clear: coverage by even ground.
        bright: coverage by the brightest colour of the page, paper or light.
        ink: coverage by the ink of the style.
    """

    factor: np.ndarray | None
    clear: np.ndarray
    bright: np.ndarray
    ink: np.ndarray


def marks_of(
    each: Features,
    medium: Medium,
    is_light: bool,
    page: Picture,
    region: np.ndarray | None,
    raster: PageRaster,
) -> FeatureMarks:
    """Return the layers over the page for the features of a face.

    Args:
        is_light: whether the ink has the colour of light lines.
    """
    weight, skin = each.weight, each.skin
    if region is not None:
        weight, skin = (plane * region[plane_area(each.window, (1, 1))] for plane in (weight, skin))
    tones, none = each.tones, np.zeros_like(weight)
    cover = np.minimum(weight / np.float32(FULL_INK_WEIGHT), 1)
    change = weight * (tones.tone - 1)
    paper = np.float32(LIGHT_WEIGHT) * weight * tones.light
    match medium:
        case Medium.LIGHT_LINES:
            shade = in_steps(np.float32(SHADE_FACTOR) * cover * (1 - tones.tone * tones.shade))
            light = np.float32(SKIN_LIGHT_SHARE) * skin * (1 - shade)
            light = screened(light, each.window, each.face.box.height, is_dotted=False)
            light = np.maximum(np.float32(SKIN_LIGHT_WEIGHT) * light, paper)
            factor = 1 - np.float32(SKIN_SHADE_WEIGHT) * np.minimum(shade, skin)
            bright, ink = (none, light) if is_light else (light, none)
            return FeatureMarks(factor, none, bright, ink)
        case Medium.INK_OVER_TONES:
            return FeatureMarks(1 + change, none, none, np.float32(CORE_WEIGHT) * cover * _core(each))
        case Medium.INK:
            shade = in_steps(np.float32(INK_SHADE_FACTOR) * weight * (1 - tones.tone * tones.shade))
            shade = screened(shade, each.window, each.face.box.height, is_dotted=raster.has_dots)
            ink = np.maximum(shade, np.float32(INK_WEIGHT) * cover * _core(each))
            return FeatureMarks(None, np.float32(SKIN_WEIGHT) * np.minimum(weight, skin), paper, ink)
    clear = np.float32(CLEAR_WEIGHT) * weight if raster.waves else none
    return FeatureMarks(1 + change, clear, none, none)


def _core(each: Features) -> np.ndarray:
    """Return coverage by ink in the darkest parts, without specks."""
    least = min(SPECK_RATIO * each.face.box.height, MAX_SPECK_PX)
    return without_specks(_ramp(each.tones.dark, CORE_RANGE), least)


def _ramp(plane: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    low, high = map(np.float32, ends)
    return np.clip((plane - low) / (high - low), 0, 1)
