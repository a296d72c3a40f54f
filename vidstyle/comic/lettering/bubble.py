"""Text broken into lines, and the shape around it: a balloon with a tail to the speaker, or a caption."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from vidstyle.comic.lettering.fonts import Letters, remove_stress
from vidstyle.regions.boxes import Box, Point

BubbleKind = Literal["balloon", "burst", "cloud", "whisper", "caption", "band"]
BALLOON_KINDS = "balloon", "burst", "cloud", "whisper"
"""The kinds that are round, with the text in the middle."""

# Lines and outlines, in font sizes.
OUTLINE_WIDTH_RATIO = 0.09
"""Width of the outline."""
DASH_LENGTH_RATIO = 0.3
"""Length of the dashes around a whisper, and of the gaps between them."""
LINE_HEIGHT_RATIO = 1.2
"""Distance between baselines."""
_OUTLINE_EXPONENT = 3.2
"""Exponent of the superellipse around a balloon: 2 is an ellipse, higher is closer to a rectangle."""
_BALLOON_PADDING_RATIOS, _CAPTION_PADDING_RATIOS = (0.55, 0.5), (0.5, 0.4)
"""Horizontal and vertical padding of the text."""
_EDGE_SHAPES: dict[BubbleKind, tuple[float, float, bool]] = {
    "burst": (1.1, 0.16, True),
    "cloud": (1.5, 0.1, False),
}
"""Distance between the points of an edge, its relative depth, and whether it is pointed."""

# Tails, in font sizes.
FACE_MARGIN_RATIO = 0.06
"""Margin around faces that stays free of text, relative to the face."""
_HALF_TAIL_WIDTH_RATIO = 0.55
"""Half the width of a tail's root."""
_MIN_TAIL_LENGTH_RATIO, _TAIL_FACE_DISTANCE_RATIO = 0.4, 0.1
"""Minimum length of a tail outside the balloon, and its distance from the face."""
_MAX_TAIL_LENGTH_RATIOS = 12.0, 0.4
"""Maximum length of a tail, and in heights of the face: a longer one might cross another person."""
_THOUGHT_RADIUS_RATIOS = 0.62, 0.42, 0.26
"""Radii of the circles that lead from a thought to its head."""

# Line breaks.
_LINE_COUNTS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 19, 24, 30)
"""Numbers of lines tried."""
_MAX_MEASURED_LETTERS = 32
"""Maximum number of letters of a word that are measured at once, unless they fit."""
_WIDE_LETTERS_PATTERN = r"[\u2e80-\u9fff\uac00-\ud7af\uf900-\ufaff\uff00-\uffef]"
"""Characters between which a line may break."""
_PIECE_PATTERN = re.compile(rf"(\s*)({_WIDE_LETTERS_PATTERN}|(?:(?!{_WIDE_LETTERS_PATTERN})\S)+)")


@dataclass(frozen=True)
class TextBlock:
    """A text broken into lines; widths and font size in pixels."""

    lines: tuple[str, ...]
    widths: tuple[float, ...]
    size: int

    @cached_property
    def width(self) -> float:
        """Width of the longest line."""
        return max(self.widths)

    @cached_property
    def height(self) -> float:
        """Height from the top of the first line to the baseline of the last one."""
        return self.size * (LINE_HEIGHT_RATIO * (len(self.lines) - 1) + 1)


