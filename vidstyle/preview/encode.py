"""Encoding of pictures for browsers, and decoding."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from vidstyle.media.picture_bytes import jpeg_bytes, png_bytes

PictureFormat = Literal["png", "jpeg"]

JPEG_QUALITY = 92


def encode(picture: np.ndarray, format: PictureFormat) -> bytes:
    """Encode an H x W x 3 uint8 RGB picture as lossless PNG or smaller JPEG; with alpha only as PNG."""
    if format == "jpeg":
        return jpeg_bytes(picture, JPEG_QUALITY)
    # For local transfer, speed matters more than size; most of a picture with alpha is empty.
    return png_bytes(picture, compression=int(picture.shape[2] == 4))


def decode_picture(data: bytes) -> np.ndarray:
    """Return the picture of a file that `encode` made: H x W x 3 uint8 RGB."""
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR_RGB)
    assert picture is not None
    return picture
