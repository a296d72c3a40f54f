"""A page as pixels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.comic.layout.paper import Rectangle
from vidstyle.comic.lettering.bubble import Bubble
from vidstyle.comic.output.sheet import Label, RenderedPanel, Sheet

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

PAPER = 255
INK = 0

_LARGER = 4
"""Outlines are drawn larger and averaged, so that they are smooth."""


def page_image(sheet: Sheet) -> Image:
    """The page as a picture of Pillow's, RGB, one pixel of it for one of the sheet."""
    from PIL import Image, ImageDraw

    canvas = np.full((sheet.height, sheet.width, 3), PAPER, np.uint8)
    for panel in sheet.panels:
        _draw_panel(canvas, panel)
    image = Image.fromarray(canvas)
    draw = ImageDraw.Draw(image)
    for panel in sheet.panels:
        for bubble in panel.bubbles:
            _write(draw, bubble, sheet)
    for label in sheet.labels:
        _write_label(draw, label, sheet)
    return image


def _draw_panel(canvas: np.ndarray, panel: RenderedPanel) -> None:
    _fill(canvas, panel.rectangle, INK)
    if panel.band:
        _fill(canvas, panel.band, PAPER)
    _paste(canvas, panel.picture, panel.color)
    for bubble in panel.bubbles:
        if bubble.kind != "band":
            _draw_outline(canvas, bubble)


def _fill(canvas: np.ndarray, rectangle: Rectangle, level: int) -> None:
    left, top, right, bottom = (max(0, side) for side in rectangle)
    canvas[top:bottom, left:right] = level


def _paste(canvas: np.ndarray, at: Rectangle, color: np.ndarray) -> None:
    """A picture that may go on where the page ends."""
    height, width = canvas.shape[:2]
    left, top = max(0, at.left), max(0, at.top)
    right, bottom = min(width, at.right), min(height, at.bottom)
    canvas[top:bottom, left:right] = color[top - at.top : bottom - at.top, left - at.left : right - at.left]


def _draw_outline(canvas: np.ndarray, bubble: Bubble) -> None:
    """The shape in white with a black line around it, over what is there."""
    points = np.array(bubble.outline)
    room = math.ceil(bubble.line_width) + 1
    height, width = canvas.shape[:2]
    left, top = (max(0, math.floor(low) - room) for low in points.min(axis=0))
    right, bottom = (math.ceil(high) + room for high in points.max(axis=0))
    right, bottom = min(width, right), min(height, bottom)
    local = (points - (left, top)) * _LARGER
    body, line = _masks(local, bottom - top, right - left, bubble.line_width * _LARGER)
    part = canvas[top:bottom, left:right]
    cover = np.maximum(body, line)[..., np.newaxis]
    light = (np.minimum(body, 1 - line) * PAPER)[..., np.newaxis]
    part[:] = np.rint(part * (1 - cover) + light)


def _masks(points: np.ndarray, height: int, width: int, line_width: float) -> tuple[np.ndarray, np.ndarray]:
    """How much of each pixel lies within the polygon, and how much on its line, 0..1."""
    from PIL import Image, ImageDraw

    corners = [(float(x), float(y)) for x, y in points]
    masks = []
    for is_line in (False, True):
        mask = Image.new("L", (width * _LARGER, height * _LARGER))
        draw = ImageDraw.Draw(mask)
        if is_line:
            draw.line([*corners, *corners[:2]], fill=255, width=max(1, round(line_width)), joint="curve")
        else:
            draw.polygon(corners, fill=255)
        masks.append(np.asarray(mask.reduce(_LARGER), np.float32) / 255)
    return masks[0], masks[1]


def _write(draw: ImageDraw, bubble: Bubble, sheet: Sheet) -> None:
    font = sheet.letters.font(bubble.block.size)
    for text, left, foot, _ in bubble.lines:
        draw.text((left, foot), text, font=font, fill=(INK,) * 3, anchor="ls")


def _write_label(draw: ImageDraw, label: Label, sheet: Sheet) -> None:
    font = sheet.letters.font(label.size)
    draw.text(
        (label.middle, label.foot),
        label.text,
        font=font,
        fill=(INK,) * 3,
        anchor="ms",
        stroke_width=label.thickness,
    )
