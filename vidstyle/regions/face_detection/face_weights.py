"""Read the weights of the networks for faces, which joblib has written, without joblib.

joblib takes 70 ms of processor time to import. A file holds a pickled list of descriptions of arrays, of the
class `NumpyArrayWrapper` of joblib; padding and the numbers of the array follow each of them.
"""

from __future__ import annotations

import io
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np

_KNOWN_NAMES = {("numpy", "ndarray"): np.ndarray, ("numpy", "dtype"): np.dtype}
"""What a file may contain besides descriptions."""


class _ExactReader:
    """The bytes of a file, without `peek`, so that pickle reads no more than it needs, and arrays follow."""

    def __init__(self, content: bytes) -> None:
        stream = io.BytesIO(content)
        self.read, self.readline = stream.read, stream.readline


class _ArrayUnpickler(pickle.Unpickler):
    def __init__(self, reader: _ExactReader) -> None:
        super().__init__(reader)
        self._reader = reader

    def find_class(self, module: str, name: str) -> Any:
        """Return the class of a description or a known class; a file cannot load others."""
        if (module, name) != ("joblib.numpy_pickle", "NumpyArrayWrapper"):
            return _KNOWN_NAMES[module, name]
        reader = self._reader

        class Stored:
            array: np.ndarray

            def __setstate__(self, fields: dict[str, Any]) -> None:
                if fields.get("numpy_array_alignment_bytes") is not None:
                    reader.read(reader.read(1)[0])  # the first byte says how many follow
                dtype, shape = fields["dtype"], fields["shape"]
                numbers = np.frombuffer(reader.read(math.prod(shape) * dtype.itemsize), dtype)
                self.array = numbers.reshape(shape, order=fields["order"])

        return Stored


def read_weights(path: Path) -> list[np.ndarray]:
    """Return the arrays of an lz4 file in their order, read-only."""
    import lz4.frame

    with lz4.frame.open(path) as file:
        content = file.read()
    return [each.array for each in _ArrayUnpickler(_ExactReader(content)).load()]
