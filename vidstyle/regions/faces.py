"""Face detection by three small networks, or by the user's OpenCV cascade or YuNet model."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from threading import Lock
from typing import Any

import cv2
import numpy as np

from vidstyle.core.opencv_log import silent_opencv
from vidstyle.errors import InputError
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_detection.face_networks import (
    MAX_PROPOSALS,
    Weights,
    find_faces,
    load_networks,
    score_face,
    weights_folder,
)
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS, Landmarks, MarkedFaces

_MODEL_REMEDY = "use an OpenCV cascade (.xml) or a YuNet model (.onnx)"
# Detection by the networks of mtcnn.
MIN_FACE_HEIGHT_RATIO = 0.055
"""Minimum height of a face, relative to the picture's height."""
LARGE_FACE_HEIGHT_RATIO = 0.13
"""Minimum height of a large face, relative to the picture's height."""
SEARCHED_HEIGHT_RATIO = 0.9 * LARGE_FACE_HEIGHT_RATIO
"""Detection limit for large faces: slightly smaller, so that a large face is found throughout a shot."""
_MIN_FACE_PX = 12.0
"""Minimum height of a face in pixels, for the networks."""
_MIN_SKIN_SHARE = 0.1
"""Minimum share of skin in a face of a colour picture, unless the score of the networks is high."""
_CERTAIN_SCORE = 0.95
"""Score from which skin is not checked, 0..1."""

# Detection by a custom model.
_MIN_CASCADE_SIDE_RATIO = 1 / 12
"""Minimum side of a face for a cascade, relative to the picture's shorter side."""
_MIN_CASCADE_NEIGHBOURS = 6
"""Minimum number of neighbouring detections for a cascade to accept a face."""
_MIN_CASCADE_SKIN_SHARE = 0.25
"""Minimum share of skin in a face that a cascade has found in a colour picture."""
_MIN_YUNET_SIDE_RATIO = 1 / 24
"""Minimum side of a face for YuNet, which makes fewer errors, relative to the picture's shorter side."""
_MIN_YUNET_SCORE = 0.75
"""Minimum score of a face that YuNet has found, 0..1."""
_TRIAL_SIDE_PX = 64
"""Side of the empty picture on which a YuNet model is tried."""

_HAS_CASCADES = hasattr(cv2, "CascadeClassifier")

_Detector = Callable[[np.ndarray, float, int], MarkedFaces]
"""Finds faces at least as high as a fraction of the picture among a number of proposals; OpenCV detectors use
their own limits instead."""


class FaceFinder:
    """Detects faces.

    Without a model it uses the networks of the package mtcnn; if that is not installed, it finds no faces.

    Attributes:
        has_model: whether faces can be found.
    """

    def __init__(self, model: Path | None = None) -> None:
        """`model`: an OpenCV cascade (.xml) or a YuNet network (.onnx).

        Raises:
            InputError: the model cannot be read.
        """
        self._detector: _Detector | None = None
        self._networks: tuple[Weights, Weights, Weights] | None = None
        # OpenCV's detectors are stateful; the networks can run in parallel.
        self._lock: AbstractContextManager[Any] = Lock() if model is not None else nullcontext()
        if model is not None:
            self._detector = (
                _create_yunet(model) if model.suffix.lower() == ".onnx" else _create_cascade(model)
            )
        elif folder := weights_folder():
            self._networks = load_networks(folder)
            self._detector = _create_mtcnn(self._networks)
        self.has_model = self._detector is not None

    def find(
        self, color: np.ndarray, least: float = MIN_FACE_HEIGHT_RATIO, max_proposals: int = MAX_PROPOSALS
    ) -> MarkedFaces:
        """Return the faces in a picture, the largest first.

        Args:
            color: H x W x 3 uint8.
            least: minimum height of a face, relative to the picture's height; a larger one is faster.
            max_proposals: maximum number of parts of the picture that are examined.
        """
        if self._detector is None:
            return {}
        with self._lock:
            found = self._detector(color, least, max_proposals)
        return {box: found[box] for box in sorted(found, key=lambda box: (-box.area, box.left, box.top))}

    def score(self, color: np.ndarray, face: Box) -> float | None:
        """Return how much a part of a picture, H x W x 3 uint8, looks like a face, 0..1; None: unknown."""
        return None if self._networks is None else score_face(color, face, self._networks)


def skin_map(color: np.ndarray) -> np.ndarray:
    """Return a mask of the pixels with the chroma of skin (Chai and Ngan 1999): H x W float32, 0 or 1.

    `color` is H x W x 3 uint8.
    """
    luma, red, blue = cv2.split(cv2.cvtColor(color, cv2.COLOR_RGB2YCrCb))
    skin = (red > 133) & (red < 173) & (blue > 77) & (blue < 127) & (luma > 40)
    return skin.astype(np.float32)


