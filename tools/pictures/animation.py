"""The animated picture for the top of the README: our own film, the style changing every second."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
from PIL import Image

from vidstyle.demo.drawing import RATE, SECONDS, film_picture
from vidstyle.renderer import Renderer
from vidstyle.style import PLAIN, load_style

STYLES = (PLAIN, "comic", "impressionist", "ink", "pixel", "engraving", "poster")
SIZE = 480, 270
MEANT_FOR = 400
"""The height for which lengths are meant here: else dots and strokes would hardly be seen, so small."""
EVERY = 2
"""Of so many pictures of the film one is shown; the others keep the style steady."""
QUALITY = 36


def animation() -> bytes:
    """The picture as a WebP file: a GIF's 256 colours would take four times the room for less."""
    pictures = [Image.fromarray(picture) for picture in _pictures()]
    content = io.BytesIO()
    pictures[0].save(
        content,
        "WEBP",
        save_all=True,
        append_images=pictures[1:],
        duration=1000 * EVERY // RATE,
        loop=0,
        quality=QUALITY,
        method=6,
    )
    return content.getvalue()


def _pictures() -> Iterator[np.ndarray]:
    """Each style has a second of the film, and goes on where the one before it stopped."""
    for second, name in enumerate(STYLES):
        style = load_style(name)
        with Renderer(
            style if style.is_plain else replace(style, height=MEANT_FOR), device="cpu"
        ) as renderer:
            for number in range(RATE):
                time = (second + number / RATE) % SECONDS
                picture = renderer(cv2.resize(film_picture(time), SIZE, interpolation=cv2.INTER_AREA))
                if number % EVERY == 0:
                    yield _titled(picture, "source" if style.is_plain else name)


def _titled(picture: np.ndarray, name: str) -> np.ndarray:
    """The picture with the name in its upper right corner, where the sky is empty."""
    font, size = cv2.FONT_HERSHEY_DUPLEX, 0.65
    left = picture.shape[1] - cv2.getTextSize(name, font, size, 1)[0][0] - 26
    picture = cv2.rectangle(picture.copy(), (left, 10), (picture.shape[1] - 10, 38), (20, 20, 24), -1)
    return cv2.putText(picture, name, (left + 8, 30), font, size, (255, 255, 255), 1, cv2.LINE_AA)
