"""Candidate key frames and the features that they are scored by, measured on small copies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.comic.analyze.faces import LARGE, FaceFinder
from vidstyle.comic.analyze.saliency import find_blobs, saliency_map, salient_box
from vidstyle.comic.analyze.similarity import make_thumbnail
from vidstyle.comic.moment import Box, Moment, Point

SIDE = 640
"""Longer side in pixels of the copies that are measured: small enough to be quick, and blur still shows."""

_FINE, _COARSE = 0.7, 2.5
"""Deviations in pixels of the two Gaussians under which edges are compared."""
_EDGES = 0.03
"""Share of pixels, those with the strongest edges, that sharpness is measured on."""
_BLANK = 0.1
"""Maximum range of lightness of a blank picture between percentiles 2 and 98, 0..1."""
_DEFAULT_CONTRAST = 0.18
_DEFAULT_LIGHT = 0.43
"""So light is a fifth of a picture at least in which one sees well, 0..1."""
_DEFAULT_FORMS = 0.16
"""The deviation of lightness and chroma together, 0..1, of a picture whose large forms stand out."""
_FORMS_SIDE, _FORM = 64, 2.0
"""Longer side of the copy in which large forms are looked for, and the deviation of the Gaussian that leaves
them, in pixels."""
_CLIPPED = 0.3
"""Share of a picture that may be clipped without penalty: nights and skies."""
_BAR_LEVEL, _BAR_RANGE = 30, 12
"""The lightest pixel of a letterbox bar, and the largest difference within a line of it, of 255."""
_MIN_BAR, _MAX_BAR = 0.02, 0.35
"""The share of the picture's side that a bar takes."""
_SMEAR, _ACROSS = 12, 6.0
"""Rows over which a damaged picture repeats its last good one, and the mean step between their pixels."""
_REACH, _LIKE = 0.6, 0.6
"""How far a face is followed from one frame to another, in its heights, and the least correlation then."""
_SMEARED = 0.03
"""A picture is damaged if so much of it is smeared."""


class Foreground(NamedTuple):
    """What moves before a still camera, in one frame of its shot.

    Attributes:
        places: where it is in the thumbnail, H x W bool.
        box: around it, in pixels of the picture.
        share: of its usual area in the shot, 0..1.
        cut: how much of it the picture's edge cuts off, 0..1.
        is_gone: whether the frame shows the background alone.
    """

    places: np.ndarray
    box: Box
    share: float
    cut: float
    is_gone: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class Candidate(Moment):
    """A candidate key frame and its features.

    Attributes:
        sharpness: 0..1, by the width of its strongest edges, in the direction in which they are wider.
        clarity: 0..1, less in the dark, with large black or white areas, and where no large forms stand out.
        blank: whether the picture is black, white or one tone.
        thumbnail: what is compared with other pictures, see `similarity`.
        histogram: shares of 64 colours, float32, of sum 1.
        eyes: contrast about the eyes of the largest face, higher with open eyes; 0 without a face.
        motion: how much moves, as `ShotFinder.push` has it; 0 where only key frames have been seen.
        action: what moves before a still camera; None where the camera moves, or nothing.
        in_transition: whether it shows two shots, or one that is fading.
        damaged: whether it was not decoded completely.
        forced: whether it was requested by its time.
        small: a small copy without letterbox bars, as long as subjects may be looked for in it.
    """

    sharpness: float
    clarity: float
    blank: bool
    thumbnail: np.ndarray
    histogram: np.ndarray
    eyes: float = 0.0
    motion: float = 0.0
    action: Foreground | None = None
    in_transition: bool = False
    damaged: bool = False
    forced: bool = False
    small: np.ndarray | None = None


@dataclass(frozen=True)
class Survey:
    """The result of analysing a film.

    Attributes:
        candidates: in the order of time.
        scene_starts: when each scene begins, in seconds.
        seconds: the duration, as far as the film could be read.
        is_folder: whether these are single pictures that somebody has chosen already.
    """

    candidates: list[Candidate]
    scene_starts: list[float]
    seconds: float
    is_folder: bool = False


def extract_features(color: np.ndarray, time: float, shape: tuple[int, int]) -> Candidate:
    """The features that a picture has by itself, without its neighbours in a film and without subjects.

    Args:
        color: a small copy, H x W x 3 uint8.
        shape: height and width of the whole picture.
    """
    rows, columns = content_area(color)
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
        sharpness=sharpness(luma),
        clarity=exposure(luma) * forms(color),
        blank=is_blank(luma),
        light=float(luma.mean()) / 255,
        damaged=is_smeared(luma),
        thumbnail=make_thumbnail(color),
        histogram=color_histogram(color),
        small=color,
    )


