"""The level of detail of whole pictures: finer marks for small faces, and coarser ones in a small picture."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from vidstyle.regions.boxes import Box
from vidstyle.style import Style

FACE_RATIO, FACE_EXPONENT = 0.17, 0.5
"""Height of faces, relative to the picture's shorter side, below which marks are finer; and the power of the
ratio to that height by which they are: the rest of what faces need is left to patches."""
COUNT_DETAIL_RANGE, MAX_DETAIL = (1.25, 0.25), 2.5
"""The highest level of detail: this much, and more for each face, in all at most `MAX_DETAIL`."""
MIN_CROWD_DETAIL, DETAIL_STEP = 1.75, 0.25
"""Level of detail from which faces are a crowd; and the distance of levels: similar shots look alike."""
FULL_FOCUS = 0.5
"""`focus` of a style from which the level of detail is complete."""
MIN_FULL_SIDE_PX = 480
"""Shorter side of pictures below which marks keep their size in pixels: smaller dots would be grain."""


def face_detail(faces: Collection[Box[float]], side: float) -> float:
    """Return the level of detail that a picture needs for its faces, as of `--detail`, 1 or more.

    A large face counts for more, by its area: marks fit the people in front, and patches the others.

    Args:
        faces: their boxes.
        side: the shorter side of the picture.
    """
    if not faces:
        return 1.0
    height = sum(each.height**3 for each in faces) / sum(each.height**2 for each in faces)
    least, more = COUNT_DETAIL_RANGE
    most = min(MAX_DETAIL, least + more * len(faces))
    needed = min(most, max(1.0, (FACE_RATIO * side / height) ** FACE_EXPONENT))
    return 1 + DETAIL_STEP * round((needed - 1) / DETAIL_STEP)


def small_picture_detail(side: float) -> float:
    """Return the level of detail of pictures that are seen with this shorter side, 1 or less."""
    return min(1.0, side / MIN_FULL_SIDE_PX)


def with_detail(style: Style, detail: float) -> Style:
    """Return a style with finer or coarser marks, by its focus.

    It is the same if the user has chosen the detail or the height.
    """
    if style.keeps_detail or style.height is None or detail == 1:
        return style
    factor = detail ** min(1.0, style.focus / FULL_FOCUS)
    behind = style.behind
    if behind is not None and behind.height is not None:
        behind = replace(behind, height=behind.height * factor)
    return replace(style, height=style.height * factor, behind=behind)
