"""Face detection: three small networks, or with OpenCV a cascade or a YuNet network."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from threading import Lock
from typing import Any

import cv2
import numpy as np

from vidstyle.comic.analyze.face_networks import find_faces, load_networks, weights_folder
from vidstyle.comic.moment import Box, Point, usual_mouth
from vidstyle.core.opencv_log import silent_opencv
from vidstyle.errors import InputError

_REMEDY = "give a cascade of OpenCV's (.xml) or a YuNet model (.onnx)"
_MIN_SIDE = 1 / 12
"""Smaller faces are not looked for; shares of the picture's shorter side."""
_MIN_SIDE_NETWORK = 1 / 24
"""The same for a YuNet network, which is not deceived so easily."""
_MIN_HEIGHT, LARGE = 0.055, 0.13
"""The same for the networks of mtcnn, relative to the picture's height, and for large faces only."""
_NEIGHBOURS = 6
"""So many places next to one another must look like a face to a cascade."""
_MIN_SCORE = 0.75
"""A network must be so sure of a face, 0..1."""
_TRIAL = 64
"""Pixels of the sides of an empty picture on which a network is tried."""
_SKIN = 0.25
"""A face in a colour picture has at least this share of skin, if a cascade has found it."""
_LEAST_SKIN, _SURE = 0.1, 0.95
"""The same for the networks of mtcnn, unless they are surer than that."""

_SEARCHED = 0.9 * LARGE
"""A little smaller, so that a large face is found in all frames of a shot."""
_SMALLEST = 12.0
"""Pixels; less of a face is not enough for these networks."""

_HAS_CASCADES = hasattr(cv2, "CascadeClassifier")

Mouths = dict[Box, Point]
"""Faces, and where the mouth of each is."""
_Finder = Callable[[np.ndarray, float], Mouths]
"""Finds faces of at least a share of the picture's height; one of OpenCV's has a limit of its own."""


class FaceFinder:
    """Detects faces.

    Without a model it uses the networks of the package mtcnn; where that is not installed, it finds none.

    Attributes:
        has_model: whether faces can be found.
    """

    def __init__(self, model: Path | None = None) -> None:
        """`model`: a cascade as OpenCV stores it, an .xml file, or a YuNet network, an .onnx file.

        Raises:
            InputError: the model cannot be read.
        """
        self._finder: _Finder | None = None
        # OpenCV's detectors hold a state; the networks can be run side by side.
        self._lock: AbstractContextManager[Any] = Lock() if model is not None else nullcontext()
        if model is not None:
            self._finder = _yunet(model) if model.suffix.lower() == ".onnx" else _cascade(model)
        elif folder := weights_folder():
            self._finder = _networks(folder)
        self.has_model = self._finder is not None

    def find(self, color: np.ndarray, only_large: bool = False) -> Mouths:
        """The faces in a picture, H x W x 3 uint8, the largest first; only large ones are found sooner."""
        if self._finder is None:
            return {}
        with self._lock:
            found = self._finder(color, _SEARCHED if only_large else _MIN_HEIGHT)
        return {box: found[box] for box in sorted(found, key=lambda box: (-box.area, box.left, box.top))}


def skin_map(color: np.ndarray) -> np.ndarray:
    """Where an H x W x 3 uint8 picture has the chroma of skin (Chai and Ngan 1999): H x W float32, 0 or 1."""
    luma, red, blue = cv2.split(cv2.cvtColor(color, cv2.COLOR_RGB2YCrCb))
    skin = (red > 133) & (red < 173) & (blue > 77) & (blue < 127) & (luma > 40)
    return skin.astype(np.float32)


def is_colorful(color: np.ndarray) -> bool:
    """Whether a picture has colours, not only grays."""
    red, green, blue = cv2.split(color)
    brightest, darkest = cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue)
    return bool(np.mean(brightest - darkest) > 8)


def _networks(folder: Path) -> _Finder:
    networks = load_networks(folder)

    def find(color: np.ndarray, least: float) -> Mouths:
        height, width = color.shape[:2]
        rows = find_faces(color, networks, max(_SMALLEST, least * height))
        whole, skin, colorful = Box(0, 0, width, height), skin_map(color), is_colorful(color)
        found: Mouths = {}
        for row in rows.tolist():
            box = Box(*map(round, row[:4])).intersection(whole)
            is_skin = not colorful or row[4] > _SURE or _inside(skin, box).mean() > _LEAST_SKIN
            if box.area > 0 and is_skin:
                found[box] = row[5], row[6]
        return found

    return find


def _cascade(path: Path) -> _Finder:
    # OpenCV reports what it cannot parse on standard error, and in exceptions of its own.
    text = _content(path).decode("utf-8", "replace")
    try:
        is_one = _HAS_CASCADES and ("<cascade" in text or "opencv-" in text)
        cascade = cv2.CascadeClassifier(str(path)) if is_one else None
    except cv2.error:
        cascade = None
    if cascade is None or cascade.empty():
        raise InputError(path, "is not a model of faces", _REMEDY)

    def find(color: np.ndarray, _: float) -> Mouths:
        luma = cv2.equalizeHist(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY))
        least = max(20, round(_MIN_SIDE * min(luma.shape)))
        found = cascade.detectMultiScale(
            luma, scaleFactor=1.1, minNeighbors=_NEIGHBOURS, minSize=(least, least)
        )
        skin, colorful = skin_map(color), is_colorful(color)
        boxes = [Box(int(x), int(y), int(x + w), int(y + h)) for x, y, w, h in found]
        return {box: usual_mouth(box) for box in boxes if not colorful or _inside(skin, box).mean() > _SKIN}

    return find


def _yunet(path: Path) -> _Finder:
    content = np.frombuffer(_content(path), np.uint8)
    try:
        with silent_opencv():
            network = cv2.FaceDetectorYN.create(
                "onnx", content, np.empty(0, np.uint8), (_TRIAL, _TRIAL), score_threshold=_MIN_SCORE
            )
            network.detect(np.zeros((_TRIAL, _TRIAL, 3), np.uint8))
    except cv2.error:
        raise InputError(path, "is not a model of faces", _REMEDY) from None

    def find(color: np.ndarray, _: float) -> Mouths:
        height, width = color.shape[:2]
        network.setInputSize((width, height))
        _, found = network.detect(np.ascontiguousarray(color[..., ::-1]))
        whole, least = Box(0, 0, width, height), _MIN_SIDE_NETWORK * min(height, width)
        rows = found[:, :4].astype(float) if found is not None else np.empty((0, 4))
        boxes = [Box(x, y, x + wide, y + high).intersection(whole) for x, y, wide, high in rows.tolist()]
        return {box: usual_mouth(box) for box in boxes if min(box.width, box.height) >= least}

    return find


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}", _REMEDY) from None


def _inside(plane: np.ndarray, box: Box) -> np.ndarray:
    return plane[int(box.top) : int(box.bottom), int(box.left) : int(box.right)]
