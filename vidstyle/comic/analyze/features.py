"""Candidate key frames and the features by which they are scored, measured on small copies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.comic.analyze.defects import Blockiness, count_block_corners, is_test_picture
from vidstyle.comic.analyze.saliency import find_blobs, saliency_map, salient_box
from vidstyle.comic.analyze.similarity import make_thumbnail
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box, Point
from vidstyle.regions.faces import (
    LARGE_FACE_HEIGHT_RATIO,
    MIN_FACE_HEIGHT_RATIO,
    SEARCHED_HEIGHT_RATIO,
    FaceFinder,
)

MEASURED_SIDE_PX = 640
"""Longer side of the copies that are measured: small enough to be fast, large enough to show blur."""

# Sharpness.
_FINE_DEVIATION_PX, _COARSE_DEVIATION_PX = 0.7, 2.5
"""Standard deviations of the two Gaussians under which edges are compared."""
_STRONG_EDGE_SHARE = 0.03
"""Share of pixels, those with the strongest edges, on which sharpness is measured."""

# Clarity.
_MAX_BLANK_RANGE = 0.1
"""Maximum range of lightness of a blank picture between percentiles 2 and 98, 0..1."""
_FULL_CONTRAST_DEVIATION = 0.18
"""Standard deviation of lightness of a picture with full contrast, 0..1."""
_FULL_LIGHT_LEVEL = 0.43
"""Percentile 80 of lightness of a well-lit picture, 0..1."""
_FULL_FORMS_DEVIATION = 0.16
"""Standard deviation of lightness and chroma together of a picture with distinct large forms, 0..1."""
_FORMS_SIDE_PX, _FORMS_BLUR_PX = 64, 2.0
"""Longer side of the copy in which large forms are measured, and standard deviation of its Gaussian."""
_MAX_CLIPPED_SHARE = 0.3
"""Share of a picture that may be clipped without penalty, for nights and skies."""

# Letterbox bars.
_MAX_BAR_LEVEL, _MAX_BAR_RANGE = 30, 12
"""Lightest pixel of a bar, and largest difference within one of its lines, of 255."""
_MIN_BAR_SHARE, _MAX_BAR_SHARE = 0.02, 0.35
"""Range of the share of the picture's side that a bar takes."""

# Damage: decoders repeat the last good rows downwards.
_SMEAR_HEIGHT_PX, _MIN_SMEAR_LEVELS = 12, 6.0
"""Height of a smear, and minimum mean difference between neighbouring pixels of its rows, of 255."""
_MAX_SMEARED_SHARE = 0.03
"""A picture is damaged if a larger share of it is smeared."""

# The whole of a moving subject.
_MAX_GROWTH_RATIO = 2.0
"""Maximum area of a moving subject with a blob that belongs to it, relative to its area without the blob."""

# Following a face from one frame to another.
_FOLLOW_RANGE_RATIO, _MIN_FOLLOW_CORRELATION = 0.6, 0.6
"""Search range in heights of the face, and minimum correlation of the match."""


class Foreground(NamedTuple):
    """The moving subject in front of a still camera, in one frame of its shot.

    Attributes:
        places: mask of the subject in the thumbnail, H x W bool.
        box: around it, in pixels of the picture.
        share: its area relative to its usual area in the shot, 0..1.
        cut: how much of it the picture's edge cuts off, 0..1.
        is_gone: whether the frame shows only the background.
    """

    places: np.ndarray
    box: Box
    share: float
    cut: float
    is_gone: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class Candidate(KeyFrame):
    """A candidate key frame and its features.

    Attributes:
        sharpness: 0..1, by the width of its strongest edges, in the direction in which they are wider.
        clarity: 0..1, lower in the dark, with large black or white areas, and without distinct large forms.
        blank: whether the picture is black, white or one tone.
        thumbnail: the copy that is compared with other pictures, see `similarity`.
        histogram: shares of 64 colours, float32, of sum 1.
        eyes: contrast around the eyes of the largest face, higher with open eyes; 0 without a face.
        motion: see `ShotFinder.push`; 0 if only key frames were decoded.
        flow: how far each part moves during an exposure, see `FlowMeter`; None if it is not known.
        action: the moving subject in front of a still camera; None if the camera moves, or nothing does.
        in_transition: whether it shows a blend of two shots, or a fade.
        damaged: whether it shows errors of decoding.
        blurred: whether it is blurred by motion, compared with the film.
        combed: whether it mixes two interlaced fields.
        test_picture: whether it shows the bars of a test picture.
        blockiness: see `measure_blockiness`.
        block_corners: see `count_block_corners`.
        key_run: the number of key frames up to it; frames of one run are predicted from each other.
        forced: whether it was requested by its time.
        small: a small copy without letterbox bars, as long as subjects may still be detected in it.
    """

    sharpness: float
    clarity: float
    blank: bool
    thumbnail: np.ndarray
    histogram: np.ndarray
    eyes: float = 0.0
    motion: float = 0.0
    flow: np.ndarray | None = None
    action: Foreground | None = None
    in_transition: bool = False
    damaged: bool = False
    blurred: bool = False
    combed: bool = False
    test_picture: bool = False
    blockiness: Blockiness = Blockiness()
    block_corners: int = 0
    key_run: int = 0
    forced: bool = False
    small: np.ndarray | None = None

    @property
    def is_flawed(self) -> bool:
        """Whether no panel may show it."""
        return (
            (self.blank or self.test_picture or self.in_transition)
            or self.damaged
            or self.blurred
            or self.combed
        )


