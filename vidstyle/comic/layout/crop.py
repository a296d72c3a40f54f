"""Cropping: the window of a moment's picture that a panel shows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vidstyle.comic.moment import Box, Moment, Point, Rectangle

NEAREST = 0.5
"""Minimum size of a window, relative to the largest one of its aspect."""
NEAREST_TINY = 0.35
"""The same if the main face is tiny."""
NEAREST_FACELESS = 0.75
"""The same without a face: saliency is less certain than a face."""
TINY = 1 / 12
"""A face is tiny if its height is below this share of the picture's."""
AROUND = 1.6
"""Wanted size of a window, relative to its content."""
AROUND_NEAR = 1.05
"""The same for a moment that is shown from near."""
HEAD_ROOM = 0.35
"""Head room above a face, in heights of the face."""
NECK_ROOM = 0.2
SIDE_ROOM = 0.15

_THIRDS = (1 / 3, 2 / 3)
_EYES = 0.4
"""Wanted height of a face's centre in a panel, from the top: its eyes are then at a third."""
_MAIN, _CUT, _LOST, _SLICED, _OUT, _ROOM = 1000.0, 100.0, 30.0, 10.0, 8.0, 6.0
"""Costs: main face lost, a face cut, saliency lost, a blob cut, a face left out, head room lost."""
_TOP, _THIRD, _SHIFT = 4.0, 1.0, 0.3
"""Costs: saliency lost at the top, distance to a third, distance to the picture's centre."""
_MANY = 12
"""Maximum number of blobs considered, the largest first."""
_NEARER = 4.0
"""Cost of a window smaller than wanted, per side of the largest one."""
_EXACT = 1e-6


def crop(moment: Moment, aspect: float) -> Box:
    """The window of a picture that a panel shows: faces and saliency, composed by the rule of thirds.

    The window is as large as fits, or smaller if its content is small. Candidates are the windows whose
    edges or thirds meet an edge or the centre of a face or of the salient box; the one with the lowest cost
    is taken. In order of weight: it contains the main (largest) face, cuts no face, contains the saliency,
    the other faces and the head room of the main one, and follows the thirds.

    Args:
        aspect: width by height of the panel, above 0.

    Returns:
        A window within the picture, of exactly that aspect, in pixels.
    """
    width, height = largest(moment, aspect)
    scales = _scales(moment, width, height)
    windows = [_best(moment, width * scale, height * scale, scales[0] - scale) for scale in scales]
    return min(windows, key=lambda window: window[0])[1]


def largest(moment: Moment, aspect: float) -> tuple[float, float]:
    """Width and height of the largest window of an aspect within a moment's picture."""
    height, width = moment.shape
    across = min(float(width), height * aspect)
    return across, min(float(height), across / aspect)


def main_face(moment: Moment) -> Box | None:
    """The largest face."""
    return max(moment.faces, key=lambda face: face.area, default=None)


def with_room(moment: Moment, face: Box) -> Box:
    """A face with hair and neck, clipped to the picture."""
    height, width = moment.shape
    roomy = face.padded(SIDE_ROOM * face.width, HEAD_ROOM * face.height, NECK_ROOM * face.height)
    return roomy.intersection(Box(0, 0, width, height))


def what_counts(moment: Moment) -> Box:
    """The smallest box that contains the saliency and all faces with their room."""
    kept = moment.saliency
    for face in moment.faces:
        kept = kept.union(with_room(moment, face))
    return kept


def must_show(moment: Moment) -> Box:
    """What a panel may not cut, or the whole picture would be better: the large faces, or the saliency.

    Faces at least half as high as the main one belong together, as those of a pair.
    """
    main = main_face(moment)
    if main is None:
        return moment.saliency
    kept = with_room(moment, main)
    for face in moment.faces:
        kept = kept.union(with_room(moment, face)) if face.height >= main.height / 2 else kept
    return kept


def _largest_blobs(moment: Moment) -> list[Box]:
    return sorted(moment.blobs, key=lambda blob: -blob.area)[:_MANY]


def _scales(moment: Moment, width: float, height: float) -> list[float]:
    """Sizes to try, relative to the largest window: the wanted one, then smaller ones.

    A smaller window may leave a face out that would otherwise be cut.
    """
    if moment.framing == "wide":
        return [1.0]
    face = main_face(moment)
    if moment.framing == "near":
        least = NEAREST_TINY
    elif face is None:
        least = NEAREST_FACELESS
    else:
        least = NEAREST_TINY if face.height < TINY * moment.shape[0] else NEAREST
    kept = what_counts(moment)
    around = AROUND_NEAR if moment.framing == "near" else AROUND
    wanted = around * max(kept.width / width, kept.height / height)
    near = min(1.0, max(least, wanted))
    return [near, (near + least) / 2, least]


