"""Framing of key frames that look alike: wide views and close-ups in turn, so that one shot fills a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.saliency import saliency_map
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, similarity
from vidstyle.regions.boxes import Box

# Close-ups.
_BODY_MARGIN_RATIOS = 1.1, 0.9, 2.0
"""Margins around a face in a close-up, in heights of the face: at each side, above and below."""
_MAX_NEAR_FACE_RATIO = 0.45
"""Maximum height of a face that gets a close-up, relative to the picture's."""
_NEAR_SIDE_RATIO = 0.62
"""Side of a close-up without a face, relative to the picture's."""
_ACTION_MARGIN_RATIO, _MIN_ACTION_SIDE_RATIO = 1.25, 0.4
"""Side of a close-up of an action relative to the action, and its minimum relative to the picture's."""
_MAX_NEAR_SIDE_RATIO = 0.85
"""Maximum side of a close-up relative to the picture's; a larger one would hardly differ from the whole."""

# Repeats.
_EQUAL_SIMILARITY = 0.95
"""Similarity from which two pictures show the same."""
_CHANGE_SIDE_PX, _MIN_CHANGE_LEVELS = 5, 40
"""Side of a part of a thumbnail, and minimum difference of a part that shows something new, of 255."""

# Details of a film that is one picture.
_DETAIL_SIDE_RATIO, _DETAIL_COUNT = 0.5, 1
"""Side of a detail relative to the picture's shorter side, and number of details."""
_MIN_DETAIL_SIDE_PX = 160
"""Minimum side of a detail: enlarged further, it shows nothing new."""


def remove_repeats(key_frames: Sequence[Candidate]) -> list[Candidate]:
    """Remove key frames that show the same as their predecessor in the same framing."""
    like = similarity([each.thumbnail for each in key_frames])
    kept = [0]
    for number in range(1, len(key_frames)):
        each, before = key_frames[number], kept[-1]
        is_new = (
            like[number, before] < _EQUAL_SIMILARITY
            or _local_change(each, key_frames[before]) > _MIN_CHANGE_LEVELS
        )
        if each.forced or is_new or each.framing != key_frames[before].framing:
            kept.append(number)
    return [key_frames[number] for number in kept]


def _local_change(one: Candidate, other: Candidate) -> float:
    """Return the largest local difference of two pictures, of 255: an action may cover a small part."""
    return float(
        cv2.blur(cv2.absdiff(one.thumbnail, other.thumbnail), (_CHANGE_SIDE_PX, _CHANGE_SIDE_PX)).max()
    )


def alternate_framing(key_frames: Sequence[Candidate]) -> list[Candidate]:
    """Frame successive key frames that look alike as wide views and close-ups in turn."""
    like = similarity([each.thumbnail for each in key_frames])
    found = list(key_frames)
    for number in range(1, len(found)):
        before = found[number - 1]
        if like[number, number - 1] <= SAME_SIMILARITY:
            continue
        if before.framing == "near":
            found[number] = replace(found[number], framing="wide")
        else:
            found[number] = _zoom_in(found[number])
            if before.framing == "usual" and found[number].framing == "near":
                found[number - 1] = replace(before, framing="wide")
    return found


def add_details(key_frames: Sequence[Candidate]) -> list[Candidate]:
    """If all key frames look the same, show the first one whole, then details of the last one.

    Pictures with faces get no details, and of small pictures a single one is shown whole.
    """
    like = similarity([each.thumbnail for each in key_frames])
    if (
        any(each.forced or each.faces for each in key_frames)
        or like.min() <= SAME_SIMILARITY
        or len(key_frames) > 2
    ):
        return list(key_frames)
    if _DETAIL_SIDE_RATIO * min(key_frames[0].shape) < _MIN_DETAIL_SIDE_PX:
        return [replace(key_frames[0], framing="wide")]
    parts = list(_details(key_frames[0]))
    shown = [replace(key_frames[-1], saliency=part, blobs=(), framing="near") for part in parts]
    return [replace(key_frames[0], framing="wide"), *shown]


def _details(key_frame: Candidate) -> Iterator[Box]:
    """Yield the most salient parts of a picture, without overlap, from left to right."""
    height, width = key_frame.shape
    rows, columns = key_frame.thumbnail.shape[:2]
    across, down = width / columns, height / rows
    side = _DETAIL_SIDE_RATIO * min(height, width)
    high, wide = max(1, round(side / down)), max(1, round(side / across))
    sums = np.pad(saliency_map(key_frame.thumbnail).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    seen = sums[high:, wide:] - sums[:-high, wide:] - sums[high:, :-wide] + sums[:-high, :-wide]
    places = list[tuple[int, int]]()
    for _ in range(_DETAIL_COUNT):
        row, column = map(int, np.unravel_index(seen.argmax(), seen.shape))
        places.append((column, row))
        seen[max(0, row - high + 1) : row + high, max(0, column - wide + 1) : column + wide] = -1
    for column, row in sorted(places):
        yield Box(column * across, row * down, (column + wide) * across, (row + high) * down)


def _zoom_in(key_frame: Candidate) -> Candidate:
    """Return the key frame as a close-up; unchanged if its main face is large or it would be too wide."""
    height, width = key_frame.shape
    whole = Box(0.0, 0.0, float(width), float(height))
    if not key_frame.faces:
        x, y = key_frame.saliency.center
        side, blobs = _NEAR_SIDE_RATIO, key_frame.blobs
        if key_frame.action and not key_frame.action.is_gone:
            box, blobs = key_frame.action.box, ()
            side = max(
                _MIN_ACTION_SIDE_RATIO, _ACTION_MARGIN_RATIO * max(box.width / width, box.height / height)
            )
        wide, high = side * width / 2, side * height / 2
        left, top = min(max(0.0, x - wide), width - 2 * wide), min(max(0.0, y - high), height - 2 * high)
        part = Box(left, top, left + 2 * wide, top + 2 * high)
        for blob in blobs:
            part = part.union(blob) if blob.intersection(part).area > 0 else part
        if max(part.width / width, part.height / height) > _MAX_NEAR_SIDE_RATIO:
            return key_frame
        return replace(key_frame, saliency=part, blobs=blobs, framing="near")
    face = key_frame.faces[0]
    if face.height > _MAX_NEAR_FACE_RATIO * height:
        return key_frame
    aside, above, below = (room * face.height for room in _BODY_MARGIN_RATIOS)
    part = face.padded(aside, above, below).intersection(whole)
    faces = tuple(each for each in key_frame.faces if each.intersection(part).area > 0)
    for each in faces:
        part = part.union(each)
    return replace(key_frame, saliency=part, faces=faces, blobs=(), framing="near")