@dataclass(frozen=True)
class Survey:
    """The result of analysing a film.

    Attributes:
        candidates: in the order of time.
        scene_starts: start time of each scene in seconds.
        seconds: the duration, as far as the film could be read.
        is_folder: whether these are separate pictures that the user has already selected.
    """

    candidates: list[Candidate]
    scene_starts: list[float]
    seconds: float
    is_folder: bool = False


def extract_features(
    color: np.ndarray, time: float, shape: tuple[int, int], is_photograph: bool = False
) -> Candidate:
    """Measure the features of a single picture, independent of its neighbours and without subjects.

    Args:
        color: a small copy, H x W x 3 uint8.
        time: in seconds.
        shape: height and width of the whole picture.
        is_photograph: whether its black borders may have different widths.
    """
    rows, columns = content_area(color, is_photograph)
    factor = shape[1] / color.shape[1]
    left, top = round(columns.start * factor), round(rows.start * factor)
    inner = round(rows.stop * factor) - top, round(columns.stop * factor) - left
    color = np.ascontiguousarray(color[rows, columns])
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)
    return Candidate(
        time,
        inner,
        importance=0.0,
        saliency=Box(0.0, 0.0, float(inner[1]), float(inner[0])),
        faces=(),
        scene=0,
        offset=(left, top),
        sharpness=measure_sharpness(luma),
        clarity=measure_exposure(luma) * measure_forms(color),
        blank=is_blank(luma),
        test_picture=is_test_picture(color),
        light=float(luma.mean()) / 255,
        damaged=is_smeared(luma),
        block_corners=count_block_corners(luma),
        thumbnail=make_thumbnail(color),
        histogram=color_histogram(color),
        small=color,
    )


def add_faces(
    candidate: Candidate, faces: FaceFinder, only_large: bool = False, others: Sequence[Candidate] = ()
) -> Candidate:
    """Return the candidate with the faces detected in its small copy, if it has one.

    Args:
        candidate: a frame.
        faces: detects them.
        only_large: whether small faces are ignored.
        others: other frames of its shot with their large faces. With two or more of them, a large face counts
            only if it is near one of theirs, and a face that two of them have in common is followed.
    """
    color = candidate.small
    if color is None:
        return candidate
    searched = SEARCHED_HEIGHT_RATIO if only_large else MIN_FACE_HEIGHT_RATIO
    mouths, factor = faces.find(color, searched), candidate.shape[1] / color.shape[1]
    if len(others) > 1:
        least, seen = (
            LARGE_FACE_HEIGHT_RATIO * color.shape[0],
            [face.scaled(1 / factor) for each in others for face in each.faces],
        )
        mouths = {face: mouths[face] for face in mouths if face.height < least or _overlaps(face, seen)}
        for face, mouth in follow_faces(candidate, others).items():
            if not _overlaps(face, list(mouths)):
                mouths[face] = mouth
    found = sorted(mouths, key=lambda face: -face.area)
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)
    eyes = eye_contrast(luma, found[0]) if found else 0.0
    scaled = {face.scaled(factor): (mouths[face][0] * factor, mouths[face][1] * factor) for face in found}
    return replace(candidate, faces=tuple(scaled), mouths=scaled, eyes=eyes)


def follow_faces(candidate: Candidate, frames: Sequence[Candidate]) -> dict[Box, Point]:
    """Find faces of other frames again in the small copy of a candidate.

    Two of the frames must have a face in the same place, so that a single error is not followed.

    Returns:
        The faces and their mouths, in pixels of the small copy.
    """
    found = dict[Box, Point]()
    for each in frames:
        others = [face for other in frames if other is not each for face in other.faces]
        for face in each.faces:
            if _overlaps(face, others) and not _overlaps(face, [*candidate.faces, *found]):
                found |= _follow_face(candidate, each, face)
    return found


