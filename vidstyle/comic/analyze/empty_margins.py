"""Empty parts around what a picture shows: sky, ceilings, asphalt and black ground."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box

_MEASURED_SIDE_PX = 640
"""Longer side of the copies that are measured."""
_DEVIATION_PX, _DETAIL_PERCENTILE, _MIN_DETAIL_LEVELS = 1.5, 97, 5.0
"""Standard deviation of the Gaussian before slopes are measured, and the percentile of a row's slopes from
which, in levels of 255 per pixel, the row is not empty."""
_INK_LEVEL, _PAPER_LEVEL = 70, 225
"""Darker and lighter parts of a picture are printed without detail, of 255."""
_ROOM_RATIO, _MIN_CUT_RATIO, _MAX_CUT_RATIO = 0.08, 0.12, 0.4
"""Empty part that is kept, and minimum and maximum of the removed part, relative to the picture's height
or width."""
_ASPECT_RANGE = 0.7, 2.4
"""Range of the aspect of the remaining picture."""


def find_content(picture: np.ndarray) -> Box[float]:
    """Return the part of a picture, H x W x 3 uint8, without empty parts around it.

    It leaves some room around what it shows. Small empty parts are not removed.
    """
    factor = min(1.0, _MEASURED_SIDE_PX / max(picture.shape))
    size = tuple(max(1, round(side * factor)) for side in picture.shape[1::-1])
    slopes = _measure_slopes(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
    height, width = picture.shape[:2]
    least, most = _ASPECT_RANGE
    top, bottom = _find_span(slopes, width / most / height)
    left, right = _find_span(slopes.T, (bottom - top) * height * least / width)
    return Box(left * width, top * height, right * width, bottom * height)


def _measure_slopes(color: np.ndarray) -> np.ndarray:
    """Return the slopes of the tones that are printed, H x W float32, of 255 per pixel."""
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY).clip(_INK_LEVEL, _PAPER_LEVEL).astype(np.float32)
    smooth = cv2.GaussianBlur(luma, (0, 0), _DEVIATION_PX)
    return np.hypot(cv2.Sobel(smooth, -1, 1, 0, ksize=1), cv2.Sobel(smooth, -1, 0, 1, ksize=1)) / 2


def _find_span(slopes: np.ndarray, least: float) -> tuple[float, float]:
    """Return the first and last row of the content relative to the height.

    `least`: minimum height of the content, relative to the height.
    """
    height = len(slopes)
    shown = np.flatnonzero(np.percentile(slopes, _DETAIL_PERCENTILE, axis=1) >= _MIN_DETAIL_LEVELS)
    if not len(shown):
        return 0.0, 1.0
    room = _ROOM_RATIO * height
    top, bottom = max(0.0, float(shown[0]) - room), min(float(height), float(shown[-1]) + 1 + room)
    if not _MIN_CUT_RATIO <= 1 - (bottom - top) / height <= _MAX_CUT_RATIO or bottom - top < least * height:
        return 0.0, 1.0
    return top / height, bottom / height


def trim(key_frame: KeyFrame, content: Box) -> KeyFrame:
    """Return a key frame reduced to its content; unchanged if it has faces or is a close-up.

    `content`: see `find_content`.
    """
    height, width = key_frame.shape
    kept = content if key_frame.subject is None else content.union(key_frame.subject)
    top, bottom = max(0, round(kept.top)), min(height, round(kept.bottom))
    left, right = max(0, round(kept.left)), min(width, round(kept.right))
    shape = bottom - top, right - left
    if key_frame.faces or key_frame.framing == "near" or shape == key_frame.shape:
        return key_frame

    def move(box: Box) -> Box:
        return box.intersection(Box(left, top, right, bottom)).moved(-left, -top)

    (before, above), (aside, over) = key_frame.offset, key_frame.trimmed
    return replace(
        key_frame,
        shape=shape,
        offset=(before + left, above + top),
        trimmed=(aside + left, over + top),
        saliency=move(key_frame.saliency),
        blobs=tuple(box for box in map(move, key_frame.blobs) if box.area > 0),
        subject=key_frame.subject and move(key_frame.subject),
    )
