"""The pictures that banks are trained on."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vidstyle.core.picture import BT709_WEIGHTS, Picture
from vidstyle.core.planes import color_rows
from vidstyle.core.resample import resample
from vidstyle.errors import InputError, error_reason
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import open_reader

PICTURE_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp")
"""Suffixes of pictures in a folder."""


@dataclass(frozen=True)
class Photograph:
    """A picture in a file.

    Attributes:
        long_side: maximum length of the longer side in pixels; larger pictures are reduced.
    """

    path: Path
    long_side: int = 1000

    @property
    def checksum(self) -> str:
        """The first twelve digits of the file's SHA-256."""
        return hashlib.sha256(self.path.read_bytes()).hexdigest()[:12]

    def color(self) -> np.ndarray:
        """Read its RGB, H x W x 3 float32 0..1, gamma-encoded as in the file.

        Raises:
            InputError: the file cannot be read.
        """
        picture = self._read()
        color = np.clip(color_rows(picture, 0, picture.shape[0]), 0, 1)
        share = self.long_side / max(picture.shape)
        height, width = (max(1, round(side * share)) for side in picture.shape)
        return color if share >= 1 else resample(color, (height, width), "area")

    def _read(self) -> Picture:
        with open_reader(self.path) as reader:
            for item in reader:
                if isinstance(item, Frame):
                    return item.picture
        raise InputError(self.path, "contains no picture", "remove it from the folder")


def luma_of(picture: np.ndarray) -> np.ndarray:
    """Return the luma of RGB, H x W float32; luma, H x W, is returned unchanged."""
    return np.asarray(picture @ BT709_WEIGHTS if picture.ndim == 3 else picture, np.float32)


def chroma_of(picture: np.ndarray) -> list[np.ndarray]:
    """Return blue and red difference of RGB, H x W float32 -0.5..0.5; 0 for luma."""
    luma = luma_of(picture)
    if picture.ndim == 2:
        return [np.zeros_like(luma)] * 2
    return [(picture[..., channel] - luma) / (2 - 2 * BT709_WEIGHTS[channel]) for channel in (2, 0)]


def photographs_in(folder: Path, long_side: int) -> list[Photograph]:
    """Return the pictures in a folder, sorted by name.

    Raises:
        InputError: the folder has no pictures or cannot be read.
    """
    try:
        entries = sorted(folder.iterdir())
        found = [path for path in entries if path.suffix.lower() in PICTURE_SUFFIXES and path.is_file()]
    except OSError as error:
        raise InputError(folder, error_reason(error).lower(), "choose another --images") from None
    if not found:
        raise InputError(folder, "contains no pictures", f"add some: {', '.join(PICTURE_SUFFIXES)}")
    return [Photograph(path, long_side) for path in found]