def _follow_face(candidate: Candidate, other: Candidate, face: Box) -> dict[Box, Point]:
    if candidate.small is None or other.small is None or candidate.small.shape != other.small.shape:
        return {}
    factor = candidate.small.shape[1] / candidate.shape[1]
    height, width = candidate.small.shape[:2]
    place = Box(*map(round, face.scaled(factor))).intersection(Box(0, 0, width, height))
    reach = round(_FOLLOW_RANGE_RATIO * place.height)
    around = place.padded(reach, reach, reach).intersection(Box(0, 0, width, height))
    seen, template = (
        np.ascontiguousarray(picture[box.top : box.bottom, box.left : box.right])
        for picture, box in ((candidate.small, around), (other.small, place))
    )
    _, likeness, _, (right, down) = cv2.minMaxLoc(cv2.matchTemplate(seen, template, cv2.TM_CCOEFF_NORMED))
    if likeness < _MIN_FOLLOW_CORRELATION:
        return {}
    moved = around.left + right - place.left, around.top + down - place.top
    across, low = other.mouth(face)
    return {place.moved(*moved): (across * factor + moved[0], low * factor + moved[1])}


def _overlaps(face: Box, others: Sequence[Box]) -> bool:
    return any(face.intersection(other).area > 0 for other in others)


def add_saliency(candidate: Candidate) -> Candidate:
    """Return the candidate with the salient box and the blobs of its small copy, and without that copy.

    A candidate without a small copy is returned unchanged.
    """
    color = candidate.small
    if color is None:
        return candidate
    factor = candidate.shape[1] / color.shape[1]
    blobs = find_blobs(color)
    faces = [face.scaled(1 / factor) for face in candidate.faces]
    subject = candidate.action.box if candidate.action and not candidate.action.is_gone else None
    if subject is not None:
        saliency = part = subject.scaled(1 / factor)
        blobs = [blob for blob in blobs if _belongs_to(blob, part)]
    else:
        saliency = salient_box(saliency_map(color, faces))
    for blob in blobs:
        saliency = saliency.union(blob)
    scaled = tuple(blob.scaled(factor) for blob in blobs)
    if subject is not None:
        subject = saliency.scaled(factor)
    return replace(candidate, saliency=saliency.scaled(factor), blobs=scaled, subject=subject, small=None)


def _belongs_to(blob: Box, subject: Box) -> bool:
    """Whether a blob is a part of a subject: it meets its box, and is not much larger, as the ground is."""
    return (
        blob.intersection(subject).area > 0 and blob.union(subject).area <= _MAX_GROWTH_RATIO * subject.area
    )


def measure_sharpness(luma: np.ndarray) -> float:
    """Measure sharpness by the width of the strongest edges, H x W uint8: 0 blurred, 1 perfectly sharp.

    The slope of an edge under a narrow Gaussian, divided by its slope under a wide one, gives its width
    independent of its height. A pan blurs the edges of one direction only, so the wider direction counts.
    """
    fine, coarse = (_slopes(luma, deviation) for deviation in (_FINE_DEVIATION_PX, _COARSE_DEVIATION_PX))
    number = max(1, round(_STRONG_EDGE_SHARE * luma.size))
    heights, widths = [], []
    for thin, wide in zip(fine, coarse, strict=True):
        strongest = np.argpartition(wide.ravel(), -number)[-number:]
        heights.append(float(wide.ravel()[strongest].mean()))
        widths.append(float(thin.ravel()[strongest].mean()) / max(heights[-1], 1e-6))
    # If all edges have one direction, the other direction contains only noise.
    counted = [width for width, height in zip(widths, heights, strict=True) if height > 0.3 * max(heights)]
    best = _COARSE_DEVIATION_PX / _FINE_DEVIATION_PX
    return float(np.clip((min(counted, default=0) - 1) / (best - 1), 0, 1))


def _slopes(luma: np.ndarray, deviation: float) -> tuple[np.ndarray, np.ndarray]:
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), deviation)
    return np.abs(cv2.Sobel(smooth, -1, 1, 0, ksize=1)), np.abs(cv2.Sobel(smooth, -1, 0, 1, ksize=1))


def measure_exposure(luma: np.ndarray) -> float:
    """Measure how well a picture, H x W uint8, is exposed: 0..1."""
    contrast = min(1.0, float(luma.std()) / 255 / _FULL_CONTRAST_DEVIATION)
    light = min(1.0, _percentiles(luma, 80)[0] / 255 / _FULL_LIGHT_LEVEL)
    clipped = float(np.mean((luma < 10) | (luma > 250)))
    return contrast * light * (1 - max(0.0, clipped - _MAX_CLIPPED_SHARE) / (1 - _MAX_CLIPPED_SHARE))


