"""Cropping: the window of a key frame's picture that a panel shows."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce

import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box, Point, Rectangle

# The size of windows.
MIN_WINDOW_RATIO = 0.5
"""Minimum size of a window, relative to the largest one of its aspect."""
MIN_TINY_FACE_WINDOW_RATIO = 0.35
"""Minimum size if the main face is tiny, and for close-ups."""
MIN_FACELESS_WINDOW_RATIO = 0.75
"""Minimum size without a face: saliency is less certain than a face."""
_MIN_SUBJECT_WINDOW_RATIO = 0.45
"""Minimum size around a moving subject without a face."""
TINY_FACE_HEIGHT_RATIO = 1 / 12
"""Height of a face, relative to the picture's, below which it is tiny."""
CONTENT_WINDOW_RATIO, NEAR_CONTENT_WINDOW_RATIO = 1.6, 1.05
"""Wanted size of a window, relative to its content; the second value is for close-ups."""

# The room around a face, in sides of the face.
HEAD_ROOM_FACE_RATIO = 0.4
NECK_ROOM_FACE_RATIO = 0.25
SIDE_ROOM_FACE_RATIO = 0.15
_SHOULDER_FACE_RATIO = 1.0
"""Room for shoulders that a window keeps if it is moved for the text."""

# The costs of windows, in the order of their importance.
_MAIN_FACE_COST = 1000.0
"""Cost of losing the main face."""
_CUT_FACE_COST = 100.0
"""Cost of cutting a face."""
_LOST_SALIENCY_COST = 30.0
"""Cost of losing the salient area."""
_CUT_BLOB_COST = 10.0
"""Cost of cutting a blob."""
_OMITTED_FACE_COST = 8.0
"""Cost of omitting a face."""
_LOST_HEAD_ROOM_COST = 25.0
"""Cost of losing the room around all large faces: hair and chin."""
_LOST_SUBJECT_COST = 200.0
"""Cost of losing a part of the moving subject, in a picture without faces."""
_LOST_TOP_COST = 4.0
"""Cost of losing the top of the salient area."""
_ZOOM_COST = 4.0
"""Cost of a window smaller than wanted, per side of the largest one."""
_THIRD_DISTANCE_COST = 1.0
"""Cost of the subject's distance from a third."""
_CENTRE_DISTANCE_COST = 0.3
"""Cost of the window's distance from the picture's centre."""
_MAX_BLOBS = 12
"""Maximum number of blobs considered, the largest first."""

# Composition.
_THIRD_RATIOS = (1 / 3, 2 / 3)
"""Positions of the thirds in a window."""
_FACE_CENTRE_RATIO = 0.4
"""Wanted height of a face's centre in a panel, from the top: its eyes are then at a third."""
_SHIFT_RATIOS = ((0, -0.5), (0, -1), (-0.5, 0), (0.5, 0), (-1, 0), (1, 0), (0, 0.5))
"""Shifts tried, relative to the largest shift that keeps the main content visible."""

_ROUNDING_TOLERANCE = 1e-6


def crop(key_frame: KeyFrame, aspect: float) -> Box:
    """Return the window of a picture that a panel shows: faces and saliency, composed by the rule of thirds.

    The window is as large as possible, or smaller if its content is small. Candidates are the windows whose
    edges or thirds meet an edge or the centre of a face or of the salient box; the one with the lowest cost
    wins. In order of weight: it contains the main (largest) face, cuts no face, contains the saliency, the
    other faces and the head room of the main one, and follows the thirds.

    Args:
        key_frame: the key frame.
        aspect: width divided by height of the panel, above 0.

    Returns:
        A window within the picture, of exactly that aspect, in pixels.
    """
    width, height = largest_window(key_frame, aspect)
    scales = _scales(key_frame, width, height)
    windows = [_find_window(key_frame, width * scale, height * scale, scales[0] - scale) for scale in scales]
    return min(windows, key=lambda window: window[0])[1]


def largest_window(key_frame: KeyFrame, aspect: float) -> tuple[float, float]:
    """Return width and height of the largest window of an aspect within a key frame's picture."""
    height, width = key_frame.shape
    across = min(float(width), height * aspect)
    return across, min(float(height), across / aspect)


def main_face(key_frame: KeyFrame) -> Box | None:
    """Return the largest face."""
    return max(key_frame.faces, key=lambda face: face.area, default=None)