def with_faces(
    candidate: Candidate, faces: FaceFinder, only_large: bool = False, beside: Sequence[Candidate] = ()
) -> Candidate:
    """The candidate with the faces that are found in its small copy, if it has one.

    Args:
        candidate: a frame.
        faces: finds them.
        only_large: whether smaller ones are not looked for.
        beside: other frames of its shot with their large faces: where there are two or more of them, a large
            face must be near one of theirs, or it is none, and one that two of them have is followed.
    """
    color = candidate.small
    if color is None:
        return candidate
    mouths, factor = faces.find(color, only_large), candidate.shape[1] / color.shape[1]
    if len(beside) > 1:
        least, seen = (
            LARGE * color.shape[0],
            [face.scaled(1 / factor) for each in beside for face in each.faces],
        )
        mouths = {face: mouths[face] for face in mouths if face.height < least or _is_seen(face, seen)}
        for face, mouth in followed(candidate, beside).items():
            if not _is_seen(face, list(mouths)):
                mouths[face] = mouth
    found = sorted(mouths, key=lambda face: -face.area)
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)
    eyes = eye_contrast(luma, found[0]) if found else 0.0
    scaled = {face.scaled(factor): (mouths[face][0] * factor, mouths[face][1] * factor) for face in found}
    return replace(candidate, faces=tuple(scaled), mouths=scaled, eyes=eyes)


def followed(candidate: Candidate, beside: Sequence[Candidate]) -> dict[Box, Point]:
    """Faces of frames beside one that are found again in its small copy, and their mouths, in its pixels.

    Two of the frames must have a face in one place, so that a single error is not followed.
    """
    found = dict[Box, Point]()
    for each in beside:
        others = [face for other in beside if other is not each for face in other.faces]
        for face in each.faces:
            if _is_seen(face, others) and not _is_seen(face, [*candidate.faces, *found]):
                found |= _found_again(candidate, each, face)
    return found


def _found_again(candidate: Candidate, other: Candidate, face: Box) -> dict[Box, Point]:
    if candidate.small is None or other.small is None or candidate.small.shape != other.small.shape:
        return {}
    factor = candidate.small.shape[1] / candidate.shape[1]
    height, width = candidate.small.shape[:2]
    place = Box(*map(round, face.scaled(factor))).intersection(Box(0, 0, width, height))
    reach = round(_REACH * place.height)
    around = place.padded(reach, reach, reach).intersection(Box(0, 0, width, height))
    seen, template = (
        np.ascontiguousarray(picture[box.top : box.bottom, box.left : box.right])
        for picture, box in ((candidate.small, around), (other.small, place))
    )
    _, likeness, _, (right, down) = cv2.minMaxLoc(cv2.matchTemplate(seen, template, cv2.TM_CCOEFF_NORMED))
    if likeness < _LIKE:
        return {}
    moved = around.left + right - place.left, around.top + down - place.top
    across, low = other.mouth(face)
    return {place.moved(*moved): (across * factor + moved[0], low * factor + moved[1])}


def _is_seen(face: Box, others: Sequence[Box]) -> bool:
    return any(face.intersection(other).area > 0 for other in others)


def with_saliency(candidate: Candidate) -> Candidate:
    """The candidate with the salient box and the blobs of its small copy, if it has one, and without that."""
    color = candidate.small
    if color is None:
        return candidate
    factor = candidate.shape[1] / color.shape[1]
    blobs = find_blobs(color)
    faces = [face.scaled(1 / factor) for face in candidate.faces]
    if candidate.action and not candidate.action.is_gone:
        saliency = candidate.action.box.scaled(1 / factor)
        blobs = [blob for blob in blobs if blob.intersection(saliency).area > 0]
    else:
        saliency = salient_box(saliency_map(color, faces))
    for blob in blobs:
        saliency = saliency.union(blob)
    scaled = tuple(blob.scaled(factor) for blob in blobs)
    return replace(candidate, saliency=saliency.scaled(factor), blobs=scaled, small=None)


def sharpness(luma: np.ndarray) -> float:
    """Sharpness by the width of the strongest edges, H x W uint8: 0 blurred, 1 as sharp as can be.

    The slope of an edge under a narrow Gaussian, compared with that under a wide one, tells its width
    whatever its height. A pan blurs the edges of one direction only: the wider ones count.
    """
    fine, coarse = (_slopes(luma, deviation) for deviation in (_FINE, _COARSE))
    number = max(1, round(_EDGES * luma.size))
    heights, widths = [], []
    for thin, wide in zip(fine, coarse, strict=True):
        strongest = np.argpartition(wide.ravel(), -number)[-number:]
        heights.append(float(wide.ravel()[strongest].mean()))
        widths.append(float(thin.ravel()[strongest].mean()) / max(heights[-1], 1e-6))
    # Where all edges have one direction, the other one holds only noise.
    counted = [width for width, height in zip(widths, heights, strict=True) if height > 0.3 * max(heights)]
    best = _COARSE / _FINE
    return float(np.clip((min(counted, default=0) - 1) / (best - 1), 0, 1))


