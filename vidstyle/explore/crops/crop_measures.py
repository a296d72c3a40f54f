"""Measures of a crop of a restyled picture at full size, compared with the same crop of its source."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.explore.crops.debris import SourceAreas
from vidstyle.explore.crops.texture import SourceTexture, compare_squares
from vidstyle.explore.measure import band_pass, correlation, gradient_of, luma_of_codes
from vidstyle.regions.boxes import Box

FINEST_BAND_PX, FINE_BAND_PX, DETAIL_BAND_PX = (0.5, 1), (1, 2), (2, 4)
"""Standard deviations of the two blurs between which detail of a size is seen."""
MIN_FINEST, MIN_DETAIL = 0.003, 0.005
"""What is added to the strength of a band, so that the ratio of two weak ones means nothing."""
STEP_SIDE_PX, MIN_STEP = 5, 0.12
"""Side of the square in which an edge is a step of luma, and the smallest step that counts as an edge."""
HARD_PERCENTILE = 75
MARK_FACTOR = 2
"""Reduction at which the width of marks is measured."""
NARROW_RADIUS_PX, WIDE_RADIUS_PX = 2, 14
"""Radii of the structuring elements that extract narrow marks, and marks of any width, when reduced."""
WHITE_LEVEL, BLACK_LEVEL = 0.93, 0.07
FACE_WIDTH_PX, FACE_BAND_PX, FACE_OUTLINE_BAND_PX = 64, (1, 4), (0.7, 2)
"""Width of a face for comparison with the source, and the bands of eyes and mouth, and of their outlines."""
MAX_FACE_COUNT, MIN_FACE_SHARE = 3, 0.7
"""Of many faces in a crop, the largest are compared, if this share of their height and width is in it, or of
the height and width of the crop, where the face is larger."""
FACE_SQUARE_PX = 13
"""Side of the squares in which a face is compared, at `FACE_WIDTH_PX`."""
MAX_FACE_LIKENESS = 1.0
TONE_COUNT, COMMON_TONE_COUNT = 64, 12


class FullSizeMetrics(NamedTuple):
    """Metrics of a restyled crop; luma is 0..1.

    Where the crop shows faces, the worst face counts instead of the crop, or the worst of both, as people
    judge a picture by its faces.

    Attributes:
        likeness: correlation of luma detail of 1 to 2 pixels with the source, in the whole crop also if it
            shows faces.
        detail_kept: the same for 2 to 4 pixels, in the worst face.
        fineness: logarithm of the strength of detail of one pixel relative to that of four: high if edges are
            crisp, low if the picture is soft.
        edge_hardness: steepness of edges relative to their height, upper quartile; 1 for edges of one pixel.
        mark_width: the height of dark and bright marks of any width relative to that of narrow ones.
        burnt: share of pixels that are nearly white or black, less that of the source.
        debris: mean height of structure where the source is smooth.
        patchiness: deviation of that height between places: a regular screen has little, worms have much.
        halo: mean height of bright rims along edges, less the height in the source with stretched contrast.
        has_face: whether the crop shows a face that is large enough.
        face: absolute correlation of facial features with the source; `MAX_FACE_LIKENESS` without a face.
        face_outlines: the same for outlines of features, which smears and blots destroy before the features.
        face_structure: correlation of outlines of features in small squares of the face, weighted by their
            strength in the source.
        structure_kept: see `Texture`; of the whole crop.
        smeared: the same.
        tone_concentration: share of pixels in the `COMMON_TONE_COUNT` most frequent of `TONE_COUNT` tones:
            high for flat tones, low for gradients and blur.
        parts: see `parts_favor`; 0 where the style is not known.
    """

    likeness: float
    detail_kept: float
    fineness: float
    edge_hardness: float
    mark_width: float
    burnt: float
    debris: float
    patchiness: float
    halo: float
    has_face: bool
    face: float
    face_outlines: float
    face_structure: float
    structure_kept: float
    smeared: float
    tone_concentration: float
    parts: float = 0.0


class ComparedCrop:
    """A crop of the source, H x W x 3 uint8, and the faces in it, the largest first."""

    def __init__(self, source: np.ndarray, faces: Sequence[Box[float]]) -> None:
        luma = luma_of_codes(source)
        self._whole, self._areas, self._texture = _Region(source), SourceAreas(luma), SourceTexture(luma)
        parts = [part for face in faces if (part := _part(face, source.shape)) is not None][:MAX_FACE_COUNT]
        self._faces = [(part, _Region(source[part])) for part in parts]

    @property
    def has_faces(self) -> bool:
        """Whether faces are compared."""
        return bool(self._faces)

    def face_likeness(self, result: np.ndarray) -> float:
        """Return `face` of `measure`: the features of the worst face; `MAX_FACE_LIKENESS` without a face."""
        faces = (region.face_likeness(luma_of_codes(result[part])) for part, region in self._faces)
        return min(faces, default=MAX_FACE_LIKENESS)

    def measure(self, result: np.ndarray) -> FullSizeMetrics:
        """Return the metrics of the crop in a style, H x W x 3 uint8."""
        luma = luma_of_codes(result)
        of_crop = {
            **self._areas.added(luma)._asdict(),
            **self._texture.compared(luma)._asdict(),
            "tone_concentration": _tone_concentration(luma),
        }
        whole = self._whole.measure(result)._replace(**of_crop)
        faces = [region.measure(result[part]) for part, region in self._faces]
        if not faces:
            none = dict.fromkeys(("face", "face_outlines", "face_structure"), MAX_FACE_LIKENESS)
            return whole._replace(has_face=False, **none)
        face, low, high = (
            FullSizeMetrics(*of(rows, axis=0).tolist())
            for of, rows in ((np.min, faces), (np.min, [whole, *faces]), (np.max, [whole, *faces]))
        )
        return face._replace(
            likeness=whole.likeness,
            edge_hardness=low.edge_hardness,
            fineness=high.fineness,
            mark_width=low.mark_width,
            burnt=high.burnt,
            has_face=True,
            **of_crop,
        )


class _Region:
    """A part of the source, H x W x 3 uint8, prepared for comparison."""

    def __init__(self, source: np.ndarray) -> None:
        luma = luma_of_codes(source)
        self._fine, self._detail = band_pass(luma, *FINE_BAND_PX), band_pass(luma, *DETAIL_BAND_PX)
        self._extreme = _extreme_share(luma)
        self._features = _features(luma, FACE_BAND_PX)
        self._outlines = _features(luma, FACE_OUTLINE_BAND_PX)

    def measure(self, result: np.ndarray) -> FullSizeMetrics:
        """Return the metrics of this part in a style, as if it was a face."""
        luma = luma_of_codes(result)
        finest, detail = band_pass(luma, *FINEST_BAND_PX), band_pass(luma, *DETAIL_BAND_PX)
        outlines = _features(luma, FACE_OUTLINE_BAND_PX)
        return FullSizeMetrics(
            likeness=correlation(band_pass(luma, *FINE_BAND_PX), self._fine),
            detail_kept=correlation(detail, self._detail),
            fineness=float(np.log((finest.std() + MIN_FINEST) / (detail.std() + MIN_DETAIL))),
            edge_hardness=edge_hardness(luma),
            mark_width=_mark_height(luma, WIDE_RADIUS_PX)
            / max(_mark_height(luma, NARROW_RADIUS_PX), MIN_FINEST),
            burnt=_extreme_share(luma) - self._extreme,
            debris=0,
            patchiness=0,
            halo=0,
            has_face=True,
            face=self.face_likeness(luma),
            face_outlines=abs(correlation(outlines, self._outlines)),
            face_structure=_structure_kept(self._outlines, outlines),
            structure_kept=0,
            smeared=0,
            tone_concentration=0,
        )

    def face_likeness(self, luma: np.ndarray) -> float:
        """Return `face` of this part in a style, from its luma."""
        return abs(correlation(_features(luma, FACE_BAND_PX), self._features))


def _part(face: Box[float], shape: tuple[int, ...]) -> tuple[slice, slice] | None:
    """Return where a face is in a crop; None if too little of it is."""
    left, top, right, bottom = map(round, face.intersection(Box(0, 0, shape[1], shape[0])))
    width, height = min(face.width, shape[1]), min(face.height, shape[0])
    if right - left < MIN_FACE_SHARE * width or bottom - top < MIN_FACE_SHARE * height:
        return None
    return np.s_[top:bottom, left:right]


def edge_hardness(luma: np.ndarray) -> float:
    """Return the steepness of edges relative to their height, upper quartile; 1 for edges of one pixel."""
    square = np.ones((STEP_SIDE_PX, STEP_SIDE_PX))
    step = cv2.dilate(luma, square) - cv2.erode(luma, square)
    edges = step > MIN_STEP
    if not edges.any():
        return 0.0
    return float(np.percentile(2 * gradient_of(luma)[edges] / step[edges], HARD_PERCENTILE))


def _mark_height(luma: np.ndarray, radius: int) -> float:
    """Return the mean height of dark and bright marks up to a width."""
    small = _reduced(luma, MARK_FACTOR)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    dark, bright = (cv2.morphologyEx(small, kind, disc) for kind in (cv2.MORPH_BLACKHAT, cv2.MORPH_TOPHAT))
    return float(dark.mean() + bright.mean())


def _structure_kept(source: np.ndarray, result: np.ndarray) -> float:
    """Return the mean correlation in squares of a face, weighted by the strength in the source."""
    squares = compare_squares(source, result, FACE_SQUARE_PX)
    return float(
        (squares.correlation * squares.source_strength).sum() / max(squares.source_strength.sum(), 1e-6)
    )


def _tone_concentration(luma: np.ndarray) -> float:
    counts = np.sort(np.histogram(luma, TONE_COUNT, (0, 1))[0])
    return float(counts[-COMMON_TONE_COUNT:].sum() / luma.size)


def _extreme_share(luma: np.ndarray) -> float:
    return float((luma > WHITE_LEVEL).mean() + (luma < BLACK_LEVEL).mean())


def _features(luma: np.ndarray, band: tuple[float, float]) -> np.ndarray:
    """Return band-passed luma of a face at `FACE_WIDTH_PX`."""
    size = FACE_WIDTH_PX, max(1, round(FACE_WIDTH_PX * luma.shape[0] / luma.shape[1]))
    return band_pass(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), *band)


def _reduced(luma: np.ndarray, factor: int) -> np.ndarray:
    height, width = luma.shape
    size = max(1, width // factor), max(1, height // factor)
    return cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
