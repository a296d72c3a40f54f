"""The frame by which a page first shows a film."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from vidstyle.core.uniform import is_nearly_uniform
from vidstyle.errors import InputError
from vidstyle.preview.clip import Clip
from vidstyle.preview.encode import encode
from vidstyle.regions.faces import FaceFinder

TRIED_POSITION_RATIOS = (0, 0.02, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85)
"""Positions of the frames that may represent a film."""
TRIED_SIDE_PX = 160
GLANCE_SIDE_PX = 360
"""Shorter side of the first picture that a page shows."""
MIN_FACE_HEIGHT_RATIO = 0.12
"""Height of a face, relative to the picture, from which it represents a film."""
BRIGHT_RATIO = 0.35
"""Mean brightness, relative to white, from which a frame is not dark."""
MIN_GAIN = 1.25
"""Factor by which a later frame must be better than the first one to represent the film instead."""


@lru_cache(maxsize=1)
def representative_frame(clip: Clip) -> int:
    """Return the number of the frame with the largest face, else of the first bright and detailed one.

    Frames that are nearly uniform, or that cannot be decoded, are skipped; 0 if that leaves none.
    """
    if clip.live or clip.count == 1:
        return 0
    tried = dict(_tried_frames(clip))
    finder = FaceFinder()
    faces = {number: _face_height(finder, picture) for number, picture in tried.items()}
    if faces and max(faces.values()) >= MIN_FACE_HEIGHT_RATIO:
        return max(faces, key=lambda number: faces[number])
    best = next(iter(tried), 0)
    for number, picture in tried.items():
        if _interest(picture) > MIN_GAIN * _interest(tried[best]):
            best = number
    return best


def glance_jpeg(clip: Clip) -> bytes:
    """Return this frame in approximate colours, as JPEG, without compiling a kernel.

    Raises:
        InputError: the frame cannot be read.
        DeviceError: the camera was lost.
    """
    return encode(clip.glance(representative_frame(clip), GLANCE_SIDE_PX), "jpeg")


def _tried_frames(clip: Clip) -> Iterator[tuple[int, np.ndarray]]:
    """Yield the tried frames that show something, by number."""
    for number in dict.fromkeys(round(share * (clip.count - 1)) for share in TRIED_POSITION_RATIOS):
        try:
            picture = clip.glance(number, TRIED_SIDE_PX)
        except InputError:
            continue
        if not is_nearly_uniform(picture):
            yield number, picture


def _face_height(finder: FaceFinder, picture: np.ndarray) -> float:
    """Return the height of the largest face, relative to the picture; 0 if there is none."""
    found = finder.find(np.ascontiguousarray(picture), MIN_FACE_HEIGHT_RATIO)
    return max((box.height for box in found), default=0.0) / picture.shape[0]


def _interest(picture: np.ndarray) -> float:
    """Return how detailed a picture is; less if it is dark."""
    luma = picture.mean(axis=2)
    detail = float(np.abs(np.diff(luma, axis=0)).mean() + np.abs(np.diff(luma, axis=1)).mean())
    return detail * min(1.0, float(luma.mean()) / (255 * BRIGHT_RATIO))
