"""Layers of ink, light and even ground that show features of a face, in the medium of a style."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vidstyle.regions.features.blurring import enlarged, resized
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.media import Medium
from vidstyle.regions.features.screens import screened
from vidstyle.regions.features.tones import MAX_SPECK_PX, SPECK_RATIO, in_steps, without_specks
from vidstyle.regions.patches import plane_area
from vidstyle.regions.rasters import PageRaster

CORE_RANGE = 0.15, 0.5
"""Darkness at which a pixel begins to be ink, and from which it is, relative to the strongest nearby."""
CORE_WEIGHT = 0.7
"""Opacity of ink over tones."""
FULL_INK_WEIGHT = 0.33
"""Weight of features from which strokes are full ink: line drawings have no gray."""
LIGHT_WEIGHT = 0.8
"""Opacity of whites of eyes and teeth between lines."""
SKIN_WEIGHT = 0.45
"""How far dots and hatching on lit skin are replaced: the rest shows the medium."""
SHADE_FACTOR, INK_SHADE_FACTOR = 1.5, 3.0
"""Factors of shade between light lines; and in hatching or dots, which leave paper between them."""
MAX_INK_SHADE = 0.5
"""Most ink in the shade of a face: only features are solid."""
INK_WEIGHT = 0.95
"""Opacity of ink without tones."""
SKIN_LIGHT_SHARE, SKIN_LIGHT_WEIGHT = 0.5, 0.8
"""How much of lit skin between light lines is hatched, and the opacity of this hatching: it must stay behind
the lines."""
SKIN_SHADE_WEIGHT = 0.5
"""How much darker features are between light lines."""
MIN_SKIN_CONTRAST, MAX_LIGHT_FACTOR = 0.32, 3.0
"""Mean luma of lit skin in tones above the page's darkest colour, below which a face gets light, and the
largest factor: features cannot be darker than this colour. Tuned on 20 faces in neon, blueprint and noir."""
BRIGHT_LUMA_RANGE = 0.3, 0.6
"""Luma of what gets less light, and of what gets none, such as glowing tubes."""
CLEAR_WEIGHT = 0.5
"""How far scan lines are cleared under features."""


class FeatureMarks(NamedTuple):
    """Layers over the page, H x W float32 or None, in this order: coverage, factors, and coverage.

    Attributes:
        clear: coverage by even ground.
        light: factor that lights a dark face.
        factor: factor that darkens features, towards the darkest colour.
        bright: coverage by the brightest colour of the page, paper or light.
        ink: coverage by the ink of the style.
    """

    clear: np.ndarray | None = None
    light: np.ndarray | None = None
    factor: np.ndarray | None = None
    bright: np.ndarray | None = None
    ink: np.ndarray | None = None


def marks_of(
    each: Features,
    medium: Medium,
    is_light: bool,
    luma: np.ndarray,
    darkest: float,
    region: np.ndarray | None,
    raster: PageRaster,
) -> FeatureMarks:
    """Return the layers over the page for the features of a face.

    Args:
        each: the features.
        medium: how the style draws.
        is_light: whether the ink has the colour of light lines.
        luma: of the page in the window of the features, H x W float32, 0..1.
        darkest: luma of the page's darkest colour.
        region: where the style applies, H x W float32, 0..1; None: everywhere.
        raster: dots, squares and lines of the style.
    """
    weight, skin, shape = each.weight, each.skin, (each.window.height, each.window.width)
    if region is not None:
        applied = resized(region[plane_area(each.window, (1, 1))], weight.shape)
        weight, skin = weight * applied, skin * applied
    tones = each.tones
    cover = np.minimum(weight / np.float32(FULL_INK_WEIGHT), 1)
    change = weight * (tones.tone - 1)
    paper = np.float32(LIGHT_WEIGHT) * weight * tones.light
    match medium:
        case Medium.LIGHT_LINES:
            shade = in_steps(np.float32(SHADE_FACTOR) * cover * (1 - tones.tone * tones.shade))
            light = np.float32(SKIN_LIGHT_SHARE) * skin * (1 - shade)
            light = screened(enlarged(light, shape), each.window, each.face.box.height, is_dotted=False)
            light = np.maximum(np.float32(SKIN_LIGHT_WEIGHT) * light, enlarged(paper, shape))
            factor = 1 - np.float32(SKIN_SHADE_WEIGHT) * np.minimum(shade, skin)
            return FeatureMarks(factor=factor, **{"ink" if is_light else "bright": light})
        case Medium.INK_OVER_TONES:
            return FeatureMarks(factor=1 + change, ink=np.float32(CORE_WEIGHT) * cover * _core(each))
        case Medium.INK:
            shade = np.minimum(np.float32(INK_SHADE_FACTOR) * (1 - tones.soft), np.float32(MAX_INK_SHADE))
            shade = in_steps(weight * shade)
            shade = screened(
                enlarged(shade, shape), each.window, each.face.box.height, is_dotted=raster.has_dots
            )
            ink = np.maximum(shade, enlarged(np.float32(INK_WEIGHT) * cover * _core(each), shape))
            clear = np.float32(SKIN_WEIGHT) * np.minimum(weight, skin)
            return FeatureMarks(clear, bright=paper, ink=ink)
    clear = np.float32(CLEAR_WEIGHT) * weight if raster.waves else None
    return FeatureMarks(clear, _light(resized(luma, skin.shape), skin, darkest), 1 + change)


def _light(luma: np.ndarray, skin: np.ndarray, darkest: float) -> np.ndarray | None:
    """Return the factor that makes dark skin of a page light enough for features; None if it is."""
    area = float(skin.sum())
    mean = float((luma * skin).sum()) / area if area else 1.0
    factor = min(MAX_LIGHT_FACTOR, (darkest + MIN_SKIN_CONTRAST) / max(mean, 1e-3))
    return 1 + np.float32(factor - 1) * skin * (1 - _ramp(luma, BRIGHT_LUMA_RANGE)) if factor > 1 else None


def _core(each: Features) -> np.ndarray:
    """Return coverage by ink in the darkest parts, without specks."""
    least = min(SPECK_RATIO * each.face.box.height, MAX_SPECK_PX) * each.weight.shape[0] / each.window.height
    return without_specks(_ramp(each.tones.dark, CORE_RANGE), least)


def _ramp(plane: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    low, high = map(np.float32, ends)
    return np.clip((plane - low) / (high - low), 0, 1)
