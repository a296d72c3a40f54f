"""Dark and light marks of a face: what differs from the skin around, by morphological closing and opening."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.regions.features.thin_marks import (
    SHADE_EXPONENT,
    SOFTNESS_RATIO,
    Areas,
    disc,
    peak_of,
    quantile,
    thin_marks,
)

FEATURE_RATIO, STROKE_RATIO, HIGHLIGHT_RATIO = 0.2, 0.1, 0.07
"""Diameters of the discs that fill features such as an eye with its brow, strokes such as a lid, and bright
parts such as teeth, relative to the face's height."""
INK_SHADE_EXPONENT = 0.75
"""How much of the shade between strokes is kept between light lines, which show no shade below; see
`SHADE_EXPONENT`."""
LIGHT_RATIO_RANGE = 0.1, 0.4
"""Brightness relative to the skin at which whites of eyes and teeth begin, and from which they are white."""
LIT_RATIO_RANGE, SKIN_SHARE = (0.45, 0.75), 0.75
"""Luma of the ground relative to the face's skin from which bright parts count, and from which they count
fully: not on a dark collar below a bowed head, or in a beard; and the quantile that counts as the skin."""
MIN_LUMA = 0.08
"""Added to luma before tones are compared: noise of dark skin is no feature."""
SHOWN_LUMA_RATIO, MAX_EXPONENT, MAX_TONE = 0.3, 2.2, 1.3
"""Luma of the strongest strokes to which contrast is raised, relative to the skin; the exponent that does
it, at most; and the brightest tone, as light marks get no contrast: noise would glitter."""
SPECK_RATIO, MAX_SPECK_PX, MIN_SPECK_COVERAGE = 0.085, 7.0, 0.3
"""Size, relative to the face's height, of parts that are dropped as specks; at most; and coverage
that connects."""
LAPLACIAN_WEIGHTS, GRAIN_FACTOR = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32), 6 * 0.6745
"""Laplacian of luma, and the median of its size for noise with a standard deviation of 1."""
MIN_GRAIN_LUMA, GRAIN_CONTRAST_RATIO, GRAIN_RADIUS_PX = 0.004, 4.0, 1.5
"""Grain from which luma is smoothed; contrast that counts as grain, relative to it; and standard deviation of
the Gaussian that smooths. On faces of 50 to 130 lines in six photographs."""
SHADE_STEP_COUNT, STEP_RANGE = 4, (0.25, 0.75)
"""Steps of shade from paper to ink, and the part of each in which it changes: soft edges without stairs."""
MAX_SEARCHED_HEIGHT_PX = 96
"""Larger faces are searched for skin in a reduced copy."""


class FeatureTones(NamedTuple):
    """Marks darker or lighter than the skin in the window of a face, H x W float32.

    Attributes:
        dark, light: coverage by dark strokes, and by whites of eyes and teeth, 0..1.
        tone: luma relative to the skin, with the contrast to show.
        lit: skin in light, 0..1.
        shade: factor by which the shade between strokes is darker between light lines, 0..1.
        soft: luma relative to the skin, without thin strokes, 0..1: form, but no features.
    """

    dark: np.ndarray
    light: np.ndarray
    tone: np.ndarray
    lit: np.ndarray
    shade: np.ndarray
    soft: np.ndarray


def without_grain(luma: np.ndarray) -> np.ndarray:
    """Return luma of a face without noise, stubble and blocks of compression, H x W float32.

    Immerkær 1996, "Fast Noise Variance Estimation", with a median in place of the mean.
    """
    luma = np.asarray(luma, np.float32)
    grain = quantile(np.abs(cv2.filter2D(luma, -1, LAPLACIAN_WEIGHTS)), 0.5) / GRAIN_FACTOR
    if grain < MIN_GRAIN_LUMA:
        return luma
    return cv2.bilateralFilter(luma, 5, GRAIN_CONTRAST_RATIO * grain, GRAIN_RADIUS_PX)


