"""Words written into panels, and panels changed where the words find no room in them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.balloons import Room, Wording, place
from vidstyle.comic.bubble import Bubble, size_of
from vidstyle.comic.crop import crop, main_face
from vidstyle.comic.font import Letters
from vidstyle.comic.layout import Layout, Panel
from vidstyle.comic.moment import Box, Moment
from vidstyle.comic.paper import Rectangle
from vidstyle.comic.subtitles import Line
from vidstyle.comic.wrap import Block, shapes

GROWTH = 1.6
"""So many times as large a panel is wanted in which there is no room."""
ROUNDS = 3
"""Layouts that are tried."""

_SMALLER = 0.85
"""Letters may be that much smaller where there is little room."""
_SHIFTS = ((0, -0.5), (0, -1), (-0.5, 0), (0.5, 0), (-1, 0), (1, 0), (0, 0.5))
"""Where else a panel may look, in parts of the way to the edge of the picture or of what must be seen."""
_BAND, _WIDEST_BAND = 0.3, 0.55
"""The part of a panel that a caption above its picture takes at most, and in the last round."""


@dataclass(frozen=True)
class Lettered:
    """A panel with its words.

    Attributes:
        picture: where its picture is, within its border; it is lower where words stand above it.
        crop: the part of the moment's picture that fills that.
        bubbles: in the order of reading.
    """

    panel: Panel
    picture: Rectangle
    crop: Box
    bubbles: tuple[Bubble, ...] = ()


@dataclass(frozen=True)
class Hand:
    """How it is written.

    Attributes:
        size: of the letters, in pixels.
        border: of panels, in pixels.
    """

    letters: Letters
    size: int
    border: int
    right_to_left: bool = False


def letter(
    lay_out: Callable[[Sequence[float]], Layout],
    moments: Sequence[Moment],
    words: Sequence[Sequence[Line]],
    hand: Hand,
) -> tuple[Layout, list[Lettered], int]:
    """Lay out panels and write into them.

    Where there is no room the panel looks elsewhere, the letters are smaller, or the words stand above the
    picture; where that would take too much of it, the panel is to be larger and all is laid out anew. What
    finds no room in the end is left out, the last line first.

    Args:
        lay_out: makes a layout in which each panel is to be so many times as large as else.
        words: of each moment.

    Returns:
        The layout, its panels, and how many lines were left out.
    """
    growth = [1.0] * len(moments)
    for _ in range(ROUNDS - 1):
        layout = lay_out(growth)
        written = [
            _written(panel, moments[panel.moment], words[panel.moment], hand) for panel in layout.panels
        ]
        if None not in written:
            return layout, [each for each in written if each], 0
        growth = [size * (1.0 if found else GROWTH) for size, found in zip(growth, written, strict=True)]
    layout = lay_out(growth)
    ends = [
        _written_at_last(panel, moments[panel.moment], words[panel.moment], hand) for panel in layout.panels
    ]
    lines = sum(len(words[panel.moment]) for panel in layout.panels)
    return layout, [lettered for lettered, _ in ends], lines - sum(count for _, count in ends)


def _written(
    panel: Panel, moment: Moment, lines: Sequence[Line], hand: Hand, band: float = _BAND
) -> Lettered | None:
    inside = _inside(panel.rectangle, hand.border)
    # The border takes a little of the panel, and of its shape.
    best = crop(moment, inside.aspect)
    if not lines:
        return Lettered(panel, inside, best)
    for size in (hand.size, round(hand.size * _SMALLER)):
        for window in (best, *_elsewhere(best, moment)):
            bubbles = _balloons(panel, inside, window, moment, lines, replace(hand, size=size))
            if bubbles is not None:
                return Lettered(panel, inside, window, tuple(bubbles))
    return _with_band(panel, moment, lines, hand, band)


def _written_at_last(panel: Panel, moment: Moment, lines: Sequence[Line], hand: Hand) -> tuple[Lettered, int]:
    """The panel with as many of its first lines as find room, and how many these are."""
    tried = (
        (_written(panel, moment, lines[:count], hand, _WIDEST_BAND), count)
        for count in range(len(lines), -1, -1)
    )
    return next((written, count) for written, count in tried if written is not None)


def _inside(rectangle: Rectangle, border: int) -> Rectangle:
    left, top, right, bottom = rectangle
    return Rectangle(left + border, top + border, right - border, bottom - border)


def on_page(box: Box, window: Box, picture: Rectangle) -> Box:
    """A box of a moment's picture as it is on the page, as far as it can be seen."""
    seen, factor = box.intersection(window), picture.width / max(window.width, 1e-6)
    moved = Box(
        seen.left - window.left, seen.top - window.top, seen.right - window.left, seen.bottom - window.top
    )
    scaled = moved.scaled(factor)
    left, top = picture.left, picture.top
    return Box(scaled.left + left, scaled.top + top, scaled.right + left, scaled.bottom + top)


