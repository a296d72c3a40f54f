"""Placement of balloons and captions in a panel: clear of faces, in reading order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.comic.analyze.saliency import mean_under
from vidstyle.comic.lettering.bubble import (
    BALLOON_KINDS,
    Bubble,
    BubbleKind,
    TextBlock,
    add_face_margin,
    add_tail,
    bubble_size,
    max_tail_length,
)
from vidstyle.regions.boxes import Box, Point
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS

# The search for positions.
_POSITIONS_PER_SIDE_COUNT = 11
"""Number of candidate positions along each side."""
_MAX_COMBINED_POSITIONS = 28
"""Maximum number of positions of a balloon that are combined with the positions of the next one."""
_MIN_DISTANCE_PX = 2.0
"""Minimum distance between balloons."""
_MAX_COVERED_SHARE = 0.36
"""Maximum share of a panel that its balloons cover together."""

# The shape of balloons and captions: width divided by height.
_MIN_BALLOON_ASPECT, _MAX_BALLOON_ASPECT = 1.0, 4.5
_MAX_CAPTION_ASPECT = 12.0
_BEST_BALLOON_ASPECT, _BEST_CAPTION_ASPECT = 2.0, 5.0

# The costs of a position.
_ATTENTION_COST = 1.8
"""Cost of covering an area that draws attention."""
_TOP_DISTANCE_COST = 0.7
"""Cost of the distance from the top of the panel."""
_FREE_EDGES_COST = 0.08
"""Cost of touching neither the upper nor the lower edge."""
_CAPTION_SIDE_COST = 0.3
"""Cost of a caption's distance from the side where reading begins."""
_SPEAKER_DISTANCE_COST = 0.7
"""Cost of the distance to the speaker."""
_ASPECT_COST = 0.3
"""Cost of the deviation from the best aspect."""
_BELOW_MOUTH_COST = 0.5
"""Cost of being below the speaker's mouth."""
_SIZE_COST = 0.6
"""Cost of the covered share of the panel."""
_NO_TAIL_COST = 2.0
"""Cost of being too far from the speaker for a tail."""
_HIDDEN_TAIL_COST = 0.3
"""Cost of being too close to the speaker for a visible tail."""


@dataclass(frozen=True)
class FreeSpace:
    """The area of a panel for text, in pixels of the page.

    Attributes:
        area: where balloons may be placed.
        picture: the whole picture.
        faces: visible parts of faces, and other areas that must stay clear.
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
        kind: kind of its bubble.
        blocks: its possible line breaks.
        face: face of the speaker, or None.
        mouth: their mouth; None: its usual place in a face.
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


def place_bubbles(
    wordings: Sequence[Wording], room: FreeSpace, right_to_left: bool = False
) -> list[Bubble] | None:
    """Place balloons and captions for all texts, in reading order; None if there is no room for all of them.

    They cover no face. Each is completely below every earlier one, or after it in reading direction and no
    higher. If there is room, none continues below the start of the previous line, where it could be read
    first.
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
        placed = place_bubbles(turned, FreeSpace(area, picture, faces, room.attention[:, ::-1]))
        return placed and [bubble.mirrored(axis) for bubble in placed]
    places = [_places(each, room) for each in wordings]
    most = _MAX_COVERED_SHARE * room.area.area
    found = _find_combination(places, np.empty((0, 4)), most, follows=True)
    found = found or _find_combination(places, np.empty((0, 4)), most, follows=False)
    if found is None:
        return None
    bubbles = [
        Bubble(each.kind, Box(*map(float, choice.boxes[number])), choice.blocks[number])
        for each, choice, number in zip(wordings, places, found[1], strict=True)
    ]
    kept, tailed = list(map(add_face_margin, room.faces)), list[Bubble]()
    for bubble, each in zip(bubbles, wordings, strict=True):
        in_the_way = kept + [other.box for other in bubbles if other is not bubble]
        mouth = each.face and (each.mouth or USUAL_LANDMARKS.mouth(each.face))
        tailed.append(add_tail(bubble, each.face, mouth, in_the_way) if each.face and mouth else bubble)
    return tailed


def _places(wording: Wording, room: FreeSpace) -> _Places:
    boxes, prices, blocks = [np.empty((0, 4))], [np.empty(0)], list[TextBlock]()
    for block in wording.blocks:
        width, height = bubble_size(wording.kind, block)
        if (
            width > room.area.width
            or height > room.area.height
            or not _has_good_aspect(wording, width, height)
        ):
            continue
        tried = _list_boxes(width, height, room)
        boxes.append(tried)
        prices.append(_box_costs(tried, wording, room))
        blocks += [block] * len(tried)
    price, box = np.concatenate(prices), np.concatenate(boxes)
    order = np.argsort(price, kind="stable")
    return _Places(box[order], price[order], [blocks[number] for number in order])


