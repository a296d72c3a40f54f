"""Light on dim faces: a face in shade gets the tone and the contrast that every style needs to show it.

A back-lit face has few dark tones, between which no style finds an eye. Its light and shade are halved and
brightened, and what differs from them is strengthened, before anything else sees the picture. Grain keeps its
size, and a face in light is not changed. Tuned on a back-lit face of 93 of 332 lines, and 22 others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import PartLuma
from vidstyle.core.sampling import ExponentialSmoother, percentiles, small_luma
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.areas import feature_areas
from vidstyle.regions.features.blurring import weighted_mean
from vidstyle.regions.features.calm_skin import without_grain
from vidstyle.regions.features.exposure import (
    MAX_PAGE_SAMPLES,
    PAGE_QUANTILES,
    TIME_CONSTANT_SECONDS,
    Stretch,
)
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.masks import inner_box, inner_mask
from vidstyle.regions.patches import plane_area
from vidstyle.regions.writing.lifting import luma_in

DIM_TONE_RANGE = 0.46, 0.36
"""Median tone of a face, as a style shows it, from which it is dim, and up to which it is entirely."""
WANTED_TONE_LEVEL, TONE_WEIGHT, MAX_TONE_FACTOR = 0.46, 0.6, 1.35
"""Tone that a dim face approaches, how far, and the largest factor: dark skin stays dark."""
TONE_QUANTILES = 0.5, 0.95
"""Quantiles of luma that are the median and the bright tone of a face."""
MAX_FACE_SAMPLES = 4096
"""Samples of a face that are measured, about."""
EDGE_RATIO = 0.15
"""Margin of a face that is not measured, relative to its width and height."""
SHADE_RATIO, SHADE_WEIGHT = 0.15, 0.6
"""Standard deviation of the Gaussian that finds light and shade, relative to the face's height; and the share
of them that is kept."""
WANTED_SPREAD_RATIO, MAX_CONTRAST_FACTOR = 0.5, 4.0
"""Standard deviation of the logarithm of tones nearby to which contrast is raised, and the largest factor."""
GRAIN_SPREAD_RANGE = 0.05, 0.12
"""Standard deviation up to which details count as grain, and from which they count as features."""
LIGHT_EXPONENT = 0.4
"""Exponent of this factor for details lighter than the skin nearby: a nose in light would become paper."""
SMOOTH_RATIO, SMOOTH_RANGE_PX = 0.013, (0.5, 1.3)
"""Standard deviation of the Gaussian that takes grain off, relative to the face's height, and its limits."""
FINE_RANGE = 0.015, 0.045
"""Difference of tone from this Gaussian that is grain, and from which it is a fine detail, which is kept."""
BRIGHT_RANGE = 0.05, 0.2
"""How much brighter than the face parts are that get less light, and parts that get none: the background."""
MIN_TONE = 0.05
"""Added to tones before they are compared: black stays black."""


class DimFace(NamedTuple):
    """A face with too little light.

    Attributes:
        face: the face; its opacity counts.
        stretch: what a style does to the page.
        tones: median and bright tone of the face after it.
    """

    face: Face
    stretch: Stretch
    tones: tuple[float, float]


class DimFaces:
    """Finds the faces of pictures that are dim, with temporal smoothing for each face."""

    def __init__(self) -> None:
        self._smoothers: dict[int | None, ExponentialSmoother] = {}

    def follow(self, picture: Picture, faces: Sequence[Face], time: float | None) -> list[DimFace]:
        """Return the dim faces among those of the next picture, at `time` in seconds; None: a single one."""
        if not faces:
            return []
        tracks = {each.track for each in faces}
        known = tracks & self._smoothers.keys()
        # With other faces, another scene begins.
        kept = {None, *known} if known and time is not None else set()
        self._smoothers = {track: each for track, each in self._smoothers.items() if track in kept}
        page = self._smoothed(None, small_luma(picture, MAX_PAGE_SAMPLES), PAGE_QUANTILES, time)
        stretch = Stretch.of(*page)
        measured = [DimFace(each, stretch, self._tones(picture, each, stretch, time)) for each in faces]
        return [each for each in measured if each.tones[0] < DIM_TONE_RANGE[0]]

    def _tones(
        self, picture: Picture, face: Face, stretch: Stretch, time: float | None
    ) -> tuple[float, float]:
        inner = face.box.padded(*(-EDGE_RATIO * side for side in (face.box.width, *2 * (face.box.height,))))
        window = _within(inner, picture)
        if not window.area:
            return 1.0, 1.0
        every = max(1, round((window.area / MAX_FACE_SAMPLES) ** 0.5))
        luma = luma_in(picture, window)[::every, ::every]
        tones = self._smoothed(face.track, luma, TONE_QUANTILES, time)
        median, bright = stretch.shown(np.array(tones)).tolist()
        return median, bright

    def _smoothed(
        self, track: int | None, luma: np.ndarray, quantiles: tuple[float, ...], time: float | None
    ) -> list[float]:
        measured = percentiles(luma, [100 * each for each in quantiles])
        smoother = self._smoothers.setdefault(track, ExponentialSmoother())
        return smoother.follow(measured, time, TIME_CONSTANT_SECONDS).tolist()