def _balloons(
    panel: Panel, picture: Rectangle, window: Box, moment: Moment, lines: Sequence[Line], hand: Hand
) -> list[Bubble] | None:
    seen = [on_page(face, window, picture) for face in moment.faces]
    faces = tuple(face for face in seen if face.area > 0)
    # A panel that bleeds goes on where the page ends.
    air = round(0.35 * hand.size)
    area = Box(
        max(0, picture.left) + air, max(0, picture.top) + air, picture.right - air, picture.bottom - air
    )
    room = Room(area, faces, on_page(moment.salience, window, picture))
    wordings = list(_wordings(lines, faces, area, hand))
    return None if any(not each.blocks for each in wordings) else place(wordings, room, hand.right_to_left)


def _wordings(lines: Sequence[Line], faces: Sequence[Box], area: Box, hand: Hand) -> Iterator[Wording]:
    """Each line, with the face of who says it: several speakers are taken to stand from left to right."""
    speakers = list(dict.fromkeys(line.speaker for line in lines if not line.narrated))
    across = sorted(faces, key=lambda face: face.left, reverse=hand.right_to_left)
    if len(speakers) < 2 and faces:
        across = [max(faces, key=lambda face: face.area)]
    of = dict(zip(speakers, across, strict=False))
    for line in lines:
        text = hand.letters.writable(line.text)
        widest = area.width - 2 * hand.size
        blocks = shapes(hand.letters, text, hand.size, widest) if widest > 0 else []
        yield Wording(
            "caption" if line.narrated else "balloon", blocks, None if line.narrated else of.get(line.speaker)
        )


def _elsewhere(window: Box, moment: Moment) -> Iterator[Box]:
    """Other windows of the same size in which the main face, or without one what is salient, is as whole."""
    height, width = moment.shape
    kept = (main_face(moment) or moment.salience).intersection(window)
    left, right = max(0.0, kept.right - window.width), min(width - window.width, kept.left)
    top, bottom = max(0.0, kept.bottom - window.height), min(height - window.height, kept.top)
    for x, y in _SHIFTS:
        across = x * (right - window.left if x > 0 else window.left - left)
        down = y * (bottom - window.top if y > 0 else window.top - top)
        if abs(across) + abs(down) >= 1 and left <= right and top <= bottom:
            yield Box(window.left + across, window.top + down, window.right + across, window.bottom + down)


def _with_band(
    panel: Panel, moment: Moment, lines: Sequence[Line], hand: Hand, most: float
) -> Lettered | None:
    """The words above the picture, which is lower by them."""
    inside = _inside(panel.rectangle, hand.border)
    shown = Rectangle(max(0, inside.left), max(0, inside.top), inside.right, inside.bottom)
    blocks = [_flattest(hand, line.text, shown.width - round(1.2 * hand.size)) for line in lines]
    bubbles, top = list[Bubble](), shown.top
    for block in blocks:
        if block is None:
            return None
        _, height = size_of("band", block)
        bubbles.append(Bubble("band", Box(shown.left, top, shown.right, top + height), block))
        top += round(height - 0.3 * hand.size)
    top += round(0.3 * hand.size)
    if top + hand.border - shown.top > most * shown.height:
        return None
    picture = inside._replace(top=top + hand.border)
    return Lettered(panel, picture, crop(moment, picture.aspect), tuple(bubbles))


def _flattest(hand: Hand, text: str, widest: int) -> Block | None:
    tried = shapes(hand.letters, hand.letters.writable(text), hand.size, widest) if widest > 0 else []
    return min(tried, key=lambda block: len(block.lines), default=None)