def add_face_room(key_frame: KeyFrame, face: Box) -> Box:
    """Return the face enlarged by hair and neck, clipped to the picture."""
    height, width = key_frame.shape
    roomy = face.padded(
        SIDE_ROOM_FACE_RATIO * face.width,
        HEAD_ROOM_FACE_RATIO * face.height,
        NECK_ROOM_FACE_RATIO * face.height,
    )
    return roomy.intersection(Box(0, 0, width, height))


def content_box(key_frame: KeyFrame) -> Box:
    """Return the smallest box that contains the saliency and all faces with their room."""
    kept = key_frame.saliency
    for face in key_frame.faces:
        kept = kept.union(add_face_room(key_frame, face))
    return kept


def required_box(key_frame: KeyFrame) -> Box:
    """Return the box that a panel must not cut: the large faces, or else the saliency."""
    faces = large_faces(key_frame)
    if not faces:
        return key_frame.saliency
    return reduce(Box.union, (add_face_room(key_frame, face) for face in faces))


def large_faces(key_frame: KeyFrame) -> list[Box]:
    """Return the faces at least half as high as the main one: they belong together, like a couple."""
    main = main_face(key_frame)
    return [face for face in key_frame.faces if main and face.height >= main.height / 2]


def _largest_blobs(key_frame: KeyFrame) -> list[Box]:
    return sorted(key_frame.blobs, key=lambda blob: -blob.area)[:_MAX_BLOBS]


def _scales(key_frame: KeyFrame, width: float, height: float) -> list[float]:
    """Return sizes to try, relative to the largest window: the wanted one, then smaller ones.

    A smaller window may omit a face that would otherwise be cut.
    """
    if key_frame.framing == "wide":
        return [1.0]
    least = least_window_ratio(key_frame)
    kept = content_box(key_frame)
    around = NEAR_CONTENT_WINDOW_RATIO if key_frame.framing == "near" else CONTENT_WINDOW_RATIO
    wanted = around * max(kept.width / width, kept.height / height)
    near = min(1.0, max(least, wanted))
    return [near, (near + least) / 2, least]


def least_window_ratio(key_frame: KeyFrame) -> float:
    """Return the size of the smallest window relative to the largest one of its aspect."""
    if key_frame.framing == "wide":
        return 1.0
    face = main_face(key_frame)
    if key_frame.framing == "near":
        return MIN_TINY_FACE_WINDOW_RATIO
    if face is None:
        return MIN_FACELESS_WINDOW_RATIO if key_frame.subject is None else _MIN_SUBJECT_WINDOW_RATIO
    is_tiny = face.height < TINY_FACE_HEIGHT_RATIO * key_frame.shape[0]
    return MIN_TINY_FACE_WINDOW_RATIO if is_tiny else MIN_WINDOW_RATIO


def _find_window(key_frame: KeyFrame, width: float, height: float, nearer: float) -> tuple[float, Box]:
    """Return the window of a size with the lowest cost, and that cost."""
    subject = main_face(key_frame) or key_frame.saliency
    boxes = [
        key_frame.saliency,
        *key_frame.faces,
        add_face_room(key_frame, subject),
        *_largest_blobs(key_frame),
    ]
    tall, wide = key_frame.shape
    lefts = _places([(box.left, box.right) for box in boxes], subject.center[0], width, wide)
    tops = _places([(box.top, box.bottom) for box in boxes], subject.center[1], height, tall)
    prices = _window_costs(key_frame, lefts[:, None], tops[None, :], width, height) + _ZOOM_COST * nearer
    across, down = divmod(int(prices.argmin()), len(tops))
    left, top = float(lefts[across]), float(tops[down])
    right, bottom = min(float(wide), left + width), min(float(tall), top + height)
    return float(prices.min()), Box(left, top, right, bottom)


def _places(spans: list[tuple[float, float]], middle: float, side: float, whole: float) -> np.ndarray:
    """Return candidate positions of a window along one axis, within the picture, without duplicates."""
    places = [0.0, whole - side, (whole - side) / 2]
    places += [middle - part * side for part in (*_THIRD_RATIOS, 0.5, _FACE_CENTRE_RATIO)]
    for low, high in spans:
        places += [low, high, low - side, high - side]
    return np.unique(np.clip(places, 0.0, max(0.0, whole - side)))


