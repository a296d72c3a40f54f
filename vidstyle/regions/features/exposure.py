"""Exposure of faces: adapts the luma of patches, so that the contrast stretch and thresholds suit the face.

The percentiles of the whole picture blow out a bright face and lose a dark one, and line thresholds follow
the strongest edges. So the tones of each face are mapped towards one range, its surroundings are limited to
that range, and its features get more contrast. Tuned by eye on 14 photographs of people at 3 to 6 m, with
flash, in dim rooms and in sunlight, in comic, cartoon, oil, noir and poster.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vidstyle.blocks import equalize
from vidstyle.core.picture import Picture
from vidstyle.core.plain_codes import PartLuma
from vidstyle.core.sampling import ExponentialSmoother, percentiles, small_luma
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.features.blurring import blurred, weighted_mean
from vidstyle.regions.masks import inner_box, inner_mask
from vidstyle.regions.patches import Patch, plane_area

FACE_LUMA_RANGE, SKIN_LUMA_RANGE = (0.12, 0.8), (0.6, 0.82)
"""Target luma of the darkest and the brightest tone of a face, and of one without eyes, nose and mouth."""
RANGE_WEIGHT = 0.5
"""Weight of the middle of that range; the rest is the weight of the face's original brightness."""
BRIGHT_WEIGHT, BRIGHT_SKIN_WEIGHT = 0.8, 0.65
"""The same for a face that is brighter, with and without eyes, nose and mouth: skin is darker than paper."""
CONTRAST_EXPONENT = 0.7
"""Exponent of the contrast factor that would fill the range: 1 fills it, 0 keeps the contrast."""
CLIP_LUMA_RANGE = 0.04, 0.9
"""Range of luma to which the surroundings of a face are limited."""
FACE_QUANTILES = 0.02, 0.98
"""Quantiles of luma in a face that define its darkest and brightest tone."""
CONTRAST_FACTOR_RANGE = 0.6, 1.9
"""Minimum and maximum contrast factor."""
PAGE_QUANTILES = 0.01, 0.35, 0.65, 0.997
"""Quantiles of luma of the page that become black and white, as in most styles, and around its middle."""
SHADING_WEIGHT, SKIN_SHADING_WEIGHT = 0.5, 0.7
"""Share of light and shadow on a face that is removed: in few tones, they would divide it; and the same for a
face without eyes, nose and mouth."""
SHADING_RADIUS_RATIO = 0.25
"""Standard deviation of the Gaussian that finds light and shadow, relative to the face's height."""
SKIN_LEVEL = 0.9
"""Level of `inner_mask` from which a pixel counts as skin."""
FEATURE_WEIGHT = 0.15
"""Factor of local contrast that is added to eyes, nose and mouth."""
FEATURE_RADIUS_RATIO = 0.125
"""Standard deviation of the Gaussian of the local mean, relative to the face's height."""
MAX_PAGE_SAMPLES = 128
"""Largest side of the copy of the page that is measured, in pixels."""
_TONE_COUNT = 1025
"""Number of tones for which the lift of dim pictures is inverted."""
TIME_CONSTANT_SECONDS = 1.0
"""Time constant for smoothing the measured tones of a face in a film."""
BARE_WEIGHT = 0.6
"""Share by which tones change less in a face whose features are drawn later, with tones of the source."""
_EDGE_RATIO, _SKIN_EDGE_RATIO = 0.1, 0.25
"""Margin of a face that is not measured, relative to its width and height: hair and background; and the same
for a face without eyes, nose and mouth."""


class Exposure:
    """Adapts the exposure of faces for a style, with temporal smoothing for each face."""

    def __init__(self) -> None:
        self._smoothers: dict[int | None, ExponentialSmoother] = {}

    def apply(
        self,
        picture: Picture,
        patches: Sequence[Patch],
        page: Picture,
        time: float | None,
        amount: float,
        lifted: Mapping[int, float],
    ) -> None:
        """Change the patches of a picture in place.

        Args:
            picture: the picture of all patches.
            patches: the patches.
            page: the picture that the patches are cut from.
            time: presentation time in seconds; None for a single picture.
            amount: strength of the change, 0..1.
            lifted: how much of eyes, nose and mouth has been taken off each face, by track.
        """
        range_ = self._smoothed(None, small_luma(page, MAX_PAGE_SAMPLES), PAGE_QUANTILES, time)
        for patch, face in ((each, each.face) for each in patches if each.face):
            box = Box(*map(round, inner_box(face.box).padded(1, 1, 1))).intersection(patch.window)
            if not box.area:
                continue
            right, down = patch.place.left - patch.window.left, patch.place.top - patch.window.top
            part = PartLuma(picture, plane_area(box.moved(right, down), (1, 1)))
            luma = part.luma
            bare = lifted.get(face.track, 0.0)
            inside = _inside_face(luma, face.box, box, bare)
            tones = self._smoothed(face.track, inside, FACE_QUANTILES, time)
            inner, stretch = inner_mask(face.box, box), Stretch.of(*range_.tolist())
            skin = (inner > SKIN_LEVEL).astype(np.float32)
            weight = amount * (1 - BARE_WEIGHT * bare)
            exposed = expose_face(luma, tones, skin, face.box.height, stretch, bare)
            part.add(weight * inner * (exposed - luma))

    def _smoothed(
        self, track: int | None, luma: np.ndarray, quantiles: tuple[float, ...], time: float | None
    ) -> np.ndarray:
        """Return quantiles of the luma of a face or of the page, smoothed over time."""
        smoother = self._smoothers.setdefault(track, ExponentialSmoother())
        measured = percentiles(luma, [100 * each for each in quantiles])
        return smoother.follow(measured, time, TIME_CONSTANT_SECONDS)


