"""Metrics of restyled pictures: visual quality, and difference from the source and from other pictures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.picture import BT709_WEIGHTS
from vidstyle.explore.colors import oklab
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.media.resize import reduce_picture
from vidstyle.style import Style

MAX_DRAWN_SIDE_PX = 320
"""Longer side at which candidates are rendered; in smaller pictures, marks would be larger than in a film."""
MAX_MEASURED_SIDE_PX = 160
"""Longer side at which pictures are measured; marks then blend into tone and texture, as for the eye."""
THUMBNAIL_SIZE_PX = 16
"""Rows and columns of the thumbnail by which pictures are compared."""
GRAIN_DEVIATION = 2.0
"""Standard deviation of the noise for measuring steadiness, in levels of 255."""
MAX_INK_LEVEL, MIN_PAPER_LEVEL = 0.15, 0.92
"""Luma below which a pixel counts as ink, and above which it counts as paper."""
SHAPE_BAND_PX = (1, 5)
"""Standard deviations of the two blurs between which shapes are seen."""
STRONG_EDGE_PERCENTILE = 80
"""Percentile of the gradient above which an edge in the source is strong."""


class PictureMetrics(NamedTuple):
    """Metrics of a restyled picture compared with its source; luma is 0..1.

    Attributes:
        tone: correlation of blurred luma with that in the source, -1..1.
        shapes: absolute correlation of band-passed luma with that in the source.
        edges: share of strong source edges that stay strong; those in the middle weigh more.
        clutter: mean difference between luma and luma blurred by 1.5 pixels.
        noise: clutter where the source is flat.
        range: difference between the 5 % and 95 % percentiles of luma.
        middle: mean of luma.
        ink: share of pixels darker than `MAX_INK_LEVEL`.
        paper: share of pixels brighter than `MIN_PAPER_LEVEL`.
        contrast: standard deviation of blurred luma.
        color: colourfulness (Hasler and Suesstrunk 2003), 1 for 255 levels.
        garish: share of pixels with nearly pure screen colours.
        sharp: 98 % percentile of the gradient of luma.
        crisp: the same percentile before reduction to `MAX_MEASURED_SIDE_PX`.
        photo: correlation of the finest luma detail with that in the source; 1 for a photograph.
        change: mean Oklab distance from the source.
    """

    tone: float
    shapes: float
    edges: float
    clutter: float
    noise: float
    range: float
    middle: float
    ink: float
    paper: float
    contrast: float
    color: float
    garish: float
    sharp: float
    crisp: float
    photo: float
    change: float


METRIC_DEVIATIONS = PictureMetrics(
    0.4, 0.25, 0.25, 0.04, 0.03, 0.25, 0.2, 0.15, 0.25, 0.08, 0.12, 0.15, 0.15, 0.1, 0.3, 0.12
)
"""Typical deviation of each metric between pictures, which makes differences comparable."""


class Original:
    """The source picture of the candidates, H x W x 3 uint8, prepared for comparison with results.

    Attributes:
        picture: the source, reduced to `MAX_DRAWN_SIDE_PX`.
        large: the source at its original size.
    """

    def __init__(self, picture: np.ndarray) -> None:
        self.picture, self.large = reduce_picture(picture, MAX_DRAWN_SIDE_PX), picture
        small = reduce_picture(picture, MAX_MEASURED_SIDE_PX)
        self._lab = oklab(small / 255.0)
        self._luma = luma_of_codes(small)
        self._band = band_pass(self._luma, *SHAPE_BAND_PX)
        gradient = gradient_of(cv2.GaussianBlur(self._luma, (0, 0), 1))
        self._edges = gradient >= max(float(np.percentile(gradient, STRONG_EDGE_PERCENTILE)), 0.01)
        self._fine = _fine(luma_of_codes(self.picture))
        self._flat = ~cv2.dilate(self._edges.astype(np.uint8), np.ones((5, 5))).astype(bool)
        height, width = self._luma.shape
        y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
        self._weights = np.exp(-(x * x + y * y)) * self._edges

    def render(self, style: Style) -> np.ndarray:
        """Render the picture in a style; H x W x 3 uint8."""
        return restyle_picture(self.picture, style)

    def measure(self, picture: np.ndarray) -> PictureMetrics:
        """Return the metrics of a restyled picture, H x W x 3 uint8, of any size."""
        small = cv2.resize(picture, self._luma.shape[::-1], interpolation=cv2.INTER_AREA)
        luma, lab = luma_of_codes(small), oklab(small / 255.0)
        fine = np.abs(luma - cv2.GaussianBlur(luma, (0, 0), 1.5))
        large = luma_of_codes(cv2.resize(picture, self._fine.shape[::-1], interpolation=cv2.INTER_AREA))
        gradient = gradient_of(luma)
        low, high = np.percentile(luma, (5, 95))
        blurred = cv2.GaussianBlur(luma, (0, 0), 4)
        near = cv2.dilate(gradient, np.ones((3, 3)))
        strong = near >= max(float(np.percentile(near, 100 - 1.5 * (100 - STRONG_EDGE_PERCENTILE))), 0.03)
        top, bottom = small.max(axis=2), small.min(axis=2)
        return PictureMetrics(
            tone=correlation(blurred, cv2.GaussianBlur(self._luma, (0, 0), 4)),
            shapes=abs(correlation(band_pass(luma, *SHAPE_BAND_PX), self._band)),
            edges=float((self._weights * strong).sum() / max(self._weights.sum(), 1e-6)),
            clutter=float(fine.mean()),
            noise=float(fine[self._flat].mean()) if self._flat.any() else float(fine.mean()),
            range=float(high - low),
            middle=float(luma.mean()),
            ink=float((luma < MAX_INK_LEVEL).mean()),
            paper=float((luma > MIN_PAPER_LEVEL).mean()),
            contrast=float(blurred.std()),
            color=_colorfulness(small / 255.0),
            garish=float(((top > 230) & (bottom < 40)).mean()),
            sharp=float(np.percentile(gradient, 98)),
            crisp=float(np.percentile(gradient_of(large), 98)),
            photo=correlation(_fine(large), self._fine),
            change=float(np.linalg.norm(lab - self._lab, axis=2).mean()),
        )

    def signature(self, picture: np.ndarray, measures: PictureMetrics | None = None) -> np.ndarray:
        """Return a vector for comparing restyled pictures: a Euclidean distance of 1 is clearly different.

        It consists of the metrics and a colour thumbnail.
        """
        numbers = np.array(measures or self.measure(picture)) / METRIC_DEVIATIONS
        colors = oklab_thumbnail(picture).reshape(-1) / (0.1 * THUMBNAIL_SIZE_PX)
        return np.concatenate([0.5 * numbers / np.sqrt(len(numbers)), colors])

    def steadiness(self, style: Style, picture: np.ndarray) -> float:
        """Return how much a style amplifies film grain: its change over three frames relative to the source.

        The frames are the original and two copies with fixed random grain.

        Args:
            picture: the original in the style.
        """
        noise = np.random.RandomState(1).normal(0, GRAIN_DEVIATION, (2, *self.picture.shape[:2], 1))
        grainy = [np.clip(self.picture + each, 0, 255).round().astype(np.uint8) for each in noise]
        # The grain is not removed as the noise of single pictures is: it stands for the noise of a film.
        bare = replace(style, steady=0.0)
        changes = _changes([picture, *(restyle_picture(frame, bare) for frame in grainy)])
        return changes / max(_changes([self.picture, *grainy]), 1e-6)


def oklab_thumbnail(picture: np.ndarray) -> np.ndarray:
    """Return a thumbnail in Oklab: `THUMBNAIL_SIZE_PX` x `THUMBNAIL_SIZE_PX` x 3."""
    return oklab(
        cv2.resize(picture, (THUMBNAIL_SIZE_PX, THUMBNAIL_SIZE_PX), interpolation=cv2.INTER_AREA) / 255.0
    )


def luma_of_codes(picture: np.ndarray) -> np.ndarray:
    """Return the luma of RGB 0..255 as float32 0..1."""
    return (picture @ BT709_WEIGHTS / 255).astype(np.float32)


def gradient_of(luma: np.ndarray) -> np.ndarray:
    """Return the magnitude of the gradient, in luma per pixel."""
    across, down = (cv2.Sobel(luma, cv2.CV_32F, *order, scale=1 / 8) for order in ((1, 0), (0, 1)))
    return cv2.magnitude(across, down)


def band_pass(luma: np.ndarray, fine: float, coarse: float) -> np.ndarray:
    """Return the detail between two blurs, given by their standard deviations in pixels."""
    return cv2.GaussianBlur(luma, (0, 0), fine) - cv2.GaussianBlur(luma, (0, 0), coarse)


def correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Return Pearson's correlation; 0 if one picture is constant."""
    one, other = one - one.mean(), other - other.mean()
    scale = float(np.sqrt((one * one).sum() * (other * other).sum()))
    return float((one * other).sum()) / scale if scale > 1e-9 else 0.0


def _fine(luma: np.ndarray) -> np.ndarray:
    return luma - cv2.GaussianBlur(luma, (0, 0), 1)


def _colorfulness(color: np.ndarray) -> float:
    red_green = color[..., 0] - color[..., 1]
    yellow_blue = (color[..., 0] + color[..., 1]) / 2 - color[..., 2]
    spread = np.hypot(red_green.std(), yellow_blue.std())
    return float(spread + 0.3 * np.hypot(red_green.mean(), yellow_blue.mean()))


def _changes(frames: Iterable[np.ndarray]) -> float:
    """Return the mean absolute change between consecutive frames."""
    pairs = pairwise(frame.astype(np.float32) for frame in frames)
    return float(np.mean([np.abs(after - before).mean() for before, after in pairs]))
