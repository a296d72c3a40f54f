"""Placement of balloons and captions in a panel: clear of faces, in reading order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.comic.analyze.saliency import mean_under
from vidstyle.comic.key_frame import Box, Point, usual_mouth
from vidstyle.comic.lettering.bubble import (
    BALLOONS,
    Bubble,
    BubbleKind,
    TextBlock,
    longest_tail,
    size_of,
    with_face_room,
    with_tail,
)

_GRID = 11
"""Candidate positions along each side."""
_TRIED = 28
"""Candidate positions of a balloon that are combined with those of the next."""
_APART = 2.0
"""Minimum distance between balloons, in pixels."""
_TALLEST, _WIDEST = 1.0, 4.5
"""Range of the aspect (width by height) of balloons."""
_WIDEST_CAPTION = 12.0
_SHARE = 0.36
"""Maximum share of a panel that its balloons cover together."""
_FLAT_BALLOON, _FLAT_CAPTION = 2.0, 5.0
"""The best aspects."""
_SEEN, _LOW, _LOOSE, _ASIDE, _FAR, _FLAT, _BELOW, _BIG = 1.8, 0.7, 0.08, 0.3, 0.7, 0.3, 0.5, 0.6
_MUTE, _CLOSE = 2.0, 0.3
"""Costs: attention covered, distance from the top, touching neither the upper nor the lower edge, distance of
a caption from the side where reading begins, distance to the speaker, deviation from the best aspect, being
below the speaker's mouth, size, too far from the speaker for a tail, too close for one to be seen."""


@dataclass(frozen=True)
class FreeSpace:
    """Where text can be placed in a panel, in pixels of the page.

    Attributes:
        area: where balloons may stand.
        picture: the whole picture.
        faces: visible parts of faces, and what else must stay clear.
        attention: the picture's attention map, rows x columns, about 1 on average.
    """

    area: Box
    picture: Box
    faces: tuple[Box, ...]
    attention: np.ndarray


@dataclass(frozen=True)
class Wording:
    """A text to be placed.

    Attributes:
        blocks: the line breaks it can take.
        face: face of the speaker, or None.
        mouth: their mouth; None: where it usually is in a face.
    """

    kind: BubbleKind
    blocks: Sequence[TextBlock]
    face: Box | None = None
    mouth: Point | None = None


@dataclass(frozen=True)
class _Places:
    """Candidate boxes of one text (left, top, right, bottom: count x 4) and their costs, cheapest first."""

    boxes: np.ndarray
    prices: np.ndarray
    blocks: list[TextBlock]


def place(wordings: Sequence[Wording], room: FreeSpace, right_to_left: bool = False) -> list[Bubble] | None:
    """Place balloons and captions for all texts, in reading order; None if there is no room for all.

    They cover no face. Each stands wholly below an earlier one, or after it in reading direction and no
    higher.
    """
    if right_to_left:
        axis = room.area.left + room.area.right
        turned = [
            replace(
                each,
                face=each.face and each.face.mirrored(axis),
                mouth=each.mouth and (axis - each.mouth[0], each.mouth[1]),
            )
            for each in wordings
        ]
        faces = tuple(face.mirrored(axis) for face in room.faces)
        area, picture = room.area.mirrored(axis), room.picture.mirrored(axis)
        placed = place(turned, FreeSpace(area, picture, faces, room.attention[:, ::-1]))
        return placed and [bubble.mirrored(axis) for bubble in placed]
    places = [_places(each, room) for each in wordings]
    found = _best(places, np.empty((0, 4)), _SHARE * room.area.area)
    if found is None:
        return None
    bubbles = [
        Bubble(each.kind, Box(*map(float, choice.boxes[number])), choice.blocks[number])
        for each, choice, number in zip(wordings, places, found[1], strict=True)
    ]
    kept, tailed = list(map(with_face_room, room.faces)), list[Bubble]()
    for bubble, each in zip(bubbles, wordings, strict=True):
        in_the_way = kept + [other.box for other in bubbles if other is not bubble]
        mouth = each.face and (each.mouth or usual_mouth(each.face))
        tailed.append(with_tail(bubble, each.face, mouth, in_the_way) if each.face and mouth else bubble)
    return tailed


def _places(wording: Wording, room: FreeSpace) -> _Places:
    boxes, prices, blocks = [np.empty((0, 4))], [np.empty(0)], list[TextBlock]()
    for block in wording.blocks:
        width, height = size_of(wording.kind, block)
        if width > room.area.width or height > room.area.height or not _is_shapely(wording, width, height):
            continue
        tried = _tried(width, height, room)
        boxes.append(tried)
        prices.append(_prices(tried, wording, room))
        blocks += [block] * len(tried)
    price, box = np.concatenate(prices), np.concatenate(boxes)
    order = np.argsort(price, kind="stable")
    return _Places(box[order], price[order], [blocks[number] for number in order])


