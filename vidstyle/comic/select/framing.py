"""Framing of moments that look alike: from afar and from near in turn, so that one shot makes a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.similarity import SIMILAR, similarity
from vidstyle.comic.moment import Box

_BODY = 1.1, 0.9, 2.0
"""What is shown around a face from near, in heights of the face: at each side, above and below."""
_NEAR_FACE, _NEAR = 0.45, 0.62
"""Maximum height of a face, and side of the part shown where there is none, relative to the picture's."""
_EQUAL = 0.95
"""Similarity from which two pictures tell the same."""
_WIDEST = 0.85
"""A part of larger sides is hardly nearer than the whole; relative to the picture's."""


def without_repeats(moments: Sequence[Candidate]) -> list[Candidate]:
    """The moments without those that show the same as the one before them, framed in the same way."""
    like = similarity([each.thumbnail for each in moments])
    kept = [0]
    for number in range(1, len(moments)):
        each, before = moments[number], kept[-1]
        if each.forced or like[number, before] < _EQUAL or each.framing != moments[before].framing:
            kept.append(number)
    return [moments[number] for number in kept]


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


def _from_near(moment: Candidate) -> Candidate:
    """The moment with a part of its picture as all that counts; as it is where its main face is large."""
    height, width = moment.shape
    whole = Box(0.0, 0.0, float(width), float(height))
    if not moment.faces:
        x, y = moment.saliency.center
        wide, high = _NEAR * width / 2, _NEAR * height / 2
        left, top = min(max(0.0, x - wide), width - 2 * wide), min(max(0.0, y - high), height - 2 * high)
        part = Box(left, top, left + 2 * wide, top + 2 * high)
        for blob in moment.blobs:
            part = part.union(blob) if blob.intersection(part).area > 0 else part
        if max(part.width / width, part.height / height) > _WIDEST:
            return moment
        return replace(moment, saliency=part, framing="near")
    face = moment.faces[0]
    if face.height > _NEAR_FACE * height:
        return moment
    aside, above, below = (room * face.height for room in _BODY)
    part = face.padded(aside, above, below).intersection(whole)
    faces = tuple(each for each in moment.faces if each.intersection(part).area > 0)
    for each in faces:
        part = part.union(each)
    return replace(moment, saliency=part, faces=faces, blobs=(), framing="near")