def is_colorful(color: np.ndarray) -> bool:
    """Whether a picture has colours, and not only grays."""
    red, green, blue = cv2.split(color)
    brightest, darkest = cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue)
    return bool(np.mean(brightest - darkest) > 8)


def skin_shares(color: np.ndarray, faces: Iterable[Box]) -> list[float]:
    """Return the share of skin in each face of a picture, H x W x 3 uint8, 0..1; 1 in a gray picture."""
    boxes = list(faces)
    if not is_colorful(color):
        return [1.0] * len(boxes)
    skin = skin_map(color)
    parts = [_crop(skin, box) for box in boxes]
    return [float(part.mean()) if part.size else 0.0 for part in parts]


def _create_mtcnn(networks: tuple[Weights, Weights, Weights]) -> _Detector:
    def find(color: np.ndarray, least: float, max_proposals: int) -> MarkedFaces:
        height, width = color.shape[:2]
        rows = find_faces(color, networks, max(_MIN_FACE_PX, least * height), max_proposals).tolist()
        whole = Box(0, 0, width, height)
        boxes = [Box(*map(round, row[:4])).intersection(whole) for row in rows]
        found: MarkedFaces = {}
        for row, box, skin in zip(rows, boxes, skin_shares(color, boxes), strict=True):
            if box.area > 0 and (row[4] > _CERTAIN_SCORE or skin > _MIN_SKIN_SHARE):
                found[box] = Landmarks.of(list(zip(row[5::2], row[6::2], strict=True)), box)
        return found

    return find


def _create_cascade(path: Path) -> _Detector:
    # OpenCV reports files that it cannot parse on standard error, and raises its own exceptions.
    text = _read_model(path).decode("utf-8", "replace")
    try:
        is_cascade = _HAS_CASCADES and ("<cascade" in text or "opencv-" in text)
        cascade = cv2.CascadeClassifier(str(path)) if is_cascade else None
    except cv2.error:
        cascade = None
    if cascade is None or cascade.empty():
        raise InputError(path, "is not a face detection model", _MODEL_REMEDY)

    def find(color: np.ndarray, _least: float, _max_proposals: int) -> MarkedFaces:
        luma = cv2.equalizeHist(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY))
        least = max(20, round(_MIN_CASCADE_SIDE_RATIO * min(luma.shape)))
        found = cascade.detectMultiScale(
            luma, scaleFactor=1.1, minNeighbors=_MIN_CASCADE_NEIGHBOURS, minSize=(least, least)
        )
        boxes = [Box[float](int(x), int(y), int(x + w), int(y + h)) for x, y, w, h in found]
        shares = skin_shares(color, boxes)
        return {
            box: USUAL_LANDMARKS
            for box, skin in zip(boxes, shares, strict=True)
            if skin > _MIN_CASCADE_SKIN_SHARE
        }

    return find


def _create_yunet(path: Path) -> _Detector:
    content = np.frombuffer(_read_model(path), np.uint8)
    try:
        with silent_opencv():
            network = cv2.FaceDetectorYN.create(
                "onnx",
                content,
                np.empty(0, np.uint8),
                (_TRIAL_SIDE_PX, _TRIAL_SIDE_PX),
                score_threshold=_MIN_YUNET_SCORE,
            )
            network.detect(np.zeros((_TRIAL_SIDE_PX, _TRIAL_SIDE_PX, 3), np.uint8))
    except cv2.error:
        raise InputError(path, "is not a face detection model", _MODEL_REMEDY) from None

    def find(color: np.ndarray, _least: float, _max_proposals: int) -> MarkedFaces:
        height, width = color.shape[:2]
        network.setInputSize((width, height))
        _, found = network.detect(np.ascontiguousarray(color[..., ::-1]))
        whole, least = Box(0, 0, width, height), _MIN_YUNET_SIDE_RATIO * min(height, width)
        faces: MarkedFaces = {}
        for x, y, wide, high, *places in [] if found is None else found[:, :14].astype(float).tolist():
            box = Box(x, y, x + wide, y + high).intersection(whole)
            if min(box.width, box.height) >= least:
                faces[box] = Landmarks.of(list(zip(places[::2], places[1::2], strict=True)), box)
        return faces

    return find


def _read_model(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}", _MODEL_REMEDY) from None


def _crop(plane: np.ndarray, box: Box) -> np.ndarray:
    return plane[int(box.top) : int(box.bottom), int(box.left) : int(box.right)]
