"""Crowds: pictures of many small faces are drawn with finer marks as a whole, as with a finer pen."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from vidstyle.regions.boxes import Box
from vidstyle.style import Style

CROWD_FACE_RATIO = 0.075
"""Height of faces, relative to the picture's shorter side, below which marks are finer."""
MAX_DETAIL, DETAIL_STEP = 2.5, 0.5
"""The highest level of detail, and the distance of levels: few, so that shots of one crowd look alike."""
COUNT_RANGE = 3, 6
"""Number of faces up to which patches are enough, and from which all marks are as fine as the faces need."""
FULL_FOCUS = 0.5
"""`focus` of a style from which marks become this fine."""


def crowd_detail(faces: Collection[Box[float]], side: float) -> float:
    """Return the level of detail that a picture needs for its faces, as of `--detail`, 1 or more.

    A large face counts for more, by its area: marks fit the people in front, and patches the others.

    Args:
        faces: their boxes.
        side: the shorter side of the picture.
    """
    few, many = COUNT_RANGE
    share = min(1.0, (len(faces) - few) / (many - few))
    if share <= 0:
        return 1.0
    height = sum(each.height**3 for each in faces) / sum(each.height**2 for each in faces)
    needed = min(MAX_DETAIL, max(1.0, CROWD_FACE_RATIO * side / height))
    return 1 + DETAIL_STEP * round(share * (needed - 1) / DETAIL_STEP)


def style_for_crowd(style: Style, detail: float) -> Style:
    """Return a style with finer marks, by its focus; the same if the user has chosen a level of detail."""
    if style.has_detail or style.height is None or detail == 1:
        return style
    factor = detail ** min(1.0, style.focus / FULL_FOCUS)
    behind = style.behind
    if behind is not None and behind.height is not None:
        behind = replace(behind, height=behind.height * factor)
    return replace(style, height=style.height * factor, behind=behind)
