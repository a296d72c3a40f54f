"""What a panel shows of its picture."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vidstyle.comic.layout.paper import Rectangle
from vidstyle.comic.moment import Box, Moment

NEAREST = 0.5
"""How much of the picture's fitting side a panel shows at least."""
NEAREST_TINY = 0.35
"""The same where the main face is tiny."""
NEAREST_FACELESS = 0.75
"""The same without a face: what is salient is known less surely than what is a face."""
TINY = 1 / 12
"""A face is tiny if it is lower than this part of the picture."""
AROUND = 1.6
"""A panel is that much larger than what it must hold, where the picture is."""
HEAD_ROOM = 0.35
"""Above a face, in heights of it: hair, and air."""
NECK_ROOM = 0.2
SIDE_ROOM = 0.15

_THIRDS = (1 / 3, 2 / 3)
_EYES = 0.4
"""Where the middle of a face stands in a panel's height: its eyes are a little above, at a third."""
_MAIN, _CUT, _LOST, _SLICED, _OUT, _ROOM = 1000.0, 100.0, 30.0, 10.0, 8.0, 6.0
"""Prices: a part of the main face that is not shown, a face cut, a part of the saliency lost, a blob cut, a
face left out, head room missing."""
_TOP, _THIRD, _SHIFT = 4.0, 1.0, 0.3
"""A part of the saliency lost above, where heads are; distance to a third, and to the picture's middle."""
_MANY = 12
"""The most blobs considered, the largest first."""
_NEARER = 4.0
"""The price of a window that is nearer than wanted by the largest one's side."""
_EXACT = 1e-6


def crop(moment: Moment, aspect: float) -> Box:
    """The window of a picture that a panel shows: it holds faces and saliency, and stands by the thirds.

    The window is as large as fits, but nearer where what it must hold is small. It has the lowest price
    of those whose edges, or whose thirds, meet an edge or the middle of a face or of the saliency: first
    it holds the main (the largest) face, then it cuts none, then it holds the saliency, then the other
    faces and the room above the main one's head; then the thirds.

    Args:
        aspect: width by height of the panel, above 0.

    Returns:
        A window within the picture, of just that aspect, in pixels.
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
    """A face with hair, neck and air, as far as the picture goes."""
    height, width = moment.shape
    roomy = face.padded(SIDE_ROOM * face.width, HEAD_ROOM * face.height, NECK_ROOM * face.height)
    return roomy.intersection(Box(0, 0, width, height))


def what_counts(moment: Moment) -> Box:
    """The smallest box that holds the saliency and all faces with room about them."""
    kept = moment.saliency
    for face in moment.faces:
        kept = kept.union(with_room(moment, face))
    return kept


def _largest_blobs(moment: Moment) -> list[Box]:
    return sorted(moment.blobs, key=lambda blob: -blob.area)[:_MANY]


def _scales(moment: Moment, width: float, height: float) -> list[float]:
    """What parts of the largest window's sides are tried: first what is wanted, then less.

    From nearer, a face may be left out that would else be cut.
    """
    face = main_face(moment)
    if face is None:
        least = NEAREST_FACELESS
    else:
        least = NEAREST_TINY if face.height < TINY * moment.shape[0] else NEAREST
    kept = what_counts(moment)
    wanted = AROUND * max(kept.width / width, kept.height / height)
    near = min(1.0, max(least, wanted))
    return [near, (near + least) / 2, least]


def _best(moment: Moment, width: float, height: float, nearer: float) -> tuple[float, Box]:
    """The window of a size with the lowest price."""
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
    """Where a window may begin along one axis, within the picture, each place once."""
    places = [0.0, whole - side, (whole - side) / 2]
    places += [middle - part * side for part in (*_THIRDS, 0.5, _EYES)]
    for low, high in spans:
        places += [low, high, low - side, high - side]
    return np.unique(np.clip(places, 0.0, max(0.0, whole - side)))


def _price(moment: Moment, left: np.ndarray, top: np.ndarray, width: float, height: float) -> np.ndarray:
    """The price of windows at `left` x `top`."""
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
    """The part of a span that lies in a window."""
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
    """How far the subject is from the thirds, in sides of the window; the middle is nearly as good."""
    across, down = (subject.center[0] - left) / width, (subject.center[1] - top) / height
    return _from_third(across) + (np.abs(down - _EYES) if is_face else _from_third(down))


def _from_third(part: np.ndarray) -> np.ndarray:
    aside = np.minimum(np.abs(part - _THIRDS[0]), np.abs(part - _THIRDS[1]))
    return np.minimum(aside, np.abs(part - 0.5) + 0.08)


_SHIFTS = ((0, -0.5), (0, -1), (-0.5, 0), (0.5, 0), (-1, 0), (1, 0), (0, 0.5))
"""Where else a panel may look, in parts of the way to the edge of the picture or of what must be seen."""


def within_border(rectangle: Rectangle, border: int) -> Rectangle:
    """What a border of so many pixels leaves of a panel."""
    left, top, right, bottom = rectangle
    return Rectangle(left + border, top + border, right - border, bottom - border)


def on_page(box: Box, window: Box, picture: Rectangle) -> Box:
    """A box of a moment's picture as it is on the page, as far as it can be seen."""
    seen = box.intersection(window).moved(-window.left, -window.top)
    return seen.scaled(picture.width / max(window.width, 1e-6)).moved(picture.left, picture.top)


def elsewhere(window: Box, moment: Moment) -> Iterator[Box]:
    """Other windows of the same size in which the main face, or without one what is salient, is as whole."""
    height, width = moment.shape
    kept = (main_face(moment) or moment.saliency).intersection(window)
    left, right = max(0.0, kept.right - window.width), min(width - window.width, kept.left)
    top, bottom = max(0.0, kept.bottom - window.height), min(height - window.height, kept.top)
    for x, y in _SHIFTS:
        across = x * (right - window.left if x > 0 else window.left - left)
        down = y * (bottom - window.top if y > 0 else window.top - top)
        if abs(across) + abs(down) >= 1 and left <= right and top <= bottom:
            yield window.moved(across, down)
