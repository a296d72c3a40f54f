"""Framing of key frames that look alike: wide views and close-ups in turn, so that one shot fills a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2

from vidstyle.comic.analyze.features import Candidate, Foreground
from vidstyle.comic.analyze.sharpness import FULL_FACE_DETAIL_LEVELS
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, similarity
from vidstyle.comic.select.frame_scores import MAX_LEADING_SOFTNESS, face_softness
from vidstyle.comic.select.movers import (
    has_large_mover,
    has_near_mover,
    has_several_movers,
    main_mover,
    widen,
)
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

_MAX_SMALL_FACE_RATIO, _MIN_ESTABLISHED_PANELS = 0.22, 3
"""Height of a face, relative to the picture's, below which it is shown nearer, and the number of panels from
which the first one is an establishing view, which is not changed."""
_MAX_LONE_SALIENT_SHARE = 0.5
"""Share of a picture without a subject up to which only its salient area is shown."""

# Repeats.
_EQUAL_SIMILARITY = 0.95
"""Similarity from which two pictures show the same."""
_CHANGE_SIDE_PX, _MIN_CHANGE_LEVELS = 5, 40
"""Side of a part of a thumbnail, and minimum difference of a part that shows something new, of 255."""


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


def alternate_framing(key_frames: Sequence[Candidate], enlarges_small: bool = False) -> list[Candidate]:
    """Frame successive key frames that look alike as wide views and close-ups in turn.

    After a wide view of several large movers, the others are close-ups of one or a few of them. Pictures of
    small movers stay wide views, unless `enlarges_small`: many panels of one view need variety.
    """
    like = similarity([each.thumbnail for each in key_frames])
    found = list(key_frames)
    for number in range(1, len(found)):
        before = found[number - 1]
        if like[number, number - 1] <= SAME_SIMILARITY:
            continue
        if before.framing == "near" and not has_several_movers(found[number]):
            found[number] = widen(found[number])
        else:
            found[number] = _zoom_in(found[number], enlarges_small)
            if before.framing == "usual" and found[number].framing != "usual":
                found[number - 1] = widen(before)
    return found


def widen_soft_faces(key_frames: Sequence[Candidate]) -> list[Candidate]:
    """Show frames whose face is soft as a whole, so that the face is not enlarged."""
    return [
        replace(each, framing="wide") if face_softness(each) > MAX_LEADING_SOFTNESS else each
        for each in key_frames
    ]


def approach_faces(key_frames: Sequence[Candidate]) -> list[Candidate]:
    """Show people whose faces are small in their picture nearer, as the style loses small faces.

    Soft faces are not enlarged.
    """
    first = 1 if len(key_frames) >= _MIN_ESTABLISHED_PANELS else 0
    near = (
        _zoom_in(each) if each.framing == "usual" and _has_small_face(each) else each
        for each in key_frames[first:]
    )
    return [*key_frames[:first], *near]


def _has_small_face(candidate: Candidate) -> bool:
    is_sharp = candidate.face_detail is not None and candidate.face_detail >= FULL_FACE_DETAIL_LEVELS
    return (
        is_sharp
        and bool(candidate.faces)
        and candidate.faces[0].height < _MAX_SMALL_FACE_RATIO * candidate.shape[0]
    )


def merge_equal(key_frames: Sequence[Candidate]) -> list[Candidate]:
    """If one or two key frames look the same, without faces, return only the first one.

    It is shown whole, or as its salient area if that is small.
    """
    like = similarity([each.thumbnail for each in key_frames])
    if (
        any(each.forced or each.faces or each.action for each in key_frames)
        or like.min() <= _EQUAL_SIMILARITY
        or len(key_frames) > 2
    ):
        return list(key_frames)
    only = key_frames[0]
    is_compact = only.saliency.area <= _MAX_LONE_SALIENT_SHARE * only.shape[0] * only.shape[1]
    return [replace(only, framing="near" if is_compact else "wide")]


def _zoom_in(key_frame: Candidate, enlarges_small: bool = False) -> Candidate:
    """Return the key frame as a close-up of its main face, or else of its movers or its salient area.

    It is unchanged if its main face is large or the close-up would be too wide, and a wide view, see `widen`,
    if its movers are small, unless `enlarges_small`.
    """
    height, width = key_frame.shape
    whole = Box(0.0, 0.0, float(width), float(height))
    if key_frame.faces:
        return _zoom_in_on_face(key_frame, whole)
    if key_frame.action and not key_frame.action.is_gone:
        is_shown = enlarges_small or has_large_mover(key_frame) or has_near_mover(key_frame)
        return _zoom_in_on_movers(key_frame, key_frame.action, whole) if is_shown else widen(key_frame)
    part = _part_around(key_frame.saliency.center, _NEAR_SIDE_RATIO, whole)
    for blob in key_frame.blobs:
        part = part.union(blob) if blob.intersection(part).area > 0 else part
    if not _is_near(part, whole):
        return key_frame
    return replace(key_frame, saliency=part, subject=None, framing="near")


def _zoom_in_on_movers(key_frame: Candidate, action: Foreground, whole: Box) -> Candidate:
    held = main_mover(action, whole)
    margin = 1.0 if has_several_movers(key_frame) else _ACTION_MARGIN_RATIO
    side = max(_MIN_ACTION_SIDE_RATIO, margin * max(held.width / whole.width, held.height / whole.height))
    part = _part_around(held.center, side, whole).union(held)
    if not _is_near(part, whole):
        return key_frame
    subject = held if key_frame.subject else None
    return replace(key_frame, saliency=part, blobs=(), subject=subject, framing="near")


def _part_around(center: tuple[float, float], side: float, whole: Box) -> Box:
    """Return the part of a picture around a place, within the picture; `side`: relative to the picture's."""
    (x, y), wide, high = center, side * whole.width / 2, side * whole.height / 2
    left = min(max(0.0, x - wide), whole.width - 2 * wide)
    top = min(max(0.0, y - high), whole.height - 2 * high)
    return Box(left, top, left + 2 * wide, top + 2 * high)


def _is_near(part: Box, whole: Box) -> bool:
    """Whether a part differs enough from the whole picture for a close-up."""
    return max(part.width / whole.width, part.height / whole.height) <= _MAX_NEAR_SIDE_RATIO


def _zoom_in_on_face(key_frame: Candidate, whole: Box) -> Candidate:
    face = key_frame.faces[0]
    if face.height > _MAX_NEAR_FACE_RATIO * whole.height:
        return key_frame
    aside, above, below = (room * face.height for room in _BODY_MARGIN_RATIOS)
    part = face.padded(aside, above, below).intersection(whole)
    faces = tuple(each for each in key_frame.faces if each.intersection(part).area > 0)
    for each in faces:
        part = part.union(each)
    return replace(key_frame, saliency=part, faces=faces, blobs=(), framing="near")
