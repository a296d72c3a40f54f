"""Candidate key frames and the features by which they are scored, measured on small copies."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.comic.analyze.corners import Corners, find_corners
from vidstyle.comic.analyze.flaws.defects import Blockiness, count_block_corners, is_smeared, is_test_picture
from vidstyle.comic.analyze.flaws.flat_boxes import find_flat_box
from vidstyle.comic.analyze.letterbox import content_area
from vidstyle.comic.analyze.picture_contrast import color_histogram, is_blank, measure_exposure, measure_forms
from vidstyle.comic.analyze.saliency import find_blobs, saliency_map, salient_box
from vidstyle.comic.analyze.sharpness import measure_resolution, measure_sharpness
from vidstyle.comic.analyze.similarity import make_thumbnail
from vidstyle.comic.analyze.titles import has_title
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box

MEASURED_SIDE_PX = 640
"""Longer side of the copies that are measured: small enough to be fast, large enough to show blur."""

# The whole of a moving subject.
_SUBJECT_MARGIN_RATIOS = 0.06, 0.1
"""Margins around it: at the sides and below, and above."""
_MAX_GROWTH_RATIO = 2.0
"""Maximum area of a moving subject with a blob that belongs to it, relative to its area without the blob."""


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
        detail: see `measure_sharpness`; None if it is not known.
        edges: see `measure_sharpness`; None if they are not known.
        sharp_subject: sharpness of its moving subject, relative to the same subject in other frames, 0..1.
        clarity: 0..1, lower in the dark, with large black or white areas, and without distinct large forms.
        blank: whether the picture is black, white or one tone.
        thumbnail: the copy that is compared with other pictures, see `similarity`.
        histogram: shares of 64 colours, float32, of sum 1.
        resolution: see `measure_resolution`; infinite if it is not known.
        eyes: how far the eyes of the largest face are open, 0..1; 0 if it is not known.
        open_mouth: how far the mouth of the largest face is open, 0..1; 0 if it is not known.
        face_detail: slope of the edges in the largest face, see `measure_detail`; None if it is not known.
        motion: see `ShotFinder.push`; 0 if only key frames were decoded.
        flow: how far each part moves during an exposure, see `FlowMeter`; None if it is not known.
        action: the moving subject in front of a still camera; None if the camera moves, or nothing does.
        in_transition: whether it shows a blend of two shots, or a fade.
        damaged: whether it may show errors of decoding: the decoder reported some, or they are visible.
        broken: whether errors of decoding are visible.
        blurred: whether it is blurred by motion, compared with the film.
        combed: whether it mixes two interlaced fields.
        test_picture: whether it shows the bars of a test picture.
        blockiness: see `measure_blockiness`.
        block_corners: see `count_block_corners`.
        flat_box: the flat rectangle in it, in pixels of its small copy; None if there is none.
        titled: whether it shows a title, see `has_title`.
        key_run: the number of key frames up to it; frames of one run are predicted from each other.
        corners: see `find_corners`; None if they are not known.
        forced: whether it was requested by its time.
        small: a small copy without letterbox bars, as long as subjects may still be detected in it.
    """

    sharpness: float
    clarity: float
    blank: bool
    thumbnail: np.ndarray
    histogram: np.ndarray
    detail: np.ndarray | None = None
    edges: np.ndarray | None = None
    sharp_subject: float = 1.0
    resolution: float = math.inf
    eyes: float = 0.0
    open_mouth: float = 0.0
    face_detail: float | None = None
    motion: float = 0.0
    flow: np.ndarray | None = None
    action: Foreground | None = None
    in_transition: bool = False
    damaged: bool = False
    broken: bool = False
    blurred: bool = False
    combed: bool = False
    test_picture: bool = False
    blockiness: Blockiness = Blockiness()
    block_corners: int = 0
    flat_box: Box | None = None
    titled: bool = False
    key_run: int = 0
    corners: Corners | None = None
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
        sharpest_subjects: see `compare_subjects`.
    """

    candidates: list[Candidate]
    scene_starts: list[float]
    seconds: float
    is_folder: bool = False
    sharpest_subjects: dict[int, float] = field(default_factory=dict)


def cut_bars(color: np.ndarray) -> np.ndarray:
    """Return the small copy of a frame, H x W x 3 uint8, without letterbox bars."""
    return np.ascontiguousarray(color[content_area(color)])


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
    sharpness, detail, edges = measure_sharpness(luma)
    smeared = is_smeared(luma)
    return Candidate(
        time,
        inner,
        importance=0.0,
        saliency=Box(0.0, 0.0, float(inner[1]), float(inner[0])),
        faces=(),
        scene=0,
        offset=(left, top),
        sharpness=sharpness,
        detail=detail,
        edges=edges,
        clarity=measure_exposure(luma) * measure_forms(color),
        blank=is_blank(luma),
        test_picture=is_test_picture(color),
        light=float(luma.mean()) / 255,
        damaged=smeared,
        broken=smeared,
        block_corners=count_block_corners(luma),
        flat_box=find_flat_box(luma),
        titled=has_title(luma),
        thumbnail=make_thumbnail(color),
        histogram=color_histogram(color),
        small=color,
    )


def add_saliency(candidate: Candidate) -> Candidate:
    """Return the candidate with resolution, corners, salient box and blobs of its small copy, and without it.

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
        saliency = part = _add_margin(subject.scaled(1 / factor), color.shape)
        blobs = [blob for blob in blobs if _belongs_to(blob, part)]
    else:
        saliency = salient_box(saliency_map(color, faces))
    for blob in blobs:
        saliency = saliency.union(blob)
    scaled = tuple(blob.scaled(factor) for blob in blobs)
    if subject is not None:
        subject = saliency.scaled(factor)
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)
    return replace(
        candidate,
        saliency=saliency.scaled(factor),
        blobs=scaled,
        subject=subject,
        resolution=measure_resolution(luma),
        corners=find_corners(luma),
        small=None,
    )


def _add_margin(subject: Box, shape: tuple[int, ...]) -> Box:
    """Return a moving subject with the hair and hands that its coarse mask misses."""
    across, above = _SUBJECT_MARGIN_RATIOS[0] * subject.width, _SUBJECT_MARGIN_RATIOS[1] * subject.height
    return subject.padded(across, above, across).intersection(Box(0, 0, shape[1], shape[0]))


def _belongs_to(blob: Box, subject: Box) -> bool:
    """Whether a blob is a part of a subject: it meets its box, and is not much larger, as the ground is."""
    return (
        blob.intersection(subject).area > 0 and blob.union(subject).area <= _MAX_GROWTH_RATIO * subject.area
    )