def _has_good_aspect(wording: Wording, width: float, height: float) -> bool:
    if wording.kind not in BALLOON_KINDS:
        return height * 0.8 <= width <= _MAX_CAPTION_ASPECT * height or len(wording.blocks) == 1
    return _MIN_BALLOON_ASPECT * height <= width <= _MAX_BALLOON_ASPECT * height or len(wording.blocks) == 1


def _list_boxes(width: float, height: float, room: FreeSpace) -> np.ndarray:
    """Return boxes on a grid, and boxes that touch a face; none covers a face: count x 4."""
    area, faces = room.area, list(map(add_face_margin, room.faces))
    lefts = [*np.linspace(area.left, area.right - width, _POSITIONS_PER_SIDE_COUNT)]
    tops = [*np.linspace(area.top, area.bottom - height, _POSITIONS_PER_SIDE_COUNT)]
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


def _box_costs(boxes: np.ndarray, wording: Wording, room: FreeSpace) -> np.ndarray:
    area = room.area
    width, height = boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1]
    # Squared, as covering half of an object is worse than covering its surroundings.
    price = _ATTENTION_COST * np.sqrt(mean_under(room.attention**2, room.picture, boxes))
    price += _TOP_DISTANCE_COST * (boxes[:, 1] - area.top) / area.height
    price += _SIZE_COST * width * height / area.area
    price += _FREE_EDGES_COST * ((boxes[:, 1] > area.top) & (boxes[:, 3] < area.bottom - 1))
    flat = _BEST_BALLOON_ASPECT if wording.kind in BALLOON_KINDS else _BEST_CAPTION_ASPECT
    price += _ASPECT_COST * np.log(width / height / flat) ** 2
    if wording.kind not in BALLOON_KINDS:
        return price + _CAPTION_SIDE_COST * (boxes[:, 0] - area.left) / area.width
    face = wording.face
    if face is None:
        return price
    across, down = face.center
    distance = np.hypot((boxes[:, 0] + boxes[:, 2]) / 2 - across, (boxes[:, 1] + boxes[:, 3]) / 2 - down)
    below = _BELOW_MOUTH_COST * (boxes[:, 1] > down)
    price += _SPEAKER_DISTANCE_COST * distance / math.hypot(area.width, area.height) + below
    # The gap between the balloon and the face: if no tail can bridge it, the balloon has no speaker.
    gap_beside = np.maximum(face.left - boxes[:, 2], boxes[:, 0] - face.right)
    gap_above = np.maximum(face.top - boxes[:, 3], boxes[:, 1] - face.bottom)
    gap = np.hypot(np.maximum(0, gap_beside), np.maximum(0, gap_above))
    size = wording.blocks[0].size
    price += _NO_TAIL_COST * (gap > 0.8 * max_tail_length(size, face))
    return price + _HIDDEN_TAIL_COST * (gap < size)


def _find_combination(
    places: Sequence[_Places], taken: np.ndarray, left: float, follows: bool
) -> tuple[float, list[int]] | None:
    """Return the cheapest combination of boxes for all texts, read after the taken boxes, and its cost.

    `left`: the area that they may cover; `follows`: see `_is_read_after`.
    """
    if not places:
        return 0.0, []
    first, free = places[0], _is_read_after(places[0].boxes, taken, follows)
    sizes = (first.boxes[:, 2] - first.boxes[:, 0]) * (first.boxes[:, 3] - first.boxes[:, 1])
    numbers = np.flatnonzero(free & (sizes <= left))
    if len(places) > 1 and len(numbers) > _MAX_COMBINED_POSITIONS:
        # The cheapest ones may leave no room for the next: others are tried too.
        spread = np.linspace(0, len(numbers) - 1, _MAX_COMBINED_POSITIONS // 2).astype(int)
        numbers = np.unique(np.concatenate([numbers[: _MAX_COMBINED_POSITIONS // 2], numbers[spread]]))
    best: tuple[float, list[int]] | None = None
    for number in map(int, numbers[: None if len(places) > 1 else 1]):
        rest = _find_combination(
            places[1:], np.vstack([taken, first.boxes[number]]), left - float(sizes[number]), follows
        )
        price = float(first.prices[number])
        if rest is not None and (best is None or price + rest[0] < best[0]):
            best = price + rest[0], [number, *rest[1]]
    return best


def _is_read_after(boxes: np.ndarray, taken: np.ndarray, follows: bool) -> np.ndarray:
    """Return which boxes are read after all boxes in `taken`: below them, or next to them and no higher.

    `follows`: a box also reaches as far in reading direction as the last one begins: below two balloons in
    one line, it could be read as the second.
    """
    free = np.ones(len(boxes), bool)
    for earlier in taken:
        below = boxes[:, 1] >= earlier[3] + _MIN_DISTANCE_PX
        free &= below | ((boxes[:, 0] >= earlier[2] + _MIN_DISTANCE_PX) & (boxes[:, 1] >= earlier[1]))
    if follows and len(taken):
        free &= boxes[:, 2] >= taken[-1][0]
    return free
