"""Where people are: by a small segmentation network that the user installs or names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vidstyle.core.file_checks import read_regular_file
from vidstyle.errors import InputError, UsageError
from vidstyle.network.network_process import NetworkProcess
from vidstyle.network.onnx_file import MIN_SIDE_PX
from vidstyle.network.recurrent_ports import recurrent_ports
from vidstyle.regions.chosen_files import INSTALL_COMMAND, people_model

MAX_MODEL_BYTES = 64 << 20
INPUT_SIZES = (256, 144), (256, 256), (192, 192), (320, 320), (512, 512)
"""Width and height of the input: a model must accept the first of them that it does not refuse."""
FREE_SIZE = 512, 288
"""Width and height of the input of a model that remembers earlier pictures, and takes any size."""
MAX_SIDE_PX = 1024

_MODEL_REMEDY = "give a TFLite or ONNX model that returns the probability of people for each pixel"
_KINDS = {".tflite": "tflite", ".onnx": "onnx"}
"""Kinds of models by the extension of their files."""


class PeopleNetwork:
    """Finds people in pictures. It runs in a separate process, which a damaged model may crash.

    Attributes:
        size: width and height of its input.
    """

    def __init__(self, path: Path) -> None:
        """`path`: a model, .tflite or .onnx: its input is RGB, 0..1; see `RecurrentPorts` for further ones.

        Raises:
            InputError: the model cannot be read, or is of another kind.
        """
        self._path = path
        self._process, sizes = _open_process(path)
        self.size = self._accepted_size(sizes)

    def find(self, color: np.ndarray, is_first: bool = True) -> np.ndarray:
        """Return the probability of a person at each pixel.

        Args:
            color: height x width of `size` x 3 uint8 RGB.
            is_first: whether the model forgets earlier pictures, if it remembers them.

        Returns:
            Height x width float32, 0..1.

        Raises:
            InputError: the model fails.
        """
        try:
            return np.clip(self._run(color.astype(np.float32) / 255, is_first), 0, 1)
        except ValueError as error:
            raise InputError(self._path, str(error), _MODEL_REMEDY) from None

    def _accepted_size(self, sizes: Sequence[tuple[int, int]]) -> tuple[int, int]:
        """Return the first size for which the network returns one or two planes of this size."""
        for width, height in sizes:
            try:
                self._run(np.zeros((height, width, 3), np.float32))
                return width, height
            except ValueError as error:
                reason = f": {error}" if len(sizes) == 1 else ""
        raise InputError(self._path, f"is not a model that finds people{reason}", _MODEL_REMEDY)

    def _run(self, picture: np.ndarray, is_first: bool = True) -> np.ndarray:
        """Return the last plane of the result for a picture, H x W x 3 float32.

        Raises:
            ValueError: the network fails, or its result is not one or two planes of this size.
        """
        height, width = picture.shape[:2]
        result = self._process.run(np.ascontiguousarray(picture.transpose(2, 0, 1)[None]), is_first)
        if result.shape not in ((1, 1, height, width), (1, 2, height, width)):
            raise ValueError("returns no plane of the size of its input")
        if not np.isfinite(result).all():
            raise ValueError("returns numbers that are not finite")
        return result[0, -1]


def open_people_network() -> PeopleNetwork:
    """Return the network that finds people.

    Raises:
        UsageError: no model is installed or chosen.
        InputError: the model cannot be used.
    """
    path = people_model()
    if path is None:
        remedy = f"run {INSTALL_COMMAND}, or give --model FILE (docs/masks.md)"
        raise UsageError("the mask people", "needs a model that finds them", remedy)
    return PeopleNetwork(path)


def _open_process(path: Path) -> tuple[NetworkProcess, Sequence[tuple[int, int]]]:
    """Return a process that runs a model, and the sizes of its input to try."""
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise InputError(path, "is not a TFLite or ONNX model", _MODEL_REMEDY)
    try:
        content = read_regular_file(path, MAX_MODEL_BYTES)
        ports = recurrent_ports(content) if kind == "onnx" else None
        sizes = INPUT_SIZES if ports is None else [_size_of(ports.shape)]
    except ValueError as error:
        raise InputError(path, str(error), _MODEL_REMEDY) from None
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}", _MODEL_REMEDY) from None
    process = NetworkProcess()
    try:
        process.open(content, kind, ports)
    except ValueError:
        raise InputError(path, "cannot be read as a model", _MODEL_REMEDY) from None
    return process, sizes


def _size_of(shape: Sequence[int]) -> tuple[int, int]:
    """Return width and height of the input of a shape 1 x 3 x H x W.

    Raises:
        ValueError: it is too small or too large.
    """
    height, width = (given or free for given, free in zip(shape[2:], FREE_SIZE[::-1], strict=True))
    if not all(MIN_SIDE_PX <= side <= MAX_SIDE_PX for side in (height, width)):
        raise ValueError(f"takes pictures of {width} x {height}; {MIN_SIDE_PX} to {MAX_SIDE_PX} are possible")
    return width, height