def _slopes(luma: np.ndarray, deviation: float) -> tuple[np.ndarray, np.ndarray]:
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), deviation)
    return np.abs(cv2.Sobel(smooth, -1, 1, 0, ksize=1)), np.abs(cv2.Sobel(smooth, -1, 0, 1, ksize=1))


def exposure(luma: np.ndarray) -> float:
    """How well a picture is exposed, 0..1; H x W uint8."""
    contrast = min(1.0, float(luma.std()) / 255 / _DEFAULT_CONTRAST)
    light = min(1.0, _percentiles(luma, 80)[0] / 255 / _DEFAULT_LIGHT)
    clipped = float(np.mean((luma < 10) | (luma > 250)))
    return contrast * light * (1 - max(0.0, clipped - _CLIPPED) / (1 - _CLIPPED))


def forms(color: np.ndarray) -> float:
    """Contrast of the large forms of a picture, H x W x 3 uint8: 0..1.

    That is what is left of a panel in print when its details are too small to be told apart.
    """
    factor = _FORMS_SIDE / max(color.shape)
    height, width = (max(1, round(side * factor)) for side in color.shape[:2])
    small = cv2.resize(color, (width, height), interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)
    coarse = cv2.GaussianBlur(lab, (0, 0), _FORM)
    return min(1.0, float(np.sqrt(coarse.var(axis=(0, 1)).sum())) / 255 / _DEFAULT_FORMS)


def is_blank(luma: np.ndarray) -> bool:
    """Whether the picture, H x W uint8, is black, white or one tone."""
    darkest, brightest = _percentiles(cv2.GaussianBlur(luma, (0, 0), 2), 2, 98)
    return brightest - darkest < 255 * _BLANK


def _percentiles(luma: np.ndarray, *shares: float) -> list[int]:
    """Percentiles of H x W uint8."""
    counts = np.bincount(luma.ravel(), minlength=256).cumsum()
    return [int(np.searchsorted(counts, share / 100 * luma.size)) for share in shares]


def is_smeared(luma: np.ndarray) -> bool:
    """Whether rows of the picture, H x W uint8, are repeated downwards, as in frames not wholly decoded."""
    if min(luma.shape) <= 2 * _SMEAR:
        return False
    steps = cv2.blur(cv2.absdiff(luma[1:, 1:], luma[1:, :-1]), (9, 1))
    down = cv2.dilate(cv2.absdiff(luma[1:, 1:], luma[:-1, 1:]), np.ones((_SMEAR, 3), np.uint8))
    return bool(np.mean((down <= 1) & (steps >= _ACROSS)) > _SMEARED)


def color_histogram(color: np.ndarray) -> np.ndarray:
    """The shares of 64 colours in a picture, H x W x 3 uint8: float32 of sum 1."""
    small = cv2.resize(color, (48, 48), interpolation=cv2.INTER_AREA)
    counts = cv2.calcHist([small], [0, 1, 2], None, [4, 4, 4], [0, 256] * 3).ravel()
    return (counts / counts.sum()).astype(np.float32)


def eye_contrast(luma: np.ndarray, face: Box) -> float:
    """Vertical contrast in the band of a face where the eyes are, 0..1."""
    top, bottom = round(face.top + 0.25 * face.height), round(face.top + 0.5 * face.height)
    left, right = round(face.left + 0.15 * face.width), round(face.right - 0.15 * face.width)
    band = luma[max(0, top) : bottom, max(0, left) : right].astype(np.float32)
    if band.shape[0] < 3 or band.shape[1] < 3:
        return 0.0
    return float(np.abs(np.diff(band, axis=0)).mean()) / 255


def content_area(color: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns of a picture, H x W x 3 uint8, inside its letterbox bars; all if there are none."""
    red, green, blue = cv2.split(color)
    luma = cv2.max(cv2.max(red, green), blue)
    return _between(luma, 1), _between(luma, 0)


def _between(luma: np.ndarray, axis: int) -> slice:
    brightest, darkest = (
        cv2.reduce(luma, axis, kind).ravel().astype(int) for kind in (cv2.REDUCE_MAX, cv2.REDUCE_MIN)
    )
    shown = np.flatnonzero((brightest > _BAR_LEVEL) | (brightest - darkest > _BAR_RANGE))
    count = len(brightest)
    bar = min(int(shown[0]), count - 1 - int(shown[-1])) if len(shown) else 0
    # A line more, into which bar and picture were mixed.
    return slice(bar + 1, count - bar - 1) if _MIN_BAR * count <= bar <= _MAX_BAR * count else slice(0, count)
