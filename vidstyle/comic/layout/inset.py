"""Insets: a small close-up over the calmest corner of the wide panel before it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.cost import best_shape
from vidstyle.comic.layout.crop import add_face_room, content_box, main_face, map_to_page
from vidstyle.regions.boxes import Box, Rectangle

# Which key frames become insets.
_MIN_DISTANCE_PANELS = 5
"""Minimum distance between two insets, and from the first panel to the first inset."""
_MIN_CLOSE_FACE_RATIO, _MAX_FAR_FACE_RATIO = 0.2, 0.17
"""Minimum height of a close-up's face, and maximum height in the panel below, relative to the picture's."""
_MAX_CLOSE_WIDTH_RATIO = 0.5
"""Maximum width of the content of a close-up without a face, relative to the picture's."""

# The place of insets.
_INSET_WIDTH_RATIO, _MAX_INSET_HEIGHT_RATIO = 0.36, 0.56
"""Width of an inset and its maximum height, relative to the panel below it."""
_ASPECT_LOG_RANGE = math.log(0.8), math.log(1.5)
"""Range of the logarithm of its aspect."""
_MIN_INSET_SIDE_RATIO = 0.12
"""Minimum shorter side, relative to the page's width."""
_MAX_COVERED_SHARE = 0.3
"""Maximum share of it that covers the content of the panel below."""
INSET_PANEL_AREA_FACTOR = 1.3
"""Factor on the wanted area of the panel below an inset."""


def find_insets(key_frames: Sequence[KeyFrame], have_words: Sequence[bool]) -> tuple[int, ...]:
    """Return the key frames that can be shown in a corner of the panel before them: close-ups without text.

    Args:
        key_frames: in the order of time.
        have_words: for each, whether its panel contains text.
    """
    found = list[int]()
    # The only person is shown large.
    has_people = sum(bool(each.faces) for each in key_frames) > 1
    for number in range(1, len(key_frames)):
        distance = number - found[-1] if found else number + 1
        is_inset = (
            not have_words[number]
            and _is_close(key_frames[number])
            and _is_wide(key_frames[number - 1])
            and (has_people or not key_frames[number].faces)
        )
        if is_inset and distance >= _MIN_DISTANCE_PANELS - (not found):
            found.append(number)
    return tuple(found)


def _is_close(key_frame: KeyFrame) -> bool:
    face, (height, width) = main_face(key_frame), key_frame.shape
    if face is not None and face.height >= _MIN_CLOSE_FACE_RATIO * height:
        return True
    return key_frame.framing == "near" and content_box(key_frame).width <= _MAX_CLOSE_WIDTH_RATIO * width


def _is_wide(key_frame: KeyFrame) -> bool:
    face = main_face(key_frame)
    return key_frame.framing != "near" and (
        face is None or face.height <= _MAX_FAR_FACE_RATIO * key_frame.shape[0]
    )


def place_inset(
    key_frame: KeyFrame,
    below: KeyFrame,
    window: Box,
    panel: Rectangle,
    clear: Rectangle,
    page_width: int,
    backwards: bool,
) -> Rectangle | None:
    """Return the rectangle of an inset on the panel below it; None if no corner is calm enough.

    Args:
        key_frame: the close-up.
        below: the key frame of the panel.
        window: the part of `below` that is shown.
        panel: its rectangle, in pixels of the page.
        clear: the part of the panel that an inset may cover.
        page_width: in pixels.
        backwards: right-to-left reading order.
    """
    aspect = math.exp(min(max(best_shape(key_frame), _ASPECT_LOG_RANGE[0]), _ASPECT_LOG_RANGE[1]))
    width = round(min(_INSET_WIDTH_RATIO * clear.width, _MAX_INSET_HEIGHT_RATIO * clear.height * aspect))
    height = round(width / aspect)
    if min(width, height) < _MIN_INSET_SIDE_RATIO * page_width:
        return None
    faces = [map_to_page(add_face_room(below, face), window, panel) for face in below.faces]
    counts = map_to_page(content_box(below), window, panel)
    best: tuple[float, int] | None = None
    corners = list(_corners(clear, width, height, round(0.1 * min(width, height)), backwards))
    for number, corner in enumerate(corners):
        covered = corner.intersection(counts).area / corner.area
        if covered <= _MAX_COVERED_SHARE and not any(corner.intersection(face).area > 0 for face in faces):
            best = min(best, (covered, number)) if best else (covered, number)
    return corners[best[1]] if best else None


def _corners(panel: Rectangle, width: int, height: int, room: int, backwards: bool) -> Iterator[Rectangle]:
    """Yield places in the corners of a panel, starting with the corner that is read last."""
    left, right = panel.left + room, panel.right - room - width
    for top in (panel.bottom - room - height, panel.top + room):
        for start in (left, right) if backwards else (right, left):
            yield Rectangle(start, top, start + width, top + height)
