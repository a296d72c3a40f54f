"""Measures of styles at the size that people see, on crops of the picture.

A blurred picture looks sharp when it is reduced. Crops show what a style does to edges, texture and faces, in
a fraction of the time that the whole picture takes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.explore.measure import correlation, gradient_of, luma_of_codes, reduce_picture
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.regions.boxes import Box
from vidstyle.regions.still_faces import StillFaces
from vidstyle.style import Style

MAX_SIDE_PX = 1920
"""Longer side of the picture of which crops are measured."""
CROP_WIDTH_PX, CROP_HEIGHT_PX = 320, 240
MARGIN_PX = 24
"""Rendered around a crop, but not measured: wide filters differ near borders."""
SUBJECT_CROP_COUNT = 2
"""Crops with the most edges; another one shows the largest face."""
MIN_EDGE, MIN_GRADIENT, SPECKLE_DEVIATION_PX = 0.01, 1 / 255, 3
COARSE_FACTOR = 4
"""Reduction to which the sharpness of edges is compared: a sharp edge is equally steep in both."""
EDGE_PERCENTILE, STRONG_EDGE_PERCENTILE = 90, 98
"""Percentiles of the gradient for usual and for strong edges."""
STRUCTURE_FACTOR = 2
"""Reduction at which edges are compared with the source."""
SHAPE_DEVIATIONS_PX, TONE_DEVIATION_PX = (3, 8), 10
"""Blurs between which luma shows shapes, and by which it shows tones."""
MAX_BLACK_LEVEL = 0.1
FACE_WIDTH_PX, FACE_DEVIATIONS_PX = 64, (1, 4)
"""Width of a face for comparison with the source, and the band of eyes and mouth."""
MIN_FACE_SIDE_PX, MAX_FACE_COUNT = 24.0, 3
"""Smaller faces have no features to keep; of many faces the largest are compared."""
MAX_FACE_LIKENESS = 1.0


class FullSizeMetrics(NamedTuple):
    """Metrics of a style in crops at full size, means of the crops; luma is 0..1.

    Attributes:
        edge_sharpness: steepness of edges relative to a copy reduced by `COARSE_FACTOR`: 1 for edges that are
            one pixel wide, 1 / `COARSE_FACTOR` for smears.
        edge_height: gradient of strong edges.
        structure: correlation of the gradients with the source, reduced by `STRUCTURE_FACTOR`.
        weakest_structure: the lowest structure of a crop.
        shapes_kept: correlation of band-passed luma with the source; negative for negatives.
        tones_kept: correlation of blurred luma with the source, in the worst crop.
        crop_contrast: standard deviation of luma.
        speckle: mean deviation of luma from its surroundings where the source is flat.
        flatness: share of pixels without a gradient.
        black: share of pixels darker than `MAX_BLACK_LEVEL`.
        face: absolute correlation of facial features with the source, for the worst face;
            `MAX_FACE_LIKENESS` without a face.
    """

    edge_sharpness: float
    edge_height: float
    structure: float
    weakest_structure: float
    shapes_kept: float
    tones_kept: float
    crop_contrast: float
    speckle: float
    flatness: float
    black: float
    face: float


class FullSize:
    """Crops of a picture, H x W x 3 uint8, on which styles are measured."""

    def __init__(self, picture: np.ndarray) -> None:
        picture = reduce_picture(picture, MAX_SIDE_PX)
        faces = _faces(picture)
        self._crops = [_Crop(picture, box) for box in _crop_boxes(picture, faces)]
        self._faces = [_FaceCrop(picture, face) for face in faces]

    def measure(self, style: Style) -> FullSizeMetrics:
        """Return the metrics of a style; renders the crops, one after the other."""
        rows = [crop.measure(style) for crop in self._crops]
        means = FullSizeMetrics(*np.mean(rows, axis=0).tolist())
        return means._replace(
            weakest_structure=min(row.structure for row in rows),
            tones_kept=min(row.tones_kept for row in rows),
            face=min((face.likeness(style) for face in self._faces), default=MAX_FACE_LIKENESS),
        )


class _Crop:
    """Part of a picture with a margin; compares it with its rendering."""

    def __init__(self, picture: np.ndarray, box: Box[int]) -> None:
        height, width = picture.shape[:2]
        left, top = max(box.left - MARGIN_PX, 0), max(box.top - MARGIN_PX, 0)
        right, bottom = min(box.right + MARGIN_PX, width), min(box.bottom + MARGIN_PX, height)
        self.source = np.ascontiguousarray(picture[top:bottom, left:right])
        self._inner = np.s_[box.top - top : box.bottom - top, box.left - left : box.right - left]
        self._height_ratio = self.source.shape[0] / height
        self._luma = luma_of_codes(self.source[self._inner])
        gradient = gradient_of(cv2.GaussianBlur(self._luma, (0, 0), 1.5))
        self._is_flat = gradient <= max(float(np.percentile(gradient, 50)), 0.004)

    def render(self, style: Style) -> np.ndarray:
        """Return the crop in a style, without the margin; lengths are those in the whole picture."""
        if style.height:
            style = replace(style, height=style.height * self._height_ratio)
        return restyle_picture(self.source, style)[self._inner]

    def measure(self, style: Style) -> FullSizeMetrics:
        """Return the metrics of one crop, without faces."""
        luma, source = luma_of_codes(self.render(style)), self._luma
        gradient, coarse = gradient_of(luma), gradient_of(_reduced(luma, COARSE_FACTOR))
        edge, strong = np.percentile(gradient, (EDGE_PERCENTILE, STRONG_EDGE_PERCENTILE))
        structure = correlation(_structure(luma), _structure(source))
        return FullSizeMetrics(
            edge_sharpness=float(edge / max(np.percentile(coarse, EDGE_PERCENTILE), MIN_EDGE)),
            edge_height=float(strong),
            structure=structure,
            weakest_structure=structure,
            shapes_kept=correlation(_band(luma, *SHAPE_DEVIATIONS_PX), _band(source, *SHAPE_DEVIATIONS_PX)),
            tones_kept=correlation(_blurred(luma, TONE_DEVIATION_PX), _blurred(source, TONE_DEVIATION_PX)),
            crop_contrast=float(luma.std()),
            speckle=float(np.abs(_band(luma, 0, SPECKLE_DEVIATION_PX))[self._is_flat].mean()),
            flatness=float((gradient < MIN_GRADIENT).mean()),
            black=float((luma < MAX_BLACK_LEVEL).mean()),
            face=MAX_FACE_LIKENESS,
        )


class _FaceCrop:
    """A face of the picture."""

    def __init__(self, picture: np.ndarray, face: Box[int]) -> None:
        self._crop = _Crop(picture, face)
        self._features = _features(picture[face.top : face.bottom, face.left : face.right])

    def likeness(self, style: Style) -> float:
        """Return the absolute correlation of the features of the face with the source."""
        return abs(correlation(_features(self._crop.render(style)), self._features))


def _features(face: np.ndarray) -> np.ndarray:
    """Return band-passed luma of a face at `FACE_WIDTH_PX`."""
    size = FACE_WIDTH_PX, max(1, round(FACE_WIDTH_PX * face.shape[0] / face.shape[1]))
    luma = cv2.resize(luma_of_codes(face), size, interpolation=cv2.INTER_AREA)
    return _band(luma, *FACE_DEVIATIONS_PX)


def _structure(luma: np.ndarray) -> np.ndarray:
    """Return the root of the gradient, so that strong edges do not hide the others."""
    return np.sqrt(gradient_of(_reduced(luma, STRUCTURE_FACTOR)))


def _reduced(luma: np.ndarray, factor: int) -> np.ndarray:
    height, width = luma.shape
    size = max(1, width // factor), max(1, height // factor)
    return cv2.resize(luma, size, interpolation=cv2.INTER_AREA)


def _blurred(luma: np.ndarray, deviation: float) -> np.ndarray:
    return cv2.GaussianBlur(luma, (0, 0), deviation) if deviation else luma


def _band(luma: np.ndarray, fine: float, coarse: float) -> np.ndarray:
    return _blurred(luma, fine) - _blurred(luma, coarse)


def _faces(picture: np.ndarray) -> list[Box[int]]:
    """Return the largest faces of a picture, the largest first."""
    height, width = picture.shape[:2]
    boxes = [box.scaled(height) for box in StillFaces().find("", lambda: picture).boxes[:MAX_FACE_COUNT]]
    return [
        Box(
            max(round(box.left), 0),
            max(round(box.top), 0),
            min(round(box.right), width),
            min(round(box.bottom), height),
        )
        for box in boxes
        if min(box.width, box.height) >= MIN_FACE_SIDE_PX
    ]


def _crop_boxes(picture: np.ndarray, faces: Sequence[Box[int]]) -> list[Box[int]]:
    """Return the parts with the most edges that do not overlap, those with the largest face first."""
    height, width = picture.shape[:2]
    rows, columns = min(CROP_HEIGHT_PX, height), min(CROP_WIDTH_PX, width)
    edges = gradient_of(cv2.GaussianBlur(luma_of_codes(picture), (0, 0), 3))
    # Away from the borders, where the subject is; the root, so that one strong edge does not decide.
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    weights = np.sqrt(edges) * np.exp(-(x * x + y * y))
    sums = cv2.integral(weights)
    scores = (sums[rows:, columns:] - sums[:-rows, columns:]) - (
        sums[rows:, :-columns] - sums[:-rows, :-columns]
    )
    boxes: list[Box[int]] = []

    def take(top: int, left: int) -> None:
        boxes.append(Box(left, top, left + columns, top + rows))
        scores[max(top - rows, 0) : top + rows, max(left - columns, 0) : left + columns] = -1

    for face in faces[:1]:
        middle_y, middle_x = (face.top + face.bottom) // 2, (face.left + face.right) // 2
        top, left = middle_y - rows // 2, middle_x - columns // 2
        take(min(max(top, 0), height - rows), min(max(left, 0), width - columns))
    while len(boxes) < SUBJECT_CROP_COUNT + bool(faces) and scores.max() >= 0:
        top, left = np.unravel_index(int(scores.argmax()), scores.shape)
        take(int(top), int(left))
    return boxes
