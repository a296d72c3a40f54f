"""Measures of a crop of a restyled picture at full size, compared with the same crop of its source."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.explore.crops.debris import SourceAreas
from vidstyle.explore.measure import correlation, gradient_of, luma_of_codes
from vidstyle.regions.boxes import Box

FINEST_BAND_PX, FINE_BAND_PX, DETAIL_BAND_PX, COARSE_BAND_PX = (0.5, 1), (1, 2), (2, 4), (8, 16)
"""Standard deviations of the two blurs between which detail of a size is seen."""
MIN_FINEST, MIN_DETAIL = 0.003, 0.005
"""What is added to the strength of a band, so that the ratio of two weak ones means nothing."""
STEP_SIDE_PX, MIN_STEP = 5, 0.12
"""Side of the square in which an edge is a step of luma, and the smallest step that counts as an edge."""
HARD_PERCENTILE = 75
MARK_FACTOR = 2
"""Reduction at which the width of marks is measured."""
MARK_RADII_PX = 2, 4, 8, 14
"""Radii of the structuring elements that extract marks of four widths, after this reduction."""
BUSY_SQUARE_PX, BUSY_PERCENTILE = (25, 25), 90
"""Squares whose mean gradients are compared, and the percentile from which they are busy."""
WHITE_LEVEL, BLACK_LEVEL = 0.93, 0.07
FACE_WIDTH_PX, FACE_BAND_PX, FACE_OUTLINE_BAND_PX = 64, (1, 4), (0.7, 2)
"""Width of a face for comparison with the source, and the bands of eyes and mouth, and of their outlines."""
MAX_FACE_COUNT, MIN_FACE_SHARE = 3, 0.7
"""Of many faces in a crop, the largest are compared, if this share of their height and width is in it."""
MAX_FACE_LIKENESS = 1.0


class FullSizeMetrics(NamedTuple):
    """Metrics of a restyled crop; luma is 0..1.

    Where the crop shows faces, the worst face counts instead of the crop, or the worst of both, as people
    judge a picture by its faces.

    Attributes:
        fine_kept: correlation of luma detail of 1 to 2 pixels with the source.
        detail_kept: the same for 2 to 4 pixels.
        fineness: logarithm of the strength of detail of one pixel relative to that of four: high if edges are
            crisp, low if the picture is soft.
        edge_hardness: steepness of edges relative to their height, upper quartile; 1 for edges of one pixel.
        mark_strength: mean height of dark and bright marks up to the largest width.
        mark_width: the height of marks up to the largest width relative to the narrowest.
        bright_shapes: mean height of bright marks between the second and the largest width, less that of the
            source: negative where light parts have lost their form.
        bright_marks: the same between the second and the third width.
        coarse_contrast: strength of detail of 8 to 16 pixels.
        chroma: mean difference of the largest and the smallest colour channel.
        busyness: mean gradient of luma in squares, 90th percentile.
        lightness: median of luma.
        burnt: share of pixels that are nearly white or black, less that of the source.
        debris: mean height of structure where the source is smooth.
        patchiness: deviation of that height between places: a regular screen has little, worms have much.
        halo: mean height of bright rims beside edges.
        face: absolute correlation of facial features with the source; `MAX_FACE_LIKENESS` without a face.
        face_outlines: the same for outlines of features, which smears and blots destroy first.
    """

    fine_kept: float
    detail_kept: float
    fineness: float
    edge_hardness: float
    mark_strength: float
    mark_width: float
    bright_shapes: float
    bright_marks: float
    coarse_contrast: float
    chroma: float
    busyness: float
    lightness: float
    burnt: float
    debris: float
    patchiness: float
    halo: float
    face: float
    face_outlines: float


class ComparedCrop:
    """A crop of the source, H x W x 3 uint8, and the faces in it, the largest first."""

    def __init__(self, source: np.ndarray, faces: Sequence[Box[float]]) -> None:
        self._whole, self._areas = _Region(source), SourceAreas(luma_of_codes(source))
        parts = [part for face in faces if (part := _part(face, source.shape)) is not None]
        self._faces = [(part, _Region(source[part])) for part in parts[:MAX_FACE_COUNT]]

    @property
    def has_faces(self) -> bool:
        """Whether faces are compared."""
        return bool(self._faces)

    def measure(self, result: np.ndarray) -> FullSizeMetrics:
        """Return the metrics of the crop in a style, H x W x 3 uint8."""
        added = self._areas.added(luma_of_codes(result))._asdict()
        whole = self._whole.measure(result)._replace(**added)
        faces = [region.measure(result[part]) for part, region in self._faces]
        if not faces:
            return whole._replace(face=MAX_FACE_LIKENESS, face_outlines=MAX_FACE_LIKENESS)
        face, low, high = (
            FullSizeMetrics(*of(rows, axis=0).tolist())
            for of, rows in ((np.min, faces), (np.min, [whole, *faces]), (np.max, [whole, *faces]))
        )
        return face._replace(
            fineness=high.fineness,
            mark_width=low.mark_width,
            bright_shapes=low.bright_shapes,
            bright_marks=low.bright_marks,
            coarse_contrast=low.coarse_contrast,
            chroma=whole.chroma,
            busyness=whole.busyness,
            lightness=whole.lightness,
            burnt=high.burnt,
            **added,
        )


class _Region:
    """A part of the source, H x W x 3 uint8, prepared for comparison."""

    def __init__(self, source: np.ndarray) -> None:
        luma = luma_of_codes(source)
        self._fine, self._detail = _band(luma, *FINE_BAND_PX), _band(luma, *DETAIL_BAND_PX)
        self._bright = _marks(luma)[1]
        self._extreme = _extreme_share(luma)
        self._features = _features(luma, FACE_BAND_PX)
        self._outlines = _features(luma, FACE_OUTLINE_BAND_PX)

    def measure(self, result: np.ndarray) -> FullSizeMetrics:
        """Return the metrics of this part in a style, as if it was a face."""
        luma = luma_of_codes(result)
        finest, detail = _band(luma, *FINEST_BAND_PX), _band(luma, *DETAIL_BAND_PX)
        dark, bright = _marks(luma)
        return FullSizeMetrics(
            fine_kept=correlation(_band(luma, *FINE_BAND_PX), self._fine),
            detail_kept=correlation(detail, self._detail),
            fineness=float(np.log((finest.std() + MIN_FINEST) / (detail.std() + MIN_DETAIL))),
            edge_hardness=_edge_hardness(luma),
            mark_strength=dark[3] + bright[3],
            mark_width=(dark[3] + bright[3]) / max(dark[0] + bright[0], MIN_FINEST),
            bright_shapes=bright[3] - bright[1] - (self._bright[3] - self._bright[1]),
            bright_marks=bright[2] - bright[1] - (self._bright[2] - self._bright[1]),
            coarse_contrast=float(_band(luma, *COARSE_BAND_PX).std()),
            chroma=float((result.max(axis=2) - result.min(axis=2)).mean() / 255),
            busyness=float(np.percentile(cv2.blur(gradient_of(luma), BUSY_SQUARE_PX), BUSY_PERCENTILE)),
            lightness=float(np.median(luma)),
            burnt=_extreme_share(luma) - self._extreme,
            debris=0,
            patchiness=0,
            halo=0,
            face=abs(correlation(_features(luma, FACE_BAND_PX), self._features)),
            face_outlines=abs(correlation(_features(luma, FACE_OUTLINE_BAND_PX), self._outlines)),
        )


def _part(face: Box[float], shape: tuple[int, ...]) -> tuple[slice, slice] | None:
    """Return where a face is in a crop; None if too little of it is."""
    left, top, right, bottom = map(round, face.intersection(Box(0, 0, shape[1], shape[0])))
    if right - left < MIN_FACE_SHARE * face.width or bottom - top < MIN_FACE_SHARE * face.height:
        return None
    return np.s_[top:bottom, left:right]


def _edge_hardness(luma: np.ndarray) -> float:
    square = np.ones((STEP_SIDE_PX, STEP_SIDE_PX))
    step = cv2.dilate(luma, square) - cv2.erode(luma, square)
    edges = step > MIN_STEP
    if not edges.any():
        return 0.0
    return float(np.percentile(2 * gradient_of(luma)[edges] / step[edges], HARD_PERCENTILE))


def _marks(luma: np.ndarray) -> tuple[list[float], list[float]]:
    """Return the mean height of dark and of bright marks up to each width."""
    small = _reduced(luma, MARK_FACTOR)
    dark, bright = list[float](), list[float]()
    for radius in MARK_RADII_PX:
        element = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
        dark.append(float(cv2.morphologyEx(small, cv2.MORPH_BLACKHAT, element).mean()))
        bright.append(float(cv2.morphologyEx(small, cv2.MORPH_TOPHAT, element).mean()))
    return dark, bright


def _extreme_share(luma: np.ndarray) -> float:
    return float((luma > WHITE_LEVEL).mean() + (luma < BLACK_LEVEL).mean())


def _features(luma: np.ndarray, band: tuple[float, float]) -> np.ndarray:
    """Return band-passed luma of a face at `FACE_WIDTH_PX`."""
    size = FACE_WIDTH_PX, max(1, round(FACE_WIDTH_PX * luma.shape[0] / luma.shape[1]))
    return _band(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), *band)


def _reduced(luma: np.ndarray, factor: int) -> np.ndarray:
    height, width = luma.shape
    size = max(1, width // factor), max(1, height // factor)
    return cv2.resize(luma, size, interpolation=cv2.INTER_AREA)


def _band(luma: np.ndarray, fine: float, coarse: float) -> np.ndarray:
    return cv2.GaussianBlur(luma, (0, 0), fine) - cv2.GaussianBlur(luma, (0, 0), coarse)