def _window_costs(
    key_frame: KeyFrame, left: np.ndarray, top: np.ndarray, width: float, height: float
) -> np.ndarray:
    """Return the cost of windows at `left` x `top`."""
    face = main_face(key_frame)
    subject = face or key_frame.saliency

    def lost(box: Box) -> np.ndarray:
        across = _visible_share(box.left, box.right, left, width)
        return 1 - across * _visible_share(box.top, box.bottom, top, height)

    price = _LOST_SALIENCY_COST * _loss_cost(lost(key_frame.saliency))
    for each in key_frame.faces:
        part = lost(each)
        price = price + _CUT_FACE_COST * _is_cut(part) + _OMITTED_FACE_COST * (part > _ROUNDING_TOLERANCE)
    over = np.clip(top - key_frame.saliency.top, 0.0, None) / max(key_frame.saliency.height, 1.0)
    price = price + _LOST_TOP_COST * over
    for blob in _largest_blobs(key_frame):
        price = price + _CUT_BLOB_COST * _is_cut(lost(blob))
    if face is not None:
        price = price + _MAIN_FACE_COST * _loss_cost(lost(face))
    elif key_frame.subject is not None:
        price = price + _LOST_SUBJECT_COST * _loss_cost(lost(key_frame.subject))
    large = large_faces(key_frame)
    for each in large:
        price = price + _LOST_HEAD_ROOM_COST / len(large) * _loss_cost(lost(add_face_room(key_frame, each)))
    price = price + _THIRD_DISTANCE_COST * _composition_cost(
        subject, left, top, width, height, face is not None
    )
    tall, wide = key_frame.shape
    shift = np.abs(left + width / 2 - wide / 2) / wide + np.abs(top + height / 2 - tall / 2) / tall
    return price + _CENTRE_DISTANCE_COST * shift


def _visible_share(low: float, high: float, start: np.ndarray, side: float) -> np.ndarray:
    """Return the share of a span that is inside a window."""
    inside = np.minimum(high, start + side) - np.maximum(low, start)
    return np.clip(inside / max(high - low, _ROUNDING_TOLERANCE), 0.0, 1.0)


def _is_cut(lost: np.ndarray) -> np.ndarray:
    """Return where a part of something is lost, but not all of it."""
    return (lost > _ROUNDING_TOLERANCE) & (lost < 1 - _ROUNDING_TOLERANCE)


def _loss_cost(lost: np.ndarray) -> np.ndarray:
    """Return the lost share, plus 1 where anything is lost."""
    return lost + (lost > _ROUNDING_TOLERANCE)


def _composition_cost(
    subject: Box, left: np.ndarray, top: np.ndarray, width: float, height: float, is_face: bool
) -> np.ndarray:
    """Return the distance of the subject from the thirds, in sides of the window.

    The centre is nearly as good.
    """
    across, down = (subject.center[0] - left) / width, (subject.center[1] - top) / height
    return _third_distance(across) + (np.abs(down - _FACE_CENTRE_RATIO) if is_face else _third_distance(down))


def _third_distance(part: np.ndarray) -> np.ndarray:
    aside = np.minimum(np.abs(part - _THIRD_RATIOS[0]), np.abs(part - _THIRD_RATIOS[1]))
    return np.minimum(aside, np.abs(part - 0.5) + 0.08)


def map_to_page(box: Box, window: Box, picture: Rectangle) -> Box:
    """Return the visible part of a box of a key frame's picture, in pixels of the page."""
    seen = box.intersection(window).moved(-window.left, -window.top)
    return seen.scaled(picture.width / max(window.width, 1e-6)).moved(picture.left, picture.top)


def map_point_to_page(point: Point, window: Box, picture: Rectangle) -> Point:
    """Return a point of a key frame's picture in pixels of the page."""
    factor = picture.width / max(window.width, 1e-6)
    return picture.left + (point[0] - window.left) * factor, picture.top + (point[1] - window.top) * factor


def shift_window(window: Box, key_frame: KeyFrame) -> Iterator[Box]:
    """Yield other windows of the same size that show as much of the main person, or else of the saliency."""
    height, width = key_frame.shape
    face = main_face(key_frame)
    kept = key_frame.saliency if face is None else face.padded(_SHOULDER_FACE_RATIO * face.width, 0, 0)
    kept = kept.intersection(window)
    left, right = max(0.0, kept.right - window.width), min(width - window.width, kept.left)
    top, bottom = max(0.0, kept.bottom - window.height), min(height - window.height, kept.top)
    for x, y in _SHIFT_RATIOS:
        across = x * (right - window.left if x > 0 else window.left - left)
        down = y * (bottom - window.top if y > 0 else window.top - top)
        if abs(across) + abs(down) >= 1 and left <= right and top <= bottom:
            yield window.moved(across, down)
