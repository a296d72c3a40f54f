"""The animated picture for the top of the README: one style after another is drawn over a filmed cat."""

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
"""Each has a second of the film."""
RATE = 12
"""Frames a second."""
FRAMES = RATE * len(STYLES)
WIPE = RATE // 2
"""In so many frames a style is drawn over the one before it, from left to right."""
SIZE = 480, 270
MEANT_FOR = 400
"""The height for which lengths are meant here: else dots and strokes would hardly be seen, so small."""
ZOOM, SWING = 1.2, 0.1
"""How much larger than the photograph the camera sees it, and by what share that changes."""
QUALITY = 32


def animation() -> bytes:
    """The picture as a WebP file: a GIF's 256 colours would take four times the room for less."""
    pictures = [Image.fromarray(picture) for picture in _pictures()]
    content = io.BytesIO()
    pictures[0].save(
        content,
        "WEBP",
        save_all=True,
        append_images=pictures[1:],
        duration=1000 // RATE,
        loop=0,
        quality=QUALITY,
        method=6,
    )
    return content.getvalue()


def _pictures() -> Iterator[np.ndarray]:
    films = [_restyled(name, RATE * second) for second, name in enumerate(STYLES)]
    for number in range(FRAMES):
        second, within = divmod(number, RATE)
        picture, edge = films[second][within].copy(), SIZE[0] * (within + 1) // WIPE
        if edge < SIZE[0]:
            picture[:, edge:] = films[second - 1][RATE + within][:, edge:]
            picture[:, edge - 2 : edge] = 255
        name = STYLES[second]
        yield _titled(picture, "source" if name == PLAIN else name)


def _restyled(name: str, first: int) -> list[np.ndarray]:
    """A second of the film in a style, and as long as the next one takes to cover it."""
    style = load_style(name)
    with Renderer(style if style.is_plain else replace(style, height=MEANT_FOR), device="cpu") as renderer:
        return [renderer(_filmed(number), number / RATE) for number in range(first, first + RATE + WIPE)]


def _filmed(number: int) -> np.ndarray:
    """What the camera sees of the photograph: it glides round and nearer, and ends where it began."""
    photograph, turn = skimage.data.chelsea(), tau * number / FRAMES
    height, width = photograph.shape[:2]
    zoom = ZOOM * (1 - SWING * cos(turn))
    middle = width / 2 + 20 * sin(turn), height / 2 - 12 + 14 * sin(2 * turn)
    corner = [SIZE[axis] / 2 - zoom * middle[axis] for axis in (0, 1)]
    seen = np.array([[zoom, 0, corner[0]], [0, zoom, corner[1]]])
    return cv2.warpAffine(photograph, seen, SIZE, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)


def _titled(picture: np.ndarray, name: str) -> np.ndarray:
    """The picture with the name in its upper right corner."""
    font, size = cv2.FONT_HERSHEY_DUPLEX, 0.65
    left = picture.shape[1] - cv2.getTextSize(name, font, size, 1)[0][0] - 26
    picture = cv2.rectangle(picture.copy(), (left, 10), (picture.shape[1] - 10, 38), (20, 20, 24), -1)
    return cv2.putText(picture, name, (left + 8, 30), font, size, (255, 255, 255), 1, cv2.LINE_AA)