def skin_luma(luma: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return luma without features, and luma without strokes; `height`: of the face."""
    factor = max(1.0, height / MAX_SEARCHED_HEIGHT_PX)
    size = tuple(max(1, round(side / factor)) for side in luma.shape[::-1])
    small = luma if factor == 1 else cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    height /= factor
    calm = cv2.morphologyEx(small, cv2.MORPH_OPEN, disc(HIGHLIGHT_RATIO * height))
    skin = cv2.morphologyEx(calm, cv2.MORPH_CLOSE, disc(FEATURE_RATIO * height))
    skin = cv2.GaussianBlur(skin, (0, 0), max(0.5, SOFTNESS_RATIO * height))
    strokes = np.minimum(cv2.morphologyEx(small, cv2.MORPH_CLOSE, disc(STROKE_RATIO * height)), skin)
    if factor == 1:
        return skin, strokes
    skin, strokes = (
        cv2.resize(each, luma.shape[::-1], interpolation=cv2.INTER_LINEAR) for each in (skin, strokes)
    )
    return skin, strokes


def feature_tones(
    luma: np.ndarray, grounds: tuple[np.ndarray, np.ndarray], areas: Areas, height: float
) -> FeatureTones:
    """Return the marks of a face.

    Args:
        luma: the window of the face, H x W float32, 0..1.
        grounds: see `skin_luma`.
        areas: where features are.
        height: height of the face in pixels.
    """
    luma, skin, strokes = (each + np.float32(MIN_LUMA) for each in (luma, *grounds))
    tone = luma / strokes * cv2.pow(strokes / skin, SHADE_EXPONENT)
    darkness = np.maximum(1 - tone, 0)
    peak = peak_of(darkness, areas.parts, height)
    ink, soft = thin_marks(luma, skin, strokes, areas, height)
    lit = _lit(skin, areas.whole)
    low, high = LIGHT_RATIO_RANGE
    light = areas.parts * lit * np.clip((tone - np.float32(1 + low)) / np.float32(high - low), 0, 1)
    exponent = np.clip(np.float32(np.log(SHOWN_LUMA_RATIO)) / np.log(1 - peak), 1, MAX_EXPONENT)
    tone = np.clip(tone, MIN_LUMA, MAX_TONE)
    shown = np.where(tone > 1, 1 + (tone - 1) * lit, cv2.exp(exponent * cv2.log(tone)))
    return FeatureTones(
        ink,
        light,
        shown,
        lit,
        np.minimum(cv2.pow(strokes / skin, INK_SHADE_EXPONENT - SHADE_EXPONENT), 1),
        soft,
    )


def in_steps(shade: np.ndarray) -> np.ndarray:
    """Return shade, 0..1, in few steps with soft edges."""
    level = np.clip(shade, 0, 1) * np.float32(SHADE_STEP_COUNT)
    whole, (low, high) = np.floor(level), STEP_RANGE
    part = np.clip((level - whole - np.float32(low)) / np.float32(high - low), 0, 1)
    return np.asarray((whole + part) / np.float32(SHADE_STEP_COUNT), np.float32)


def without_specks(cover: np.ndarray, least: float) -> np.ndarray:
    """Return coverage without the parts that are neither as wide nor as high as some pixels."""
    _, labels, boxes, _ = cv2.connectedComponentsWithStats((cover > MIN_SPECK_COVERAGE).astype(np.uint8))
    sides = boxes[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1)
    kept = sides >= least
    kept[0] = True
    return cover * kept[labels]


def _lit(skin: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return where the ground is skin in light, H x W float32, 0..1; `inside`: mask of the face."""
    low, high = LIT_RATIO_RANGE
    face = skin[inside > 0.5]
    share = skin / np.float32(quantile(face, SKIN_SHARE) if face.size else 1)
    return np.asarray(np.clip((share - np.float32(low)) / np.float32(high - low), 0, 1), np.float32)
