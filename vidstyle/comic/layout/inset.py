"""Insets: a small close-up over the calmest corner of the wide panel before it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from vidstyle.comic.layout.cost import best_shape
from vidstyle.comic.layout.crop import main_face, on_page, what_counts, with_room
from vidstyle.comic.moment import Box, Moment, Rectangle

_APART = 5
"""Moments from one inset to the next at least, and from the first moment to the first inset."""
_CLOSE, _FAR = 0.2, 0.17
"""The least height of the face of a close-up, and the greatest in the panel below it; of the picture's."""
_NEAR = 0.5
"""Greatest share of its picture's width that a moment shows from near."""
_WIDE, _HIGH = 0.36, 0.56
"""Width of an inset and its greatest height, relative to the panel below it."""
_SHAPES = math.log(0.8), math.log(1.5)
"""Range of the logarithm of its aspect."""
_SMALLEST = 0.12
"""Its shorter side relative to the page's width at least."""
_COVERED = 0.3
"""The greatest share of it that may lie over what counts in the panel below it."""
GROWTH = 1.3
"""Factor on the wanted area of the panel below an inset."""


def suit_insets(moments: Sequence[Moment], have_words: Sequence[bool]) -> tuple[int, ...]:
    """The moments that can be shown in a corner of the panel before them: close-ups without words.

    Args:
        moments: in the order of time.
        have_words: for each, whether its panel holds text.
    """
    found = list[int]()
    for number in range(1, len(moments)):
        apart = number - found[-1] if found else number + 1
        is_one = not have_words[number] and _is_close(moments[number]) and _is_wide(moments[number - 1])
        if is_one and apart >= _APART - (not found):
            found.append(number)
    return tuple(found)


def _is_close(moment: Moment) -> bool:
    face, (height, width) = main_face(moment), moment.shape
    if face is not None and face.height >= _CLOSE * height:
        return True
    return moment.framing == "near" and what_counts(moment).width <= _NEAR * width


def _is_wide(moment: Moment) -> bool:
    face = main_face(moment)
    return moment.framing != "near" and (face is None or face.height <= _FAR * moment.shape[0])


def inset_place(
    moment: Moment,
    below: Moment,
    window: Box,
    panel: Rectangle,
    clear: Rectangle,
    page_width: int,
    backwards: bool,
) -> Rectangle | None:
    """Where the inset of a moment stands on the panel below it; None if there is no calm corner for it.

    Args:
        moment: the close-up.
        below: the moment of the panel.
        window: what of `below` is shown.
        panel: where it is shown, in pixels of the page.
        clear: the part of the panel that an inset may stand in.
        page_width: in pixels.
        backwards: right-to-left reading order.
    """
    aspect = math.exp(min(max(best_shape(moment), _SHAPES[0]), _SHAPES[1]))
    width = round(min(_WIDE * clear.width, _HIGH * clear.height * aspect))
    height = round(width / aspect)
    if min(width, height) < _SMALLEST * page_width:
        return None
    faces = [on_page(with_room(below, face), window, panel) for face in below.faces]
    counts = on_page(what_counts(below), window, panel)
    best: tuple[float, int] | None = None
    corners = list(_corners(clear, width, height, round(0.1 * min(width, height)), backwards))
    for number, corner in enumerate(corners):
        covered = corner.intersection(counts).area / corner.area
        if covered <= _COVERED and not any(corner.intersection(face).area > 0 for face in faces):
            best = min(best, (covered, number)) if best else (covered, number)
    return corners[best[1]] if best else None


def _corners(panel: Rectangle, width: int, height: int, room: int, backwards: bool) -> Iterator[Rectangle]:
    """Places in the corners of a panel, those first that are read last."""
    left, right = panel.left + room, panel.right - room - width
    for top in (panel.bottom - room - height, panel.top + room):
        for start in (left, right) if backwards else (right, left):
            yield Rectangle(start, top, start + width, top + height)
