"""Attention maps: where in a picture balloons should not stand, besides on faces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from vidstyle.comic.analyze.saliency import blob_map, saliency_map, skin_saliency
from vidstyle.comic.analyze.survey import Film
from vidstyle.comic.moment import Box, Moment

SIDE = 96
"""Cells of a map along the longer side."""

_SEEN = 256
"""Pixels of the copy that is looked at."""
_BARE = 1.5
"""Additional weight of skin: it may be an undetected face."""
_HAIR = 0.18
"""Attention extends upwards by this share of the height, as to the hair above an undetected face."""


def attention_map(color: np.ndarray, faces: Sequence[Box] = ()) -> np.ndarray:
    """The map of a picture, H x W x 3 uint8: float32, about 1 on average, 0 where nothing is to be seen."""
    height, width = color.shape[:2]
    factor = _SEEN / max(height, width)
    size = max(8, round(width * factor)), max(8, round(height * factor))
    small = cv2.resize(color, size, interpolation=cv2.INTER_AREA)
    seen = saliency_map(small, [face.scaled(factor) for face in faces])
    seen += _BARE * skin_saliency(small) + blob_map(small)
    cells = max(1, round(size[0] * SIDE / _SEEN)), max(1, round(size[1] * SIDE / _SEEN))
    coarse = cv2.resize(seen, cells, interpolation=cv2.INTER_AREA)
    above = np.ones((1 + round(_HAIR * cells[1]), 1), np.uint8)
    spread = cv2.dilate(coarse, above, anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
    return (spread / max(float(spread.mean()), 1e-6)).astype(np.float32)


def attention_of_box(moment: Moment) -> np.ndarray:
    """A map made of the salient box alone."""
    height, width = moment.shape
    factor = SIDE / max(height, width)
    rows, columns = max(1, round(height * factor)), max(1, round(width * factor))
    seen = np.zeros((rows, columns), np.float32)
    box = moment.saliency.scaled(factor)
    seen[round(box.top) : round(box.bottom), round(box.left) : round(box.right)] = 1
    return seen / max(float(seen.mean()), 1e-6)


def attention_maps(film: Film, moments: Sequence[Moment], wanted: Sequence[bool]) -> Iterator[np.ndarray]:
    """The map of each moment, of those not wanted by the salient box alone."""
    times = [moment.time for moment, each in zip(moments, wanted, strict=True) if each]
    colors = film.frames_at(times, keep=True)
    for moment, each in zip(moments, wanted, strict=True):
        yield attention_map(moment.picture(next(colors)), moment.faces) if each else attention_of_box(moment)


def within(attention: np.ndarray, moment: Moment, window: Box) -> np.ndarray:
    """The part of a moment's map inside a window of its picture, at least one cell."""
    rows, columns = attention.shape
    down, across = rows / moment.shape[0], columns / moment.shape[1]
    top, left = min(rows - 1, int(window.top * down)), min(columns - 1, int(window.left * across))
    bottom, right = max(top + 1, round(window.bottom * down)), max(left + 1, round(window.right * across))
    return attention[top:bottom, left:right]


def mean_under(attention: np.ndarray, picture: Box, boxes: np.ndarray) -> np.ndarray:
    """The mean of a map of a picture under boxes (left, top, right, bottom: count x 4) that lie in it."""
    rows, columns = attention.shape
    sums = np.pad(attention.cumsum(0, dtype=np.float64).cumsum(1), ((1, 0), (1, 0)))
    x = (boxes[:, [0, 2]] - picture.left) * (columns / picture.width)
    y = (boxes[:, [1, 3]] - picture.top) * (rows / picture.height)
    left = np.clip(np.floor(x[:, 0]).astype(int), 0, columns - 1)
    top = np.clip(np.floor(y[:, 0]).astype(int), 0, rows - 1)
    right = np.clip(np.ceil(x[:, 1]).astype(int), left + 1, columns)
    bottom = np.clip(np.ceil(y[:, 1]).astype(int), top + 1, rows)
    total = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    return total / ((right - left) * (bottom - top))