@dataclass(frozen=True)
class Bubble:
    """A text and the shape around it, in pixels of the page.

    Attributes:
        kind: "balloon" for speech, "burst" for shouts and sounds, "cloud" for thoughts, "whisper" with a
            dashed outline, "caption" for a box, "band" for a text without its own box.
        box: bounding box without the tail.
        block: the text.
        tip: end of the tail, or None.
    """

    kind: BubbleKind
    box: Box
    block: TextBlock
    tip: Point | None = None

    def mirrored(self, axis: float) -> Bubble:
        """Return the bubble mirrored left to right on a page of width `axis`."""
        tip = self.tip and (axis - self.tip[0], self.tip[1])
        return replace(self, box=self.box.mirrored(axis), tip=tip)

    @property
    def line_width(self) -> float:
        """Width of the outline; half of it is outside the box."""
        return max(1.0, OUTLINE_WIDTH_RATIO * self.block.size)

    @cached_property
    def outline(self) -> np.ndarray:
        """The vertices of the shape, count x 2; a tail (root, tip, root) comes first."""
        box = self.box
        if self.kind not in BALLOON_KINDS:
            left, top, right, bottom = box
            return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
        around = _superellipse(box.center, box.width / 2, box.height / 2, 0.15 * self.block.size)
        if self.kind in _EDGE_SHAPES:
            around = _indent_edge(around, box.center, self.block.size, *_EDGE_SHAPES[self.kind])
        if self.tip is None or self.kind == "cloud":
            return around
        direction = np.subtract(self.tip, box.center)
        direction = direction / max(float(np.linalg.norm(direction)), 1e-6)
        off = around - box.center
        aside = np.abs(off[:, 0] * direction[1] - off[:, 1] * direction[0])
        root = (aside <= _HALF_TAIL_WIDTH_RATIO * self.block.size) & (off @ direction > 0)
        first = int(np.argmax(root & ~np.roll(root, 1)))
        turned, count = np.roll(around, -first, axis=0), int(root.sum())
        # The ends of the root are kept, as they define its width.
        return np.concatenate([turned[:1], [self.tip], turned[max(1, count - 1) :]])

    @property
    def outlines(self) -> list[np.ndarray]:
        """All shapes to draw, each count x 2: the shape around the text last; empty for a band."""
        return [] if self.kind == "band" else [*self._trail(), self.outline]

    def _trail(self) -> Iterator[np.ndarray]:
        """Yield the circles from a thought to the end of its tail."""
        if self.kind != "cloud" or self.tip is None:
            return
        way = np.subtract(self.tip, self.box.center)
        edge = max(
            part for part in np.linspace(0, 1, 200) if _is_in(self.box.center + part * way, self.box, 0)
        )
        for number, radius in enumerate(_THOUGHT_RADIUS_RATIOS):
            middle = self.box.center + way * (
                edge + (1 - edge) * (number + 0.8) / len(_THOUGHT_RADIUS_RATIOS)
            )
            high = radius * self.block.size
            yield _superellipse((middle[0], middle[1]), 1.2 * high, high, 0.15 * self.block.size, 2)

    @property
    def lines(self) -> list[tuple[str, float, float, float]]:
        """Each line with its left end, baseline and width."""
        block, (middle, center) = self.block, self.box.center
        top, indented = center - block.height / 2, self.box.left + _CAPTION_PADDING_RATIOS[0] * block.size
        lefts = [middle - width / 2 if self.kind in BALLOON_KINDS else indented for width in block.widths]
        feet = [top + (number * LINE_HEIGHT_RATIO + 0.8) * block.size for number in range(len(block.lines))]
        return list(zip(block.lines, lefts, feet, block.widths, strict=True))


def _superellipse(
    middle: Point, wide: float, high: float, step: float, exponent: float = _OUTLINE_EXPONENT
) -> np.ndarray:
    """Return a superellipse with these half axes: points x 2, about `step` pixels apart."""
    angles = np.linspace(0, 2 * math.pi, 721)
    across, down = np.cos(angles), np.sin(angles)
    x = wide * np.sign(across) * np.abs(across) ** (2 / exponent)
    y = high * np.sign(down) * np.abs(down) ** (2 / exponent)
    way = np.concatenate([[0], np.hypot(np.diff(x), np.diff(y)).cumsum()])
    stops = np.linspace(0, way[-1], math.ceil(way[-1] / step), endpoint=False)
    return np.stack([middle[0] + np.interp(stops, way, x), middle[1] + np.interp(stops, way, y)], axis=1)


