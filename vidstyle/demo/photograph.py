"""The example that pages show until a file is opened: a camera moves back from a photograph."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from vidstyle.demo.drawing import FILM_HEIGHT_PX, FILM_SECONDS, FILM_WIDTH_PX
from vidstyle.export import EXAMPLE_FILE

_FACE_PX = (225.0, 125.0)
"""The point that the camera moves back from: x and y in the photograph."""
_FIRST_WIDTH_RATIO = 0.75
"""Width of the first picture, relative to the photograph."""


def photograph_picture(time: float) -> np.ndarray:
    """Return the picture at a time in seconds: FILM_HEIGHT_PX x FILM_WIDTH_PX x 3 RGB, uint8."""
    photograph = _photograph()
    ratio = _FIRST_WIDTH_RATIO + (1 - _FIRST_WIDTH_RATIO) * min(1.0, time / FILM_SECONDS)
    scale = FILM_WIDTH_PX / (photograph.shape[1] * ratio)
    shift = [-scale * (1 - ratio) * place for place in _FACE_PX]
    matrix = np.array([[scale, 0, shift[0]], [0, scale, shift[1]]])
    size = (FILM_WIDTH_PX, FILM_HEIGHT_PX)
    return cv2.warpAffine(photograph, matrix, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


@cache
def _photograph() -> np.ndarray:
    picture = cv2.imdecode(np.fromfile(EXAMPLE_FILE, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None, EXAMPLE_FILE
    return np.ascontiguousarray(picture[..., ::-1])
