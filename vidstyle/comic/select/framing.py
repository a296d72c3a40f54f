"""Framing of moments that look alike: from afar and from near in turn, so that one shot makes a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.saliency import saliency_map
from vidstyle.comic.analyze.similarity import SIMILAR, similarity
from vidstyle.comic.moment import Box

_BODY = 1.1, 0.9, 2.0
"""What is shown around a face from near, in heights of the face: at each side, above and below."""
_NEAR_FACE, _NEAR = 0.45, 0.62
"""Maximum height of a face, and side of the part shown where there is none, relative to the picture's."""
_EQUAL = 0.95
"""Similarity from which two pictures tell the same."""
_PART, _CHANGED = 5, 40
"""Pixels of a part of a thumbnail, and the least difference of one in which something happens, of 255."""
_AROUND_ACTION, _SMALLEST = 1.25, 0.4
"""What is shown around an action from near, and its smallest side relative to the picture's."""
_DETAIL, _DETAILS = 0.5, 2
"""Side of a detail relative to the picture's shorter one, and how many tell a film that is one picture."""
_WIDEST = 0.85
"""A part of larger sides is hardly nearer than the whole; relative to the picture's."""


def without_repeats(moments: Sequence[Candidate]) -> list[Candidate]:
    """The moments without those that show the same as the one before them, framed in the same way."""
    like = similarity([each.thumbnail for each in moments])
    kept = [0]
    for number in range(1, len(moments)):
        each, before = moments[number], kept[-1]
        is_new = like[number, before] < _EQUAL or _local_change(each, moments[before]) > _CHANGED
        if each.forced or is_new or each.framing != moments[before].framing:
            kept.append(number)
    return [moments[number] for number in kept]


def _local_change(one: Candidate, other: Candidate) -> float:
    """The largest difference of a part of two pictures, of 255: an action may take a small part of them."""
    return float(cv2.blur(cv2.absdiff(one.thumbnail, other.thumbnail), (_PART, _PART)).max())


def framed(moments: Sequence[Candidate]) -> list[Candidate]:
    """The moments, where successive ones look nearly the same from afar and from near in turn."""
    like = similarity([each.thumbnail for each in moments])
    found = list(moments)
    for number in range(1, len(found)):
        before = found[number - 1]
        if like[number, number - 1] <= SIMILAR:
            continue
        if before.framing == "near":
            found[number] = replace(found[number], framing="wide")
        else:
            found[number] = _from_near(found[number])
            if before.framing == "usual" and found[number].framing == "near":
                found[number - 1] = replace(before, framing="wide")
    return found


def with_details(moments: Sequence[Candidate]) -> list[Candidate]:
    """The moments; where they all tell the same, the first as a whole, and details of the first and the last.

    A face is no detail.
    """
    like = similarity([each.thumbnail for each in moments])
    if any(each.forced or each.faces for each in moments) or like.min() <= SIMILAR or len(moments) > 2:
        return list(moments)
    parts = list(_details(moments[0]))
    shown = [replace(moments[-1], saliency=part, blobs=(), framing="near") for part in parts]
    return [replace(moments[0], framing="wide"), *shown]


def _details(moment: Candidate) -> Iterator[Box]:
    """The parts of a picture that draw the eye most, without overlap, from left to right."""
    height, width = moment.shape
    rows, columns = moment.thumbnail.shape[:2]
    across, down = width / columns, height / rows
    side = _DETAIL * min(height, width)
    high, wide = max(1, round(side / down)), max(1, round(side / across))
    sums = np.pad(saliency_map(moment.thumbnail).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    seen = sums[high:, wide:] - sums[:-high, wide:] - sums[high:, :-wide] + sums[:-high, :-wide]
    places = list[tuple[int, int]]()
    for _ in range(_DETAILS):
        row, column = map(int, np.unravel_index(seen.argmax(), seen.shape))
        places.append((column, row))
        seen[max(0, row - high + 1) : row + high, max(0, column - wide + 1) : column + wide] = -1
    for column, row in sorted(places):
        yield Box(column * across, row * down, (column + wide) * across, (row + high) * down)


def _from_near(moment: Candidate) -> Candidate:
    """The moment with a part of its picture as all that counts; as it is where its main face is large."""
    height, width = moment.shape
    whole = Box(0.0, 0.0, float(width), float(height))
    if not moment.faces:
        x, y = moment.saliency.center
        side, blobs = _NEAR, moment.blobs
        if moment.action and not moment.action.is_gone:
            box, blobs = moment.action.box, ()
            side = max(_SMALLEST, _AROUND_ACTION * max(box.width / width, box.height / height))
        wide, high = side * width / 2, side * height / 2
        left, top = min(max(0.0, x - wide), width - 2 * wide), min(max(0.0, y - high), height - 2 * high)
        part = Box(left, top, left + 2 * wide, top + 2 * high)
        for blob in blobs:
            part = part.union(blob) if blob.intersection(part).area > 0 else part
        if max(part.width / width, part.height / height) > _WIDEST:
            return moment
        return replace(moment, saliency=part, blobs=blobs, framing="near")
    face = moment.faces[0]
    if face.height > _NEAR_FACE * height:
        return moment
    aside, above, below = (room * face.height for room in _BODY)
    part = face.padded(aside, above, below).intersection(whole)
    faces = tuple(each for each in moment.faces if each.intersection(part).area > 0)
    for each in faces:
        part = part.union(each)
    return replace(moment, saliency=part, faces=faces, blobs=(), framing="near")
