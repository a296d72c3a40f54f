"""Pictures in memory that two processes share."""

from __future__ import annotations

import math
import mmap
import os
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from vidstyle.core.picture import Picture

ALIGNMENT_BYTES = 64
"""Planes begin at multiples of this, the size of a cache line."""
ROW_PADDING_PX = 16
"""Additional width of a plane that is not contiguous."""
MAX_VIEWS = 64
"""Views that are kept for later pictures."""


@dataclass(frozen=True)
class StoredPlane:
    """The place of a plane in shared memory.

    Attributes:
        offset: in bytes.
        stored: its shape with the padding of its rows.
        width: its width without padding.
        dtype: the NumPy type of its samples, as text.
        end: the offset after its last byte.
    """

    offset: int
    stored: tuple[int, ...]
    width: int
    dtype: str
    end: int

    @classmethod
    def of(cls, plane: np.ndarray, offset: int) -> StoredPlane:
        """Return the place of a plane from this offset on.

        Kernels are compiled separately for contiguous planes, so the stored plane is contiguous as well, or
        not.
        """
        padding = 0 if plane.flags.c_contiguous else ROW_PADDING_PX
        stored = plane.shape[0], plane.shape[1] + padding, *plane.shape[2:]
        first = -(-offset // ALIGNMENT_BYTES) * ALIGNMENT_BYTES
        end = first + math.prod(stored) * plane.itemsize
        return cls(first, stored, plane.shape[1], plane.dtype.str, end)


class SharedPictures:
    """Pictures in the memory of a file descriptor; it grows when a picture needs more.

    Args:
        descriptor: of an anonymous file, open for reading and writing.
    """

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self._memory: mmap.mmap | None = None
        self._views: dict[StoredPlane, np.ndarray] = {}

    def store(
        self, picture: Picture, offset: int = 0, known: Mapping[int, StoredPlane] = MappingProxyType({})
    ) -> tuple[Picture, int]:
        """Copy a picture into the memory.

        Args:
            offset: after what must stay in the memory, in bytes.
            known: places of planes that are in the memory, by their `id`.

        Returns:
            The picture with a `StoredPlane` in place of each plane, and the offset after its last byte.
        """
        end = offset

        def place(plane: np.ndarray, _: str) -> Any:
            nonlocal end
            if id(plane) in known:
                return known[id(plane)]
            stored = StoredPlane.of(plane, end)
            end = stored.end
            self.view(stored)[...] = plane
            return stored

        return picture.map_planes(place), end

    def load(self, stored: Picture) -> Picture:
        """Return a stored picture, whose planes are views on the memory."""
        view: Any = self.view
        return stored.map_planes(lambda plane, _: view(plane))

    def view(self, plane: StoredPlane) -> np.ndarray:
        """Return a stored plane, a view on the memory: the same object each time, as pictures are alike."""
        if plane not in self._views:
            if len(self._views) == MAX_VIEWS:
                self._views.clear()
            rows = np.ndarray(plane.stored, plane.dtype, buffer=self._mapped(plane.end), offset=plane.offset)
            self._views[plane] = rows[:, : plane.width]
        return self._views[plane]

    def _mapped(self, end: int) -> mmap.mmap:
        """Return the memory, of at least this size."""
        if self._memory is None or len(self._memory) < end:
            size = os.fstat(self.descriptor).st_size
            if size < end:
                size = end
                os.ftruncate(self.descriptor, size)
            # Views on the earlier mapping keep it; both have the same content.
            self._memory = mmap.mmap(self.descriptor, size)
        return self._memory


def planes_of(picture: Picture) -> list[Any]:
    """Return the planes of a picture or of a stored picture, in the order of `Picture.map_planes`."""
    planes = list[Any]()

    def note(plane: np.ndarray, _: str) -> np.ndarray:
        planes.append(plane)
        return plane

    picture.map_planes(note)
    return planes
