"""Pictures as the content of PNG, JPEG and WebP files."""

from __future__ import annotations

import cv2
import numpy as np


def png_bytes(picture: np.ndarray, compression: int | None = None) -> bytes:
    """Encode a picture, H x W x 3 or H x W x 4 uint8 RGB, as PNG.

    Args:
        compression: 0 (fast and large) to 9; None for OpenCV's default.
    """
    return _encode(".png", picture, [] if compression is None else [cv2.IMWRITE_PNG_COMPRESSION, compression])


def jpeg_bytes(picture: np.ndarray, quality: int, optimized: bool = False, full_chroma: bool = True) -> bytes:
    """Encode a picture, H x W x 3 uint8 RGB, as JPEG.

    Args:
        quality: 0 to 100.
        optimized: whether to make the file a little smaller, which takes longer.
        full_chroma: False to subsample chroma, which is faster and washes out coloured dots and strokes.
    """
    sampling = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444 if full_chroma else cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420
    options = [
        *(cv2.IMWRITE_JPEG_QUALITY, quality),
        *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling),
        *(cv2.IMWRITE_JPEG_OPTIMIZE, int(optimized)),
    ]
    return _encode(".jpg", picture, options)


def webp_bytes(picture: np.ndarray, quality: int) -> bytes:
    """Encode a picture, H x W x 3 uint8 RGB, as WebP.

    Args:
        quality: 0 to 100.
    """
    return _encode(".webp", picture, [cv2.IMWRITE_WEBP_QUALITY, quality])


def _encode(suffix: str, picture: np.ndarray, options: list[int]) -> bytes:
    order = cv2.COLOR_RGBA2BGRA if picture.shape[2] == 4 else cv2.COLOR_RGB2BGR
    done, content = cv2.imencode(suffix, cv2.cvtColor(picture, order), options)
    assert done, suffix
    return content.tobytes()