class Stretch(NamedTuple):
    """A stretch of contrast as most styles do it first: shown = 0.5 + gain * (luma - middle), then a lift."""

    middle: float
    gain: float
    growth: float = 0.0

    @classmethod
    def of(cls, dark: float, *tones: float) -> Stretch:
        """Return the stretch for the percentiles of a page, the brightest last; see the block equalize."""
        *around, bright = tones
        stretch = equalize.ToneStretch.between(dark, bright, equalize.DEFAULT_LIFT_AMOUNT)
        middle = stretch.center + (0.5 - stretch.level) / stretch.gain
        return cls(middle, stretch.gain, stretch.growth(around, equalize.DEFAULT_LIFT_AMOUNT))

    def shown(self, luma: np.ndarray) -> np.ndarray:
        rigid = np.float32(0.5) + np.float32(self.gain) * (luma - np.float32(self.middle))
        if not self.growth:
            return rigid
        inside = np.clip(rigid, 0, 1)
        return rigid + equalize.lifted(inside, self.growth) - inside

    def luma(self, shown: np.ndarray) -> np.ndarray:
        """Return the luma that is shown like this."""
        if self.growth:
            inside, tones = np.clip(shown, 0, 1), np.linspace(0, 1, _TONE_COUNT)
            before = np.interp(inside, equalize.lifted(tones, self.growth), tones).astype(np.float32)
            shown = shown + before - inside
        return np.float32(self.middle) + (shown - np.float32(0.5)) / np.float32(self.gain)


def expose_face(
    luma: np.ndarray, tones: np.ndarray, skin: np.ndarray, height: float, stretch: Stretch, bare: float = 0.0
) -> np.ndarray:
    """Return luma that, after a stretch, has the tones of a face near `FACE_LUMA_RANGE`.

    Args:
        luma: the face and its surroundings, H x W float32, 0..1.
        tones: darkest and brightest tone of the face.
        skin: mask of the face without hair, H x W float32, 0..1.
        height: height of the face in pixels.
        stretch: what the style will do.
        bare: how much of eyes, nose and mouth has been taken off, 0..1.
    """
    low, high = (_mixed(*ends, bare) for ends in zip(FACE_LUMA_RANGE, SKIN_LUMA_RANGE, strict=True))
    dark, bright = stretch.shown(tones).tolist()
    gain = ((high - low) / max(bright - dark, 1e-3)) ** CONTRAST_EXPONENT
    gain = min(_mixed(CONTRAST_FACTOR_RANGE[1], 1.0, bare), max(CONTRAST_FACTOR_RANGE[0], gain))
    middle = (dark + bright) / 2
    wanted = (low + high) / 2
    pull = _mixed(BRIGHT_WEIGHT, BRIGHT_SKIN_WEIGHT, bare) if wanted < middle else RANGE_WEIGHT
    moved = middle + pull * (wanted - middle)
    shown = stretch.shown(luma)
    even = shown - np.float32(_mixed(SHADING_WEIGHT, SKIN_SHADING_WEIGHT, bare)) * (
        weighted_mean(shown, skin, SHADING_RADIUS_RATIO * height) - np.float32(middle)
    )
    ranged = np.clip(moved + gain * (even - np.float32(middle)), *CLIP_LUMA_RANGE)
    # Black stays black: hair, and a dark background.
    lift = np.clip(shown / np.float32(max(dark, 1e-3)), 0, 1)
    ranged = np.where(ranged > shown, shown + lift * (ranged - shown), ranged)
    around = blurred(ranged, FEATURE_RADIUS_RATIO * height)
    weight = np.float32(_mixed(FEATURE_WEIGHT, 0.0, bare))
    return stretch.luma(np.clip(ranged + weight * (ranged - around), *CLIP_LUMA_RANGE))


def _inside_face(luma: np.ndarray, face: Box[float], area: Rectangle, bare: float) -> np.ndarray:
    """Return the centre of the face in the luma of an area; the whole area if the face is outside."""
    edge = -_mixed(_EDGE_RATIO, _SKIN_EDGE_RATIO, bare)
    inner = face.padded(edge * face.width, edge * face.height, edge * face.height)
    inner = inner.moved(-area.left, -area.top)
    place = Box(*map(round, inner)).intersection(Box(0, 0, luma.shape[1], luma.shape[0]))
    return luma[plane_area(place, (1, 1))] if place.area else luma


def _mixed(whole: float, bare: float, share: float) -> float:
    """Return a value between that for a face with its features and that for one without them."""
    return whole + share * (bare - whole)
