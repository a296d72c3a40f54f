"""Takes eyes, nose and mouth off the patches of small faces, and keeps their tones.

A morphological closing finds details that are darker than the skin around them, as for writing. The style
then draws a face without lines, and cannot make an eye larger than it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import codes_from_values, values_from_codes
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.areas import feature_areas
from vidstyle.regions.masks import face_mask, mask_box
from vidstyle.regions.patches import Patch, plane_area

FACE_RATIOS = 0.16, 0.22
"""Heights of faces relative to the picture's shorter side. Up to the first, features are lifted completely;
from the second on not at all, as the style draws them well itself."""
FEATURE_RATIO, STROKE_RATIO, HIGHLIGHT_RATIO = 0.2, 0.1, 0.07
"""Diameters of the discs that fill features such as an eye with its brow, strokes such as a lid, and bright
parts such as teeth, relative to the face's height."""
SOFTNESS_RATIO = 0.03
"""Standard deviation of the Gaussian that smooths skin without features, in the same way."""
SHADE_EXPONENT = 0.4
"""How much of the shade between strokes, such as in an eye socket, is kept: 1 for all."""
NEAR_RATIO = 0.25
"""Side of the square in which the strongest stroke is full ink, in the same way."""
DARKNESS_RANGE = 0.1, 0.8
"""Darkness of the strongest stroke nearby, relative to the skin, at least and at most."""
MIN_DARKNESS_RATIO, STRONGEST_SHARE = 0.5, 0.97
"""The same, at least, relative to the darkness of the face's strongest strokes; and the quantile that counts
as these."""
CHEEK_WEIGHT = 0.45
"""Weight of strokes outside of eyes and mouth, such as folds."""
LIGHT_RATIO_RANGE = 0.1, 0.4
"""Brightness relative to the skin at which whites of eyes and teeth begin, and from which they are white."""
LIT_RATIO_RANGE, SKIN_SHARE = (0.45, 0.75), 0.75
"""Luma of the ground relative to the face's skin from which bright parts count, and from which they count
fully: not on a dark collar below a bowed head, or in a beard; and the quantile that counts as the skin."""
MIN_LUMA = 0.08
"""Added to luma before tones are compared: noise of dark skin is no feature."""
SHOWN_LUMA_RATIO, MAX_EXPONENT = 0.3, 2.5
"""Luma of the strongest strokes to which contrast is raised, relative to the skin; and the exponent that does
it, at most."""
LAPLACIAN_WEIGHTS, GRAIN_FACTOR = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32), 6 * 0.6745
"""Laplacian of luma, and the median of its size for noise with a standard deviation of 1."""
MIN_GRAIN_LUMA, GRAIN_CONTRAST_RATIO, GRAIN_RADIUS_PX = 0.004, 4.0, 1.5
"""Grain from which luma is smoothed; contrast that counts as grain, relative to it; and standard deviation of
the Gaussian that smooths. On faces of 50 to 130 lines in six photographs."""
MAX_SEARCHED_HEIGHT_PX = 96
"""Larger faces are searched for skin in a reduced copy."""


class Features(NamedTuple):
    """The features of a face; all planes are H x W float32.

    Attributes:
        window: their box in the picture.
        weight: how much of them has been lifted, 0..1.
        dark, light: coverage by dark strokes, and by whites of eyes and teeth, 0..1.
        tone: luma relative to the skin, with the contrast to show.
        skin_luma: mean luma of the skin, 0..1.
        face: the face.
        amount: the largest weight.
    """

    window: Rectangle
    weight: np.ndarray
    dark: np.ndarray
    light: np.ndarray
    tone: np.ndarray
    skin_luma: float
    face: Face
    amount: float


def lift_features(
    picture: Picture, patches: Sequence[Patch], amount: float, page_side: float
) -> list[Features]:
    """Change the patches of a picture in place: take off features. Return them.

    Args:
        picture: the picture of all patches.
        patches: the patches.
        amount: 0..1.
        page_side: shorter side of the whole picture.
    """
    whole, none = FACE_RATIOS
    lifted = list[Features]()
    for patch, face in ((each, each.face) for each in patches if each.face):
        share = amount * min(1.0, max(0.0, (none - face.box.height / page_side) / (none - whole)))
        window = Box(*map(round, mask_box(face.box))).intersection(patch.window)
        if share and window.area:
            lifted.append(_lift(picture, patch, face, window, share))
    return lifted


