"""Layers over a restyled face that draw it in ink: features are solid, shade is fine hatching or dots.

Over dots of several inks, the style draws the face; eyes, nose and mouth get their shape from the source.
"""

from __future__ import annotations

import numpy as np

from vidstyle.regions.features.blurring import blurred, enlarged, weighted_mean
from vidstyle.regions.features.feature_lifting import Features
from vidstyle.regions.features.feature_marks import SOLID_RANGE, FeatureMarks
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.features.screens import ShadeScreen
from vidstyle.regions.rasters import PageRaster

MIN_SHADE, MAX_SHADE, MAX_COLORED_SHADE = 0.06, 0.85, 0.65
"""Darkness that is paper; the most ink in shade, in hatching or dots; and the same over colours, which have
shade themselves."""
EVEN_SHADE_SHARE, EVEN_FEATURE_SHARE = 0.35, 0.65
"""Share of shade that is gray, not hatched: it shows details finer than lines two pixels apart; and the same
around eyes, nose and mouth, whose form hatching would break."""
STROKE_RATIO, STROKE_RANGE = 0.04, (0.04, 0.2)
"""Standard deviation of the Gaussian, relative to the face's height, than which strokes are darker; and by
how much they are, for no ink and for full ink. Eyes are always full ink."""
MAX_BROAD_SHADE, FOLD_SHARE = 0.5, 0.65
"""Most shade of lips, beards and shadows around nose and mouth, and factor of the shade of folds beside them:
black blots turn smiles into sneers. Tuned on 16 faces of 92 to 196 lines in woodcut, ink and comic."""
GLASSES_RANGE = 0.5, 0.7
"""Darkness, averaged as for hair, from which features are in the dark, such as behind glasses."""
INK_LUMA_RANGE, COLORED_LUMA_RANGE = (0.3, 0.8), (0.05, 0.35)
"""Luma, between ink and paper, at which a mark of the style counts as ink, and from which it does not; and
the same among dots of several inks."""
HAIR_RATIO, HAIR_RANGE = 0.06, (0.35, 0.6)
"""Standard deviation of the Gaussian of darkness, relative to the face's height; and darkness after it from
which marks of the style stay, such as black hair."""
EVEN_DOTS_WEIGHT, DOTS_RATIO = 0.7, 0.06
"""How far dots of several inks are evened out around eyes, nose and mouth; and standard deviation of the
Gaussian of the paper between them, relative to the face's height: no solid shapes are evened out."""
SHARPENING_RATIO, SHARPENING_FACTOR = 0.05, 0.5
"""Standard deviation of the Gaussian, relative to the face's height, and the factor by which differences of
darkness from it are raised: the white beside an iris is in the shade of a brow."""
LIGHT_DARKNESS_RANGE, SOLID_DARKNESS_RANGE = (0.75, 0.25), (0.58, 0.92)
"""Darkness below which ink is removed, and is removed entirely; and from which ink is added, and is full. All
values over dots of several inks were tuned on 10 faces of 62 to 217 lines in comic."""
SOFT_HEIGHT_PX, MIN_SOFTNESS = 110, 0.25
"""Height of a face up to which these ranges are whole, and their width for large ones, at least: the eyes of
small faces have few pixels, which cannot be black or white."""
LIGHT_INK_SHADE_WEIGHT = 0.5
"""How much darker than the paper features are between light lines: white eyes would make a negative."""


def ink_marks(
    each: Features, weight: np.ndarray, luma: np.ndarray, ends: tuple[float, float], raster: PageRaster
) -> FeatureMarks:
    """Return the layers that draw a face in ink.

    Args:
        each: the face.
        weight: how much is drawn, H x W float32, 0..1.
        luma: of the page in its window, in the same way.
        ends: luma of ink and of paper.
        raster: dots and lines of the style.
    """
    ink, paper = ends
    luma_range = COLORED_LUMA_RANGE if raster.has_colors else INK_LUMA_RANGE
    ground = ramp((luma - np.float32(ink)) / np.float32(paper - ink or 1), luma_range)
    darkness = enlarged(each.darkness, luma.shape)
    dark = _corrections if raster.has_colors else _dark_marks
    draw = dark if ink < paper else _light_marks
    return draw(each, weight, darkness, ground, raster)


