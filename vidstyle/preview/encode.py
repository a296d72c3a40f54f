"""Encoding of pictures for browsers."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

PictureFormat = Literal["png", "jpeg"]

_ENCODER_OPTIONS: dict[PictureFormat, tuple[str, list[int]]] = {
    "png": (".png", [cv2.IMWRITE_PNG_COMPRESSION, 0]),  # for local transfer, speed matters more than size
    "jpeg": (
        ".jpg",
        # Subsampled chroma would wash out coloured dots and strokes.
        [
            *(cv2.IMWRITE_JPEG_QUALITY, 92),
            *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
        ],
    ),
}


def encode(picture: np.ndarray, format: PictureFormat) -> bytes:
    """Encode an H x W x 3 uint8 RGB picture as lossless PNG or smaller JPEG."""
    suffix, options = _ENCODER_OPTIONS[format]
    done, content = cv2.imencode(suffix, picture[..., ::-1], options)
    assert done
    return content.tobytes()
