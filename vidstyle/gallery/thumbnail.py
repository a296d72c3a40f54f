"""Thumbnails of styles for lists and buttons: the same photograph in each style."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.style import PLAIN, Style, load_style

THUMBNAIL_WIDTH_PX, THUMBNAIL_HEIGHT_PX = 240, 135
THUMBNAIL_FOLDER = Path(__file__).with_name("thumbnails")
"""The thumbnails of the shipped styles; the thumbnail of `plain` is the photograph at twice the size."""


def thumbnail(style: Style) -> np.ndarray:
    """Return the photograph in a style: THUMBNAIL_HEIGHT_PX x THUMBNAIL_WIDTH_PX x 3 uint8 RGB."""
    ready = shipped_thumbnail(style)
    return restyle_thumbnail(style) if ready is None else ready


def shipped_thumbnail(style: Style) -> np.ndarray | None:
    """Return the thumbnail of a shipped style; None for any other style, changed ones included.

    It is read from a file, so that lists wait for no kernel to compile.
    """
    shipped = {file.stem: file for file in THUMBNAIL_FOLDER.glob("*.webp")}
    if style.name not in shipped or style != load_style(style.name):
        return None
    return _small(_read(shipped[style.name]))


def restyle_thumbnail(style: Style, picture: np.ndarray | None = None) -> np.ndarray:
    """Render the thumbnail of a style: of the photograph, or of the middle of `picture`, H x W x 3 RGB."""
    large = thumbnail_photograph()
    return _small(restyle_picture(large if picture is None else _fill(picture, large.shape), style))


def thumbnail_photograph() -> np.ndarray:
    """Return the photograph of the thumbnails, at twice their size: H x W x 3 uint8 RGB."""
    return _read(THUMBNAIL_FOLDER / f"{PLAIN}.webp")


def _read(file: Path) -> np.ndarray:
    picture = cv2.imdecode(np.fromfile(file, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None, file
    return np.ascontiguousarray(picture[..., ::-1])


def _fill(picture: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return the middle of a picture at the height and the width that `shape` begins with."""
    (height, width), (high, wide) = picture.shape[:2], shape[:2]
    across, down = min(width, round(height * wide / high)), min(height, round(width * high / wide))
    left, top = (width - across) // 2, (height - down) // 2
    middle = picture[top : top + max(1, down), left : left + max(1, across)]
    way = cv2.INTER_AREA if across > wide else cv2.INTER_LINEAR
    return cv2.resize(middle, (wide, high), interpolation=way)


def _small(picture: np.ndarray) -> np.ndarray:
    return cv2.resize(picture, (THUMBNAIL_WIDTH_PX, THUMBNAIL_HEIGHT_PX), interpolation=cv2.INTER_AREA)
