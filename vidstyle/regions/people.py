"""Where people are: by a small segmentation network that the user installs or names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.opencv_log import silent_opencv
from vidstyle.errors import InputError, UsageError
from vidstyle.regions.chosen_files import INSTALLATION, people_model

MAX_MODEL_BYTES = 64 << 20
INPUT_SIZES = (256, 144), (256, 256), (192, 192), (320, 320), (512, 512)
"""Width and height of the input: a model must accept the first of them that it does not refuse."""

_MODEL_REMEDY = "give a TFLite or ONNX model that returns the probability of people for each pixel"
_READERS = {".tflite": "readNetFromTFLite", ".onnx": "readNetFromONNX"}


class PeopleNetwork:
    """Finds people in pictures.

    Attributes:
        size: width and height of its input.
    """

    def __init__(self, path: Path) -> None:
        """`path`: a model, .tflite or .onnx: its input is RGB, 0..1.

        Raises:
            InputError: the model cannot be read, or is of another kind.
        """
        self._network = _read_network(path)
        with silent_opencv():
            self.size = next(filter(self._takes, INPUT_SIZES), (0, 0))
        if self.size == (0, 0):
            raise InputError(path, "is not a model that finds people", _MODEL_REMEDY)

    def find(self, color: np.ndarray) -> np.ndarray:
        """Return the probability of a person at each pixel.

        Args:
            color: height x width of `size` x 3 uint8 RGB.

        Returns:
            Height x width float32, 0..1.
        """
        self._network.setInput(cv2.dnn.blobFromImage(color, 1 / 255))
        return np.clip(self._network.forward()[0, -1], 0, 1)

    def _takes(self, size: tuple[int, int]) -> bool:
        """Whether the network returns one or two planes of this size for an input of this size."""
        try:
            self._network.setInput(np.zeros((1, 3, size[1], size[0]), np.float32))
            shape = np.shape(self._network.forward())
        except cv2.error:
            return False
        return shape in ((1, 1, size[1], size[0]), (1, 2, size[1], size[0]))


def open_people_network() -> PeopleNetwork:
    """Return the network that finds people.

    Raises:
        UsageError: no model is installed or chosen.
        InputError: the model cannot be used.
    """
    path = people_model()
    if path is None:
        remedy = f"run {INSTALLATION}, or give --model FILE (docs/masks.md)"
        raise UsageError("the mask people", "needs a model that finds them", remedy)
    return PeopleNetwork(path)


def _read_network(path: Path) -> Any:
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(path, "is not a TFLite or ONNX model", _MODEL_REMEDY)
    try:
        content = np.frombuffer(read_regular_file(path, MAX_MODEL_BYTES), np.uint8)
        with silent_opencv():
            return getattr(cv2.dnn, reader)(content)
    except (ValueError, cv2.error) as error:
        reason = str(error) if isinstance(error, ValueError) else "cannot be read as a model"
        raise InputError(path, reason, _MODEL_REMEDY) from None
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}", _MODEL_REMEDY) from None
