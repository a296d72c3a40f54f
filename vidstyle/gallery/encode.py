"""Pictures as the bytes of a file."""

from __future__ import annotations

import cv2
import numpy as np

JPEG_QUALITY = 88

_SETTINGS = {
    ".png": [],
    # Reduced chroma, which WebP always has too, would wash out coloured dots and strokes.
    ".jpg": [
        *(cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY),
        *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
        *(cv2.IMWRITE_JPEG_OPTIMIZE, 1),
    ],
}


def encoded(picture: np.ndarray, ending: str) -> bytes:
    """A picture, H x W x 3 uint8 RGB, as a file with the ending .png or .jpg."""
    done, content = cv2.imencode(ending, picture[..., ::-1], _SETTINGS[ending])
    assert done, ending
    return content.tobytes()