def _is_shapely(wording: Wording, width: float, height: float) -> bool:
    if wording.kind not in BALLOONS:
        return height * 0.8 <= width <= _WIDEST_CAPTION * height or len(wording.blocks) == 1
    return _TALLEST * height <= width <= _WIDEST * height or len(wording.blocks) == 1


def _tried(width: float, height: float, room: FreeSpace) -> np.ndarray:
    """Boxes on a grid, and boxes that touch a face; none covers one: count x 4."""
    area, faces = room.area, list(map(with_face_room, room.faces))
    lefts = [*np.linspace(area.left, area.right - width, _GRID)]
    tops = [*np.linspace(area.top, area.bottom - height, _GRID)]
    for face in faces:
        lefts += [face.left - width, face.right]
        tops += [face.top - height, face.bottom]
    x, y = (np.unique(np.round(each)) for each in (lefts, tops))
    x = x[(x >= area.left) & (x + width <= area.right)]
    y = y[(y >= area.top) & (y + height <= area.bottom)]
    left, top = (each.ravel() for each in np.meshgrid(x, y))
    right, bottom = left + width, top + height
    is_free = np.ones(len(left), bool)
    for face in faces:
        is_free &= (right <= face.left) | (left >= face.right) | (bottom <= face.top) | (top >= face.bottom)
    return np.stack([left, top, right, bottom], axis=1)[is_free]


def _prices(boxes: np.ndarray, wording: Wording, room: FreeSpace) -> np.ndarray:
    area = room.area
    width, height = boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1]
    # Squared: half of a thing covered is worse than as much of its surroundings.
    price = _SEEN * np.sqrt(mean_under(room.attention**2, room.picture, boxes))
    price = price + _LOW * (boxes[:, 1] - area.top) / area.height + _BIG * width * height / area.area
    price = price + _LOOSE * ((boxes[:, 1] > area.top) & (boxes[:, 3] < area.bottom - 1))
    flat = _FLAT_BALLOON if wording.kind in BALLOONS else _FLAT_CAPTION
    price += _FLAT * np.log(width / height / flat) ** 2
    if wording.kind not in BALLOONS:
        return price + _ASIDE * (boxes[:, 0] - area.left) / area.width
    face = wording.face
    if face is None:
        return price
    across, down = face.center
    distance = np.hypot((boxes[:, 0] + boxes[:, 2]) / 2 - across, (boxes[:, 1] + boxes[:, 3]) / 2 - down)
    price += _FAR * distance / math.hypot(area.width, area.height) + _BELOW * (boxes[:, 1] > down)
    # The room between the balloon and the face: where it is longer than a tail, nobody speaks.
    beside = np.maximum(face.left - boxes[:, 2], boxes[:, 0] - face.right)
    above = np.maximum(face.top - boxes[:, 3], boxes[:, 1] - face.bottom)
    room_between = np.hypot(np.maximum(0, beside), np.maximum(0, above))
    size = wording.blocks[0].size
    return price + _MUTE * (room_between > 0.8 * longest_tail(size, face)) + _CLOSE * (room_between < size)


def _best(places: Sequence[_Places], taken: np.ndarray, left: float) -> tuple[float, list[int]] | None:
    """The cheapest combination of boxes for all texts, read after those taken, and its cost."""
    if not places:
        return 0.0, []
    first, free = places[0], _after(places[0].boxes, taken)
    sizes = (first.boxes[:, 2] - first.boxes[:, 0]) * (first.boxes[:, 3] - first.boxes[:, 1])
    numbers = np.flatnonzero(free & (sizes <= left))
    if len(places) > 1 and len(numbers) > _TRIED:
        # The cheapest ones may leave no room for the next: others are tried, too.
        spread = np.linspace(0, len(numbers) - 1, _TRIED // 2).astype(int)
        numbers = np.unique(np.concatenate([numbers[: _TRIED // 2], numbers[spread]]))
    best: tuple[float, list[int]] | None = None
    for number in map(int, numbers[: None if len(places) > 1 else 1]):
        rest = _best(places[1:], np.vstack([taken, first.boxes[number]]), left - float(sizes[number]))
        price = float(first.prices[number])
        if rest is not None and (best is None or price + rest[0] < best[0]):
            best = price + rest[0], [number, *rest[1]]
    return best


def _after(boxes: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """Which boxes are read after all that are taken: below, or beside them and no higher."""
    free = np.ones(len(boxes), bool)
    for earlier in taken:
        below = boxes[:, 1] >= earlier[3] + _APART
        free &= below | ((boxes[:, 0] >= earlier[2] + _APART) & (boxes[:, 1] >= earlier[1]))
    return free