def measure_forms(color: np.ndarray) -> float:
    """Measure the contrast of the large forms of a picture, H x W x 3 uint8: 0..1.

    In print, large forms remain recognizable in a panel whose details are too small.
    """
    factor = _FORMS_SIDE_PX / max(color.shape)
    height, width = (max(1, round(side * factor)) for side in color.shape[:2])
    small = cv2.resize(color, (width, height), interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)
    coarse = cv2.GaussianBlur(lab, (0, 0), _FORMS_BLUR_PX)
    return min(1.0, float(np.sqrt(coarse.var(axis=(0, 1)).sum())) / 255 / _FULL_FORMS_DEVIATION)


def is_blank(luma: np.ndarray) -> bool:
    """Whether the picture, H x W uint8, is black, white or one tone."""
    darkest, brightest = _percentiles(cv2.GaussianBlur(luma, (0, 0), 2), 2, 98)
    return brightest - darkest < 255 * _MAX_BLANK_RANGE


def _percentiles(luma: np.ndarray, *shares: float) -> list[int]:
    """Return percentiles of H x W uint8."""
    counts = np.bincount(luma.ravel(), minlength=256).cumsum()
    return [int(np.searchsorted(counts, share / 100 * luma.size)) for share in shares]


def is_smeared(luma: np.ndarray) -> bool:
    """Whether rows of the picture, H x W uint8, are repeated downwards, as in incompletely decoded frames."""
    if min(luma.shape) <= 2 * _SMEAR_HEIGHT_PX:
        return False
    steps = cv2.blur(cv2.absdiff(luma[1:, 1:], luma[1:, :-1]), (9, 1))
    down = cv2.dilate(cv2.absdiff(luma[1:, 1:], luma[:-1, 1:]), np.ones((_SMEAR_HEIGHT_PX, 3), np.uint8))
    return bool(np.mean((down <= 1) & (steps >= _MIN_SMEAR_LEVELS)) > _MAX_SMEARED_SHARE)


def color_histogram(color: np.ndarray) -> np.ndarray:
    """Return the shares of 64 colours in a picture, H x W x 3 uint8: float32 of sum 1."""
    small = cv2.resize(color, (48, 48), interpolation=cv2.INTER_AREA)
    counts = cv2.calcHist([small], [0, 1, 2], None, [4, 4, 4], [0, 256] * 3).ravel()
    return (counts / counts.sum()).astype(np.float32)


def eye_contrast(luma: np.ndarray, face: Box) -> float:
    """Return the vertical contrast in the band of a face that contains the eyes, 0..1."""
    top, bottom = round(face.top + 0.25 * face.height), round(face.top + 0.5 * face.height)
    left, right = round(face.left + 0.15 * face.width), round(face.right - 0.15 * face.width)
    band = luma[max(0, top) : bottom, max(0, left) : right].astype(np.float32)
    if band.shape[0] < 3 or band.shape[1] < 3:
        return 0.0
    return float(np.abs(np.diff(band, axis=0)).mean()) / 255


def content_area(color: np.ndarray, is_photograph: bool = False) -> tuple[slice, slice]:
    """Return the rows and columns of a picture inside its black bars; all of them if there are no bars.

    Args:
        color: H x W x 3 uint8.
        is_photograph: whether each side may have its own bar. The bars of a film are equal at opposite sides,
            and a dark side is not one.
    """
    red, green, blue = cv2.split(color)
    luma = cv2.max(cv2.max(red, green), blue)
    return _find_content_span(luma, 1, is_photograph), _find_content_span(luma, 0, is_photograph)


def _find_content_span(luma: np.ndarray, axis: int, is_photograph: bool) -> slice:
    brightest, darkest = (
        cv2.reduce(luma, axis, kind).ravel().astype(int) for kind in (cv2.REDUCE_MAX, cv2.REDUCE_MIN)
    )
    shown = np.flatnonzero((brightest > _MAX_BAR_LEVEL) | (brightest - darkest > _MAX_BAR_RANGE))
    count = len(brightest)
    bars = (int(shown[0]), count - 1 - int(shown[-1])) if len(shown) else (0, 0)
    bars = bars if is_photograph else (min(bars),) * 2
    # One more line, as scaling has mixed bar and picture there.
    first, last = (bar + 1 if _MIN_BAR_SHARE * count <= bar <= _MAX_BAR_SHARE * count else 0 for bar in bars)
    return slice(first, count - last)