def _indent_edge(
    around: np.ndarray, middle: Point, size: int, pitch: float, depth: float, pointed: bool
) -> np.ndarray:
    """Indent an outline between points: straight to each point, or in arcs; its bounding box stays."""
    way = np.hypot(*(around - np.roll(around, 1, axis=0)).T).cumsum()
    count = max(8, round(float(way[-1]) / (pitch * size)))
    phase = way / way[-1] * count
    part = phase % 1
    if pointed:
        # Points of uneven length look drawn by hand.
        uneven = 0.55 + 0.45 * ((np.floor(phase + 0.5).astype(int) % count * 7) % 5) / 4
        out = np.abs(2 * part - 1) * uneven
    else:
        out = np.sin(math.pi * part)
    return middle + (around - middle) * (1 - depth + depth * out)[:, np.newaxis]


def bubble_size(kind: BubbleKind, block: TextBlock) -> tuple[float, float]:
    """Return width and height of the box around a text, in whole pixels."""
    across, down = (
        pad * block.size
        for pad in (_BALLOON_PADDING_RATIOS if kind in BALLOON_KINDS else _CAPTION_PADDING_RATIOS)
    )
    wide, high = block.width / 2 + across, block.height / 2 + down
    if kind in BALLOON_KINDS:
        scale = _outline_scale(block, wide, high)
        if kind in _EDGE_SHAPES:
            scale /= 1 - _EDGE_SHAPES[kind][1]
        wide, high = wide * scale, high * scale
    return math.ceil(2 * wide), math.ceil(2 * high)


def _outline_scale(block: TextBlock, wide: float, high: float) -> float:
    """Return the factor on the half axes with which the outline contains the corners of all lines."""
    scale = 1.0
    for number, width in enumerate(block.widths):
        top = number * LINE_HEIGHT_RATIO * block.size - block.height / 2
        for y in (top + 0.1 * block.size, top + 0.95 * block.size):
            x = width / 2 + 0.25 * block.size
            scale = max(
                scale,
                ((x / wide) ** _OUTLINE_EXPONENT + (abs(y) / high) ** _OUTLINE_EXPONENT)
                ** (1 / _OUTLINE_EXPONENT),
            )
    return scale


def add_face_margin(face: Box) -> Box:
    """Return a face with the margin that must not be covered."""
    across, down = FACE_MARGIN_RATIO * face.width, FACE_MARGIN_RATIO * face.height
    return face.padded(across, down, down)


def max_tail_length(size: int, face: Box) -> float:
    """Return the maximum length in pixels of a tail to a face, for text of a font size."""
    return max(_MAX_TAIL_LENGTH_RATIOS[0] * size, _MAX_TAIL_LENGTH_RATIOS[1] * face.height)