def _lift(picture: Picture, patch: Patch, face: Face, window: Rectangle, amount: float) -> Features:
    place = window.moved(patch.place.left - patch.window.left, patch.place.top - patch.window.top)
    area = plane_area(place, (1, 1))
    plane = picture.color if picture.luma is None else picture.luma
    assert plane is not None
    values = values_from_codes(plane[area], "luma", picture.encoding)
    luma = values if values.ndim == 2 else values @ picture.encoding.weights
    luma = _without_grain(luma)
    skin, strokes = _envelopes(luma, face.box.height)
    areas, whole = feature_areas(face, window)
    inside = whole * face_mask(face.box, window)
    change = np.float32(amount) * inside * (skin - luma)
    values = values + (change if values.ndim == 2 else change[..., None])
    plane[area] = codes_from_values(values, "luma", picture.encoding)
    dark, light, tone = _tones(luma, skin, strokes, areas, face.box.height)
    lit = _lit(skin, inside)
    light, tone = light * lit, np.where(tone > 1, 1 + (tone - 1) * lit, tone)
    weight = np.float32(amount * face.opacity) * inside
    return Features(window, weight, dark, light, tone, float(skin.mean()), face, amount)


def _without_grain(luma: np.ndarray) -> np.ndarray:
    """Return luma of a face without noise, stubble and blocks of compression, H x W float32.

    The Laplacian that cancels slopes (Immerkaer 1996) measures them.
    """
    luma = np.asarray(luma, np.float32)
    grain = float(np.median(np.abs(cv2.filter2D(luma, -1, LAPLACIAN_WEIGHTS)))) / GRAIN_FACTOR
    if grain < MIN_GRAIN_LUMA:
        return luma
    return cv2.bilateralFilter(luma, 5, GRAIN_CONTRAST_RATIO * grain, GRAIN_RADIUS_PX)


def _envelopes(luma: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return luma without features, and luma without strokes."""
    factor = max(1.0, height / MAX_SEARCHED_HEIGHT_PX)
    size = tuple(max(1, round(side / factor)) for side in luma.shape[::-1])
    small = luma if factor == 1 else cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    height /= factor
    calm = cv2.morphologyEx(small, cv2.MORPH_OPEN, _disc(HIGHLIGHT_RATIO * height))
    skin = cv2.morphologyEx(calm, cv2.MORPH_CLOSE, _disc(FEATURE_RATIO * height))
    skin = cv2.GaussianBlur(skin, (0, 0), max(0.5, SOFTNESS_RATIO * height))
    strokes = np.minimum(cv2.morphologyEx(small, cv2.MORPH_CLOSE, _disc(STROKE_RATIO * height)), skin)
    if factor == 1:
        return skin, strokes
    skin, strokes = (
        cv2.resize(each, luma.shape[::-1], interpolation=cv2.INTER_LINEAR) for each in (skin, strokes)
    )
    return skin, strokes


def _tones(
    luma: np.ndarray, skin: np.ndarray, strokes: np.ndarray, areas: np.ndarray, height: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return coverage by dark strokes and by light parts, and tones; see `Features`."""
    skin, strokes, luma = (each + np.float32(MIN_LUMA) for each in (skin, strokes, luma))
    tone = luma / strokes * (strokes / skin) ** np.float32(SHADE_EXPONENT)
    important = np.float32(CHEEK_WEIGHT) + np.float32(1 - CHEEK_WEIGHT) * areas
    darkness = np.maximum(1 - tone, 0)
    size = max(1, round(NEAR_RATIO * height))
    peak = cv2.blur(cv2.dilate(darkness * areas, np.ones((size, size), np.uint8)), (size, size))
    least, most = DARKNESS_RANGE
    strongest = float(np.quantile(darkness[areas > 0.5], STRONGEST_SHARE)) if areas.max() > 0.5 else most
    peak = np.clip(peak, min(most, max(least, MIN_DARKNESS_RATIO * strongest)), most)
    low, high = LIGHT_RATIO_RANGE
    light = areas * np.clip((tone - np.float32(1 + low)) / np.float32(high - low), 0, 1)
    exponent = np.clip(np.float32(np.log(SHOWN_LUMA_RATIO)) / np.log(1 - peak), 1, MAX_EXPONENT)
    return np.minimum(important * darkness / peak, 1), light, np.clip(tone, 0, 2) ** exponent


def _lit(skin: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return where the ground is skin in light, H x W float32, 0..1; `inside`: mask of the face."""
    low, high = LIT_RATIO_RANGE
    face = skin[inside > 0.5]
    level = np.float32(np.quantile(face, SKIN_SHARE) if face.size else 0) + np.float32(MIN_LUMA)
    share = (skin + np.float32(MIN_LUMA)) / level
    return np.asarray(np.clip((share - np.float32(low)) / np.float32(high - low), 0, 1), np.float32)


def _disc(size: float) -> np.ndarray:
    side = max(3, 2 * int(size / 2) + 1)
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
