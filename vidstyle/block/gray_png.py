"""Reads PNG pictures from untrusted sources as gray."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np

from vidstyle.core.file_checks import read_regular_file


def read_gray_png(file: Path, max_side: int, max_bytes: int) -> np.ndarray:
    """Read a PNG picture as gray, H x W uint8.

    Args:
        max_side: maximum width and height in pixels, checked before the picture is decoded.
        max_bytes: maximum size of the file.

    Raises:
        ValueError: the file is not a PNG, or larger.
        OSError: the file cannot be read.
    """
    try:
        content = read_regular_file(file, max_bytes)
    except ValueError as error:
        raise ValueError(f"{file.name} {error}") from None
    is_png = content[:4] == b"\x89PNG" and len(content) >= 24
    if not is_png or not 0 < max(struct.unpack(">II", content[16:24])) <= max_side:
        raise ValueError(f"{file.name} is not a PNG of at most {max_side} x {max_side} pixels")
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise ValueError(f"{file.name} is damaged")
    return np.asarray(picture, np.uint8)
