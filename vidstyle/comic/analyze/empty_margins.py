"""Empty parts above and below what a picture shows: sky, ceilings and black ground."""

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
"""Empty part that is kept, and minimum and maximum of the removed part, relative to the picture's height."""
_MAX_ASPECT = 2.4
"""Maximum aspect of the remaining picture."""


def find_content(picture: np.ndarray) -> Box[float]:
    """Return the part of a picture, H x W x 3 uint8, without an empty part above and below it.

    It has the full width, and some room around what it shows. Small empty parts are not removed.
    """
    factor = min(1.0, _MEASURED_SIDE_PX / max(picture.shape))
    size = (max(1, round(side * factor)) for side in picture.shape[1::-1])
    found = _find_rows(cv2.resize(picture, tuple(size), interpolation=cv2.INTER_AREA))
    height, width = picture.shape[:2]
    return Box(0.0, found[0] * height, float(width), found[1] * height)


def _find_rows(color: np.ndarray) -> tuple[float, float]:
    """Return the first and last row of the content relative to the height."""
    height, width = color.shape[:2]
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY).clip(_INK_LEVEL, _PAPER_LEVEL).astype(np.float32)
    smooth = cv2.GaussianBlur(luma, (0, 0), _DEVIATION_PX)
    slopes = np.hypot(cv2.Sobel(smooth, -1, 1, 0, ksize=1), cv2.Sobel(smooth, -1, 0, 1, ksize=1)) / 2
    shown = np.flatnonzero(np.percentile(slopes, _DETAIL_PERCENTILE, axis=1) >= _MIN_DETAIL_LEVELS)
    if not len(shown):
        return 0.0, 1.0
    room = _ROOM_RATIO * height
    top, bottom = max(0.0, float(shown[0]) - room), min(float(height), float(shown[-1]) + 1 + room)
    cut = 1 - (bottom - top) / height
    if not _MIN_CUT_RATIO <= cut <= _MAX_CUT_RATIO or width > _MAX_ASPECT * (bottom - top):
        return 0.0, 1.0
    return top / height, bottom / height


def trim(key_frame: KeyFrame, content: Box) -> KeyFrame:
    """Return a key frame reduced to its content; unchanged if it has faces or is a close-up.

    `content`: see `find_content`.
    """
    height, width = key_frame.shape
    kept = content if key_frame.subject is None else content.union(key_frame.subject)
    top, bottom = max(0, round(kept.top)), min(height, round(kept.bottom))
    if key_frame.faces or key_frame.framing == "near" or bottom - top == height:
        return key_frame

    def move(box: Box) -> Box:
        return box.intersection(Box(0, top, width, bottom)).moved(0, -top)

    left, above = key_frame.offset
    return replace(
        key_frame,
        shape=(bottom - top, width),
        offset=(left, above + top),
        trimmed=key_frame.trimmed + top,
        saliency=move(key_frame.saliency),
        blobs=tuple(box for box in map(move, key_frame.blobs) if box.area > 0),
        subject=key_frame.subject and move(key_frame.subject),
    )