def _dark_marks(
    each: Features, weight: np.ndarray, darkness: np.ndarray, ground: np.ndarray, raster: PageRaster
) -> FeatureMarks:
    """Return the layers that draw a face in dark ink; `ground`: where the page is not inked."""
    broad = weighted_mean(darkness, weight, HAIR_RATIO * each.face.box.height)
    near = enlarged(each.areas.whole, darkness.shape) * (1 - ramp(broad, GLASSES_RANGE))
    hair = ramp(broad, HAIR_RANGE) * (1 - near)
    shade, solid = _shade_and_strokes(each, weight, darkness, near)
    if not (raster.has_dots or raster.has_points):
        # Beyond features, lines draw the face: hair, profile and chin keep their outline. Dots would cut it.
        weight = weight * enlarged(each.areas.whole, darkness.shape)
    screen = ShadeScreen(each.window, each.face.box.height, is_dotted=raster.has_dots)
    clear = (1 - ground) * (1 - hair)
    even = np.float32(EVEN_SHADE_SHARE) + np.float32(EVEN_FEATURE_SHARE - EVEN_SHADE_SHARE) * near
    shade = _hatched(np.float32(MAX_SHADE) * shade, screen, even)
    weight = _hatched(weight, screen, np.float32(EVEN_SHADE_SHARE))
    return FeatureMarks(weight * clear, ground, ink=weight * np.maximum(solid, shade))


def _corrections(
    each: Features, weight: np.ndarray, darkness: np.ndarray, ground: np.ndarray, raster: PageRaster
) -> FeatureMarks:
    """Return the layers that correct eyes, nose and mouth in dark ink; `ground`: where the page is not inked.

    Light parts have no more ink than lit skin has, and the darkest parts are full ink.
    """
    height = each.face.box.height
    core = weight * enlarged(each.areas.core, darkness.shape)
    mean = weighted_mean(darkness, weight, SHARPENING_RATIO * height)
    sharp = darkness + np.float32(SHARPENING_FACTOR) * (darkness - mean)
    softness = min(max(SOFT_HEIGHT_PX / height, MIN_SOFTNESS), 1)
    light = ramp(sharp, _narrowed(LIGHT_DARKNESS_RANGE, softness))
    dark = ramp(sharp, _narrowed(SOLID_DARKNESS_RANGE, softness))
    dots = np.float32(EVEN_DOTS_WEIGHT) * blurred(ground, DOTS_RATIO * height)
    return FeatureMarks(core * np.maximum((1 - ground) * light, dots), ground, ink=core * dark)


def _narrowed(ends: tuple[float, float], factor: float) -> tuple[float, float]:
    """Return a range with the same middle and another width."""
    middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
    return middle - factor * half, middle + factor * half


def _light_marks(
    each: Features, weight: np.ndarray, darkness: np.ndarray, ground: np.ndarray, raster: PageRaster
) -> FeatureMarks:
    """Return the layers that draw a face in light ink: skin is hatched."""
    screen = ShadeScreen(each.window, each.face.box.height, is_dotted=raster.has_dots)
    even = np.float32(1 if raster.has_colors else EVEN_SHADE_SHARE)
    most = np.float32(MAX_COLORED_SHADE if raster.has_colors else MAX_SHADE)
    shade = _hatched(most * ramp(1 - darkness, (MIN_SHADE, 1)), screen, even)
    weight = _hatched(weight, screen, np.float32(EVEN_SHADE_SHARE))
    factor = 1 - np.float32(LIGHT_INK_SHADE_WEIGHT) * weight * ramp(darkness, SOLID_RANGE)
    return FeatureMarks(weight * (1 - ground), ground, factor=factor, ink=weight * shade)


def _shade_and_strokes(
    each: Features, weight: np.ndarray, darkness: np.ndarray, near: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return shade and full ink of a face, 0..1: soft but for thin strokes and eyes; `near`: features."""
    eyes, core = (enlarged(plane, darkness.shape) for plane in (each.areas.eyes, each.areas.core))
    free = np.maximum(eyes, 1 - near)
    folds = np.maximum(near - core, 0)
    shade = ramp(darkness, (MIN_SHADE, 1)) * (1 - np.float32(1 - FOLD_SHARE) * folds)
    shade = np.minimum(shade, np.float32(MAX_BROAD_SHADE) + np.float32(1 - MAX_BROAD_SHADE) * free)
    fine = darkness - weighted_mean(darkness, weight, STROKE_RATIO * each.face.box.height)
    return shade, ramp(darkness, SOLID_RANGE) * np.maximum(eyes, ramp(fine, STROKE_RANGE))


def _hatched(cover: np.ndarray, screen: ShadeScreen, even: np.ndarray | np.float32) -> np.ndarray:
    """Return coverage in hatching or dots, but for a share `even` of it, which stays gray."""
    marks = screen.inked(cover)
    return np.asarray(marks + even * (cover - marks), np.float32)