def _best(moment: Moment, width: float, height: float, nearer: float) -> tuple[float, Box]:
    """The window of a size with the lowest cost, and that cost."""
    subject = main_face(moment) or moment.saliency
    boxes = [moment.saliency, *moment.faces, with_room(moment, subject), *_largest_blobs(moment)]
    tall, wide = moment.shape
    lefts = _places([(box.left, box.right) for box in boxes], subject.center[0], width, wide)
    tops = _places([(box.top, box.bottom) for box in boxes], subject.center[1], height, tall)
    prices = _price(moment, lefts[:, None], tops[None, :], width, height) + _NEARER * nearer
    across, down = divmod(int(prices.argmin()), len(tops))
    left, top = float(lefts[across]), float(tops[down])
    right, bottom = min(float(wide), left + width), min(float(tall), top + height)
    return float(prices.min()), Box(left, top, right, bottom)


def _places(spans: list[tuple[float, float]], middle: float, side: float, whole: float) -> np.ndarray:
    """Candidate positions of a window along one axis, within the picture, without repetition."""
    places = [0.0, whole - side, (whole - side) / 2]
    places += [middle - part * side for part in (*_THIRDS, 0.5, _EYES)]
    for low, high in spans:
        places += [low, high, low - side, high - side]
    return np.unique(np.clip(places, 0.0, max(0.0, whole - side)))


def _price(moment: Moment, left: np.ndarray, top: np.ndarray, width: float, height: float) -> np.ndarray:
    """The cost of windows at `left` x `top`."""
    face = main_face(moment)
    subject = face or moment.saliency

    def lost(box: Box) -> np.ndarray:
        across = _shown(box.left, box.right, left, width)
        return 1 - across * _shown(box.top, box.bottom, top, height)

    price = _LOST * _missing(lost(moment.saliency))
    for each in moment.faces:
        part = lost(each)
        price = price + _CUT * _is_cut(part) + _OUT * (part > _EXACT)
    over = np.clip(top - moment.saliency.top, 0.0, None) / max(moment.saliency.height, 1.0)
    price = price + _TOP * over
    for blob in _largest_blobs(moment):
        price = price + _SLICED * _is_cut(lost(blob))
    if face is not None:
        price = price + _MAIN * _missing(lost(face)) + _ROOM * _missing(lost(with_room(moment, face)))
    price = price + _THIRD * _composed(subject, left, top, width, height, face is not None)
    tall, wide = moment.shape
    shift = np.abs(left + width / 2 - wide / 2) / wide + np.abs(top + height / 2 - tall / 2) / tall
    return price + _SHIFT * shift


def _shown(low: float, high: float, start: np.ndarray, side: float) -> np.ndarray:
    """The share of a span that lies in a window."""
    inside = np.minimum(high, start + side) - np.maximum(low, start)
    return np.clip(inside / max(high - low, _EXACT), 0.0, 1.0)


def _is_cut(lost: np.ndarray) -> np.ndarray:
    """Where a part of something is lost, but not all."""
    return (lost > _EXACT) & (lost < 1 - _EXACT)


def _missing(lost: np.ndarray) -> np.ndarray:
    """The lost share, plus 1 where anything is lost."""
    return lost + (lost > _EXACT)


def _composed(
    subject: Box, left: np.ndarray, top: np.ndarray, width: float, height: float, is_face: bool
) -> np.ndarray:
    """Distance of the subject from the thirds, in sides of the window; the centre is nearly as good."""
    across, down = (subject.center[0] - left) / width, (subject.center[1] - top) / height
    return _from_third(across) + (np.abs(down - _EYES) if is_face else _from_third(down))


def _from_third(part: np.ndarray) -> np.ndarray:
    aside = np.minimum(np.abs(part - _THIRDS[0]), np.abs(part - _THIRDS[1]))
    return np.minimum(aside, np.abs(part - 0.5) + 0.08)


_SHIFTS = ((0, -0.5), (0, -1), (-0.5, 0), (0.5, 0), (-1, 0), (1, 0), (0, 0.5))
"""Shifts tried, relative to the largest that keeps the main content visible."""


def on_page(box: Box, window: Box, picture: Rectangle) -> Box:
    """The visible part of a box of a moment's picture, in pixels of the page."""
    seen = box.intersection(window).moved(-window.left, -window.top)
    return seen.scaled(picture.width / max(window.width, 1e-6)).moved(picture.left, picture.top)


def point_on_page(point: Point, window: Box, picture: Rectangle) -> Point:
    """A point of a moment's picture in pixels of the page."""
    factor = picture.width / max(window.width, 1e-6)
    return picture.left + (point[0] - window.left) * factor, picture.top + (point[1] - window.top) * factor


def elsewhere(window: Box, moment: Moment) -> Iterator[Box]:
    """Other windows of the same size that show as much of the main face, or of the saliency without one."""
    height, width = moment.shape
    kept = (main_face(moment) or moment.saliency).intersection(window)
    left, right = max(0.0, kept.right - window.width), min(width - window.width, kept.left)
    top, bottom = max(0.0, kept.bottom - window.height), min(height - window.height, kept.top)
    for x, y in _SHIFTS:
        across = x * (right - window.left if x > 0 else window.left - left)
        down = y * (bottom - window.top if y > 0 else window.top - top)
        if abs(across) + abs(down) >= 1 and left <= right and top <= bottom:
            yield window.moved(across, down)
