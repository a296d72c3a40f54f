"""Finds faces with a cascade of OpenCV's, where there is one."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from vidstyle.comic.moment import Box
from vidstyle.errors import InputError

_USUAL = "haarcascade_frontalface_default.xml"
_LEAST = 1 / 12
"""Smaller faces are not looked for; shares of the picture's shorter side."""
_NEIGHBOURS = 6
"""So many places next to one another must look like a face."""
_SKIN = 0.25
"""A face in a colour picture has at least this share of skin."""


class FaceFinder:
    """Looks for upright frontal faces.

    Without a model it takes the one that comes with OpenCV; not every version brings one, and then no
    faces are found.
    """

    def __init__(self, model: Path | None = None) -> None:
        """`model`: a cascade as OpenCV stores it, an .xml file.

        Raises:
            InputError: it is none.
        """
        self._cascade = _load(model) if model is not None else _usual_cascade()

    def find(self, color: np.ndarray) -> list[Box]:
        """The faces in a picture, H x W x 3 uint8, the largest first."""
        if self._cascade is None:
            return []
        luma = cv2.equalizeHist(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY))
        least = max(20, round(_LEAST * min(luma.shape)))
        found = self._cascade.detectMultiScale(
            luma, scaleFactor=1.1, minNeighbors=_NEIGHBOURS, minSize=(least, least)
        )
        skin, colorful = skin_map(color), is_colorful(color)
        boxes = [Box(int(x), int(y), int(x + w), int(y + h)) for x, y, w, h in found]
        faces = [box for box in boxes if not colorful or _inside(skin, box).mean() > _SKIN]
        return sorted(faces, key=lambda box: (-box.area, box.left, box.top))


def skin_map(color: np.ndarray) -> np.ndarray:
    """Where an H x W x 3 uint8 picture has the chroma of skin (Chai and Ngan 1999): H x W float32, 0 or 1."""
    luma, red, blue = cv2.split(cv2.cvtColor(color, cv2.COLOR_RGB2YCrCb))
    skin = (red > 133) & (red < 173) & (blue > 77) & (blue < 127) & (luma > 40)
    return skin.astype(np.float32)


def is_colorful(color: np.ndarray) -> bool:
    """Whether a picture is not all gray."""
    return bool(np.mean(color.max(axis=2) - color.min(axis=2)) > 8)


def _inside(plane: np.ndarray, box: Box) -> np.ndarray:
    return plane[int(box.top) : int(box.bottom), int(box.left) : int(box.right)]


def _usual_cascade() -> cv2.CascadeClassifier | None:
    path = Path(cv2.__file__).parent / "data" / _USUAL
    return _load(path) if path.is_file() and hasattr(cv2, "CascadeClassifier") else None


def _load(path: Path) -> cv2.CascadeClassifier:
    # OpenCV reports what it cannot parse on standard error, and in exceptions of its own.
    remedy = "give a cascade in OpenCV's format, such as haarcascade_frontalface_default.xml"
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}", remedy) from None
    try:
        cascade = cv2.CascadeClassifier(str(path)) if "<cascade" in text or "opencv-" in text else None
    except cv2.error:
        cascade = None
    if cascade is None or cascade.empty():
        raise InputError(path, "is not a model of faces", remedy)
    return cascade