def light_faces(picture: Picture, faces: Sequence[DimFace], amount: float) -> tuple[Picture, list[Rectangle]]:
    """Return a picture with more light on dim faces, and the parts that have changed.

    Args:
        picture: is only read.
        faces: the faces.
        amount: 0..1.
    """
    name = "luma" if picture.color is None else "color"
    picture = replace(picture, **{name: getattr(picture, name).copy()})
    windows = [_within(inner_box(each.face.box), picture) for each in faces]
    for each, window in zip(faces, windows, strict=True):
        part = PartLuma(picture, plane_area(window, (1, 1)))
        part.add(np.float32(amount * each.face.opacity) * _light(part.luma, each, window))
    return picture, windows


def _light(luma: np.ndarray, dim: DimFace, window: Rectangle) -> np.ndarray:
    """Return what is added to the luma of a window."""
    box, (median, bright) = dim.face.box, dim.tones
    height = box.height
    calm = cv2.GaussianBlur(
        without_grain(luma), (0, 0), float(np.clip(SMOOTH_RATIO * height, *SMOOTH_RANGE_PX))
    )
    shown = np.maximum(dim.stretch.shown(calm), 0)
    fine = dim.stretch.shown(luma) - shown
    behind = ramp(shown - np.float32(bright), BRIGHT_RANGE)
    tone = cv2.log(shown + np.float32(MIN_TONE))
    inner = inner_mask(box, window)
    skin = inner * (1 - behind)
    shade = weighted_mean(tone, skin, SHADE_RATIO * height)
    detail = tone - shade
    middle = np.log(median + MIN_TONE)
    lift = min(MAX_TONE_FACTOR, ((WANTED_TONE_LEVEL + MIN_TONE) / (median + MIN_TONE)) ** TONE_WEIGHT)
    even = np.float32(middle + np.log(lift)) + np.float32(SHADE_WEIGHT) * (shade - np.float32(middle))
    raised = _raised(detail, skin, SHADE_RATIO * height)
    detail = detail + feature_areas(dim.face, window).whole * (raised - detail)
    lit = cv2.exp(even + detail) - np.float32(MIN_TONE)
    share = np.float32(ramp(median, DIM_TONE_RANGE)) * inner * (1 - behind)
    return np.asarray(
        share
        * (np.minimum(lit, 1) - shown - fine * (1 - ramp(np.abs(fine), FINE_RANGE)))
        / np.float32(dim.stretch.gain),
        np.float32,
    )


def _raised(detail: np.ndarray, skin: np.ndarray, sigma: float) -> np.ndarray:
    """Return details with more contrast, the more so the less there is nearby."""
    spread = cv2.sqrt(weighted_mean(detail * detail, skin, sigma))
    factor = np.clip(
        np.float32(WANTED_SPREAD_RATIO) / np.maximum(spread, np.float32(1e-3)), 1, MAX_CONTRAST_FACTOR
    )
    factor = 1 + (factor - 1) * ramp(spread, GRAIN_SPREAD_RANGE)
    return np.asarray(detail * np.where(detail < 0, factor, factor ** np.float32(LIGHT_EXPONENT)), np.float32)


def _within(box: Box[float], picture: Picture) -> Rectangle:
    return Box(*map(round, box)).intersection(Box(0, 0, picture.shape[1], picture.shape[0]))
