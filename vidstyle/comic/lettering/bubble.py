"""Balloons and captions as shapes: what surrounds a text, and the tail that says who speaks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from vidstyle.comic.lettering.wrap import LINE, TextBlock
from vidstyle.comic.moment import Box

Point = tuple[float, float]
BubbleKind = Literal["balloon", "caption", "band"]

LINE_WIDTH = 0.09
"""Of the line around it, in sizes of the letters."""

_ROUND = 3.2
"""The exponent of a balloon's outline, a superellipse: 2 is an ellipse, more is nearer to a rectangle."""
_PADDING = 0.55, 0.5
"""Around a balloon's text, aside and above, in sizes of the letters."""
_CAPTION_PADDING = 0.5, 0.4
_TAIL = 0.55
"""Half the width of a tail's root, in sizes of the letters."""


@dataclass(frozen=True)
class Bubble:
    """A text and what is around it, on a page, in pixels.

    Attributes:
        kind: "balloon" for speech, "caption" for a box, "band" for a text without a box of its own.
        box: all of it but the tail.
        tip: where the tail ends, or None.
    """

    kind: BubbleKind
    box: Box
    block: TextBlock
    tip: Point | None = None

    def mirrored(self, axis: float) -> Bubble:
        """The bubble mirrored left to right on a page of width `axis`."""
        tip = self.tip and (axis - self.tip[0], self.tip[1])
        return replace(self, box=self.box.mirrored(axis), tip=tip)

    @property
    def line_width(self) -> float:
        """Of the outline, half of which lies outside the box."""
        return max(1.0, LINE_WIDTH * self.block.size)

    @cached_property
    def outline(self) -> list[Point]:
        """The corners of the shape, a polygon; of a tail root, tip and root come first."""
        box = self.box
        if self.kind != "balloon":
            left, top, right, bottom = box
            return [(left, top), (right, top), (right, bottom), (left, bottom)]
        around = _superellipse(box.center, box.width / 2, box.height / 2, 0.15 * self.block.size)
        if self.tip is None:
            return _points(around)
        direction = np.subtract(self.tip, self.box.center)
        direction = direction / max(float(np.linalg.norm(direction)), 1e-6)
        off = around - self.box.center
        aside = np.abs(off[:, 0] * direction[1] - off[:, 1] * direction[0])
        root = (aside <= _TAIL * self.block.size) & (off @ direction > 0)
        first = int(np.argmax(root & ~np.roll(root, 1)))
        turned, count = np.roll(around, -first, axis=0), int(root.sum())
        # The ends of the root stay, so that it is as wide as is meant.
        return _points(np.concatenate([turned[:1], [self.tip], turned[max(1, count - 1) :]]))

    @property
    def lines(self) -> list[tuple[str, float, float, float]]:
        """Each line, with its left end, its foot and its width."""
        size, (middle, center) = self.block.size, self.box.center
        top = center - self.block.height / 2
        pad = _CAPTION_PADDING[0] * size
        return [
            (
                text,
                middle - width / 2 if self.kind == "balloon" else self.box.left + pad,
                top + (number * LINE + 0.8) * size,
                width,
            )
            for number, (text, width) in enumerate(zip(self.block.lines, self.block.widths, strict=True))
        ]


def _superellipse(middle: Point, wide: float, high: float, step: float) -> np.ndarray:
    """The outline with these half axes: points x 2, about `step` pixels apart."""
    angles = np.linspace(0, 2 * math.pi, 721)
    across, down = np.cos(angles), np.sin(angles)
    x = wide * np.sign(across) * np.abs(across) ** (2 / _ROUND)
    y = high * np.sign(down) * np.abs(down) ** (2 / _ROUND)
    way = np.concatenate([[0], np.hypot(np.diff(x), np.diff(y)).cumsum()])
    stops = np.linspace(0, way[-1], math.ceil(way[-1] / step), endpoint=False)
    return np.stack([middle[0] + np.interp(stops, way, x), middle[1] + np.interp(stops, way, y)], axis=1)