def add_tail(bubble: Bubble, face: Box, mouth: Point, kept: Sequence[Box]) -> Bubble:
    """Add a tail towards the mouth, up to the face, to a balloon if its way is clear.

    Args:
        bubble: returned unchanged if it is no balloon, or if no tail is possible.
        face: of the speaker.
        mouth: of the speaker.
        kept: boxes that no tail may cross: faces with their margins, and other balloons.
    """
    if bubble.kind not in BALLOON_KINDS:
        return bubble
    tips = _tips(bubble, mouth, add_face_margin(face), kept)
    longest = max_tail_length(bubble.block.size, face) + bubble.box.width / 2
    if tips and math.dist(tips[-1], bubble.box.center) > longest:
        return bubble
    # A tail that ends before half its way points to no one.
    tails = (replace(bubble, kind="balloon", tip=tip) for tip in reversed(tips[len(tips) // 2 :]))
    return next((replace(bubble, tip=tail.tip) for tail in tails if not _crosses(tail, kept)), bubble)


def _tips(bubble: Bubble, mouth: Point, face: Box, kept: Sequence[Box]) -> list[Point]:
    """Return possible tips from the balloon's edge to the face; empty if something is in the way."""
    start, size = bubble.box.center, bubble.block.size
    tips: list[Point] = []
    for part in np.linspace(0, 1, max(2, math.ceil(math.dist(start, mouth) / 2)))[:-1]:
        tip = start[0] + float(part) * (mouth[0] - start[0]), start[1] + float(part) * (mouth[1] - start[1])
        if _is_in(tip, bubble.box, _MIN_TAIL_LENGTH_RATIO * size):
            continue
        if _is_in(tip, face, _TAIL_FACE_DISTANCE_RATIO * size):
            return tips
        if any(_is_in(tip, box, _TAIL_FACE_DISTANCE_RATIO * size) for box in kept):
            return []
        tips.append(tip)
    return tips


def _crosses(bubble: Bubble, kept: Sequence[Box]) -> bool:
    """Whether an edge of the tail crosses one of the boxes."""
    root, tip, other = bubble.outline[:3]
    steps = np.linspace(0, 1, 40)[:, np.newaxis]
    points = np.concatenate([root + steps * (tip - root), other + steps * (tip - other)])
    return any(_is_in((x, y), box, 0) for x, y in points for box in kept)


def _is_in(point: Sequence[float] | np.ndarray, box: Box, room: float) -> bool:
    left, top, right, bottom = box.padded(room, room, room)
    return left <= point[0] <= right and top <= point[1] <= bottom


def break_text(letters: Letters, text: str, size: int, widest: float) -> list[TextBlock]:
    """Break the text into different numbers of lines, no wider than `widest`; empty if impossible.

    The lines of each block are as even as their number allows.
    """
    pieces, length = list[tuple[str, float]](), 0.0
    for piece in _pieces(letters, text, size, widest):
        pieces.append(piece)
        length += piece[1]
        if length > _LINE_COUNTS[-1] * widest:
            return []
    blocks: dict[int, TextBlock] = {}
    for count in _LINE_COUNTS:
        lines = _balance_lines(pieces, count, widest)
        if lines is not None and len(lines) not in blocks:
            texts = tuple("".join(part for part, _ in line).strip() for line in lines)
            blocks[len(lines)] = TextBlock(texts, tuple(letters.width(each, size) for each in texts), size)
    return [block for block in blocks.values() if block.width <= widest]


def _pieces(letters: Letters, text: str, size: int, widest: float) -> Iterator[tuple[str, float]]:
    """Yield unbreakable pieces with the space before them, and their widths; too wide words are split."""
    for match in _PIECE_PATTERN.finditer(text):
        space, word = match.groups()
        while word:
            count = _count_fitting(letters, word, size, widest)
            if count < len(word) and remove_stress(word) != word:
                word = remove_stress(word)
                continue
            yield space + word[:count], letters.width(space + word[:count], size)
            space, word = "", word[count:]


def _count_fitting(letters: Letters, word: str, size: int, widest: float) -> int:
    """Return the number of a word's letters that fit, at least 1; measures few more letters than these."""

    def width(count: int) -> float:
        return letters.width(word[:count], size)

    most = min(len(word), _MAX_MEASURED_LETTERS)
    while most < len(word) and width(most) <= widest:
        most = min(len(word), 2 * most)
    return most if width(most) <= widest else max(1, bisect_right(range(most), widest, key=width) - 1)


def _balance_lines(
    pieces: list[tuple[str, float]], count: int, widest: float
) -> list[list[tuple[str, float]]] | None:
    """Return the pieces in at most `count` lines, as narrow as possible; bisection over the width."""
    low, high = max(width for _, width in pieces), widest
    best = _fill_lines(pieces, high)
    if len(best) > count:
        return None
    for _ in range(12):
        middle = (low + high) / 2
        tried = _fill_lines(pieces, middle)
        if len(tried) <= count:
            best, high = tried, middle
        else:
            low = middle
    return best


def _fill_lines(pieces: list[tuple[str, float]], width: float) -> list[list[tuple[str, float]]]:
    lines: list[list[tuple[str, float]]] = []
    used = 0.0
    for piece in pieces:
        if not lines or used + piece[1] > width:
            lines.append([])
            used = 0.0
        lines[-1].append(piece)
        used += piece[1]
    return lines
