"""Render the animation at the top of the README: a filmed cat, wiped from one style to the next."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from math import cos, sin, tau

import cv2
import numpy as np
import skimage.data
from PIL import Image

from vidstyle.renderer import Renderer
from vidstyle.style import PLAIN, load_style

STYLES = (PLAIN, "ink", "oil", "comic", "engraving", "cartoon", "sketch", "poster")
"""Each style is shown for one second."""
FRAME_RATE = 12
"""Frames per second."""
TOTAL_FRAMES = FRAME_RATE * len(STYLES)
WIPE_FRAMES = FRAME_RATE // 2
"""Length of the wipe from one style to the next, from left to right."""
PICTURE_SIZE = 480, 270
STYLE_HEIGHT_PX = 400
"""Style height (`height`): at the default, dots and strokes would be too small to see."""
MEAN_ZOOM_FACTOR, ZOOM_CHANGE_RATIO = 1.2, 0.1
"""Mean scale of the photograph, and the relative change of the scale while the camera moves."""
WEBP_QUALITY = 32


def render_animation() -> bytes:
    """Return the animation as a WebP file; a GIF would be four times as large, with only 256 colours."""
    pictures = [Image.fromarray(picture) for picture in _render_frames()]
    content = io.BytesIO()
    pictures[0].save(
        content,
        "WEBP",
        save_all=True,
        append_images=pictures[1:],
        duration=1000 // FRAME_RATE,
        loop=0,
        quality=WEBP_QUALITY,
        method=6,
    )
    return content.getvalue()


def _render_frames() -> Iterator[np.ndarray]:
    films = [_restyle_second(name, FRAME_RATE * second) for second, name in enumerate(STYLES)]
    for number in range(TOTAL_FRAMES):
        second, within = divmod(number, FRAME_RATE)
        picture, edge = films[second][within].copy(), PICTURE_SIZE[0] * (within + 1) // WIPE_FRAMES
        if edge < PICTURE_SIZE[0]:
            picture[:, edge:] = films[second - 1][FRAME_RATE + within][:, edge:]
            picture[:, edge - 2 : edge] = 255
        name = STYLES[second]
        yield _add_title(picture, "source" if name == PLAIN else name)


def _restyle_second(name: str, first: int) -> list[np.ndarray]:
    """Return one second of the film in a style, and the frames of the wipe to the next style."""
    style = load_style(name)
    with Renderer(
        style if style.is_plain else replace(style, height=STYLE_HEIGHT_PX), device="cpu"
    ) as renderer:
        return [
            renderer(_film(number), number / FRAME_RATE)
            for number in range(first, first + FRAME_RATE + WIPE_FRAMES)
        ]


def _film(number: int) -> np.ndarray:
    """Return a frame of the film: the camera pans and zooms over the photograph in a closed loop."""
    photograph, turn = skimage.data.chelsea(), tau * number / TOTAL_FRAMES
    height, width = photograph.shape[:2]
    zoom = MEAN_ZOOM_FACTOR * (1 - ZOOM_CHANGE_RATIO * cos(turn))
    middle = width / 2 + 20 * sin(turn), height / 2 - 12 + 14 * sin(2 * turn)
    corner = [PICTURE_SIZE[axis] / 2 - zoom * middle[axis] for axis in (0, 1)]
    seen = np.array([[zoom, 0, corner[0]], [0, zoom, corner[1]]])
    return cv2.warpAffine(
        photograph, seen, PICTURE_SIZE, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT
    )


def _add_title(picture: np.ndarray, name: str) -> np.ndarray:
    """Return the picture with a name in its upper right corner."""
    font, size = cv2.FONT_HERSHEY_DUPLEX, 0.65
    left = picture.shape[1] - cv2.getTextSize(name, font, size, 1)[0][0] - 26
    picture = cv2.rectangle(picture.copy(), (left, 10), (picture.shape[1] - 10, 38), (20, 20, 24), -1)
    return cv2.putText(picture, name, (left + 8, 30), font, size, (255, 255, 255), 1, cv2.LINE_AA)