def _points(around: np.ndarray) -> list[Point]:
    return [(float(x), float(y)) for x, y in around]


def size_of(kind: BubbleKind, block: TextBlock) -> tuple[float, float]:
    """Width and height of the box around a text."""
    across, down = (pad * block.size for pad in (_PADDING if kind == "balloon" else _CAPTION_PADDING))
    wide, high = block.width / 2 + across, block.height / 2 + down
    if kind == "balloon":
        scale = _swelling(block, wide, high)
        wide, high = wide * scale, high * scale
    return math.ceil(2 * wide), math.ceil(2 * high)


def _swelling(block: TextBlock, wide: float, high: float) -> float:
    """How much larger the half axes must be for the outline to hold the corners of all lines."""
    scale = 1.0
    for number, width in enumerate(block.widths):
        top = number * LINE * block.size - block.height / 2
        for y in (top + 0.1 * block.size, top + 0.95 * block.size):
            x = width / 2 + 0.25 * block.size
            scale = max(scale, ((x / wide) ** _ROUND + (abs(y) / high) ** _ROUND) ** (1 / _ROUND))
    return scale


FACE_ROOM = 0.06
"""Around faces, in sides of them: nothing is written there."""

_SHORTEST, _AIR = 0.4, 0.1
"""How far a tail stands out at least, and ends before what it points at, in sizes of the letters."""
_LONGEST = 12.0
"""A longer one might run over somebody else."""


def with_face_room(face: Box) -> Box:
    """A face, and what is about it that must not be covered."""
    across, down = FACE_ROOM * face.width, FACE_ROOM * face.height
    return face.padded(across, down, down)


def with_tail(bubble: Bubble, face: Box | None, kept: Sequence[Box]) -> Bubble:
    """A balloon with a tail towards the face, as long as nothing is in its way.

    Args:
        kept: where no tail may be: all faces with room about them, and other balloons.
    """
    if bubble.kind != "balloon" or face is None:
        return bubble
    mouth = face.center[0], face.top + 0.75 * face.height
    tips = _tips(bubble, mouth, with_face_room(face), kept)
    if tips and math.dist(tips[-1], bubble.box.center) > _LONGEST * bubble.block.size + bubble.box.width / 2:
        return bubble
    # One that ends on half its way points at nobody.
    tails = (replace(bubble, tip=tip) for tip in reversed(tips[len(tips) // 2 :]))
    return next((tail for tail in tails if not _crosses(tail, kept)), bubble)


def _tips(bubble: Bubble, mouth: Point, face: Box, kept: Sequence[Box]) -> list[Point]:
    """Where the tail may end: outside the balloon, on its way until the face; nowhere if it is not free."""
    start, size = bubble.box.center, bubble.block.size
    tips: list[Point] = []
    for part in np.linspace(0, 1, max(2, math.ceil(math.dist(start, mouth) / 2)))[:-1]:
        tip = start[0] + float(part) * (mouth[0] - start[0]), start[1] + float(part) * (mouth[1] - start[1])
        if _is_in(tip, bubble.box, _SHORTEST * size):
            continue
        if _is_in(tip, face, _AIR * size):
            return tips
        if any(_is_in(tip, box, _AIR * size) for box in kept):
            return []
        tips.append(tip)
    return tips


def _crosses(bubble: Bubble, kept: Sequence[Box]) -> bool:
    """Whether an edge of the tail runs through what is to be kept free."""
    root, tip, other = (np.array(point) for point in bubble.outline[:3])
    steps = np.linspace(0, 1, 40)[:, np.newaxis]
    points = np.concatenate([root + steps * (tip - root), other + steps * (tip - other)])
    return any(_is_in((x, y), box, 0) for x, y in points for box in kept)


def _is_in(point: Point, box: Box, room: float) -> bool:
    left, top, right, bottom = box.padded(room, room, room)
    return left <= point[0] <= right and top <= point[1] <= bottom
