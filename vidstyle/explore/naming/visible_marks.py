"""What one sees of a look: marks without which its picture would be another one, flat areas, and softness."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.errors import StyleError
from vidstyle.explore.measure import gradient_of, luma_of_codes
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.style import Step, Style

MARK_WORDS = {
    "glyphs": "letters",
    "mosaic": "tiles",
    "pixelate": "large pixels",
    "halftone": "dots",
    "line_screen": "engraved lines",
    "pattern": "hatching",
    "dither": "fine points",
    "strokes": "brush strokes",
    "lic": "smudged",
    "relief": "relief",
    "flow_xdog": "ink lines",
    "flow_dog": "ink lines",
    "sobel": "outlines",
    "shift": "colours apart",
    "noise": "grain",
}
"""What a block may be seen as; whether it is seen is measured."""
MIN_SHARE, MIN_STRENGTH = 0.45, 0.012
"""A mark is seen if this share of fine detail changes without its block, and if there is this much detail."""
FINE_SIGMA_PX = 1.5
MAX_FLAT_GRADIENT, MIN_FLAT_SHARE = 0.004, 0.45
"""Gradient of luma below which a pixel is flat, and the share of flat pixels that one sees as flat areas."""
MAX_SOFT_STRENGTH = 0.008
"""Mean strength of fine detail up to which a picture looks soft."""


def visible_marks(style: Style, source: np.ndarray) -> tuple[str, ...]:
    """Return in words what one sees of a style, the most visible first.

    Each block that may leave marks is muted once: without a mark that is seen, the picture has other detail.

    Args:
        source: the picture to restyle, H x W x 3 uint8.
    """
    picture = restyle_picture(source, style)
    detail = _detail(picture)
    strength = float(np.abs(detail).mean())
    seen = dict(_shares(style, source, detail)) if strength >= MIN_STRENGTH else {}
    words = [word for word in sorted(seen, key=lambda word: -seen[word]) if seen[word] >= MIN_SHARE]
    flat = float((gradient_of(luma_of_codes(picture)) < MAX_FLAT_GRADIENT).mean())
    if flat >= MIN_FLAT_SHARE:
        words.append("flat areas")
    elif strength <= MAX_SOFT_STRENGTH:
        words.append("soft")
    return tuple(words)


def _shares(style: Style, source: np.ndarray, detail: np.ndarray) -> Iterator[tuple[str, float]]:
    """Yield the marks that a style may leave, and the share of detail that changes without each of them."""
    for block in dict.fromkeys(
        step.block for step in style.steps if step.block in MARK_WORDS and not step.mute
    ):
        try:
            without = restyle_picture(source, _without(style, block))
        except StyleError:  # other steps need its saved picture
            continue
        change = float(np.abs(detail - _detail(without)).mean()) / float(np.abs(detail).mean())
        yield MARK_WORDS[block], change


def _without(style: Style, block: str) -> Style:
    def bare(layer: tuple[Step, ...]) -> tuple[Step, ...]:
        return tuple(replace(step, mute=True) if step.block == block else step for step in layer)

    return replace(
        style, base=bare(style.base), background=bare(style.background), lines=bare(style.lines), steady=0.0
    )


def _detail(picture: np.ndarray) -> np.ndarray:
    luma = luma_of_codes(picture)
    return luma - cv2.GaussianBlur(luma, (0, 0), FINE_SIGMA_PX)
