"""Double-buffered upload and download of planes through pixel buffers."""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from vidstyle.gpu.compile.shader_nodes import Format
from vidstyle.gpu.device.textures import new_texture

if TYPE_CHECKING:
    import moderngl

_SAMPLE_TYPES: dict[str, np.dtype] = {
    "f1": np.dtype(np.uint8),
    "nu2": np.dtype(np.uint16),
    "f4": np.dtype(np.float32),
}
"""Type of samples by moderngl's name of the texture's type; integers are normalized."""
_TEXTURE_TYPES = {sample: texture for texture, sample in _SAMPLE_TYPES.items()}

_MAX_ROW_PADDING_PX = 128
"""Rows with more padding are copied to contiguous memory first, as the texture includes the padding."""
_OFFSET_ALIGNMENT_BYTES = 64
"""Alignment of planes in a buffer: one cache line."""


@dataclass(frozen=True)
class _Layout:
    """Memory layout of a plane, in the terms of OpenGL.

    Attributes:
        size: pixels from one row to the next, and number of rows.
        components: samples per pixel.
        alignment: alignment of rows in bytes: 1, 2, 4 or 8.
        row: bytes from one row to the next.
    """

    size: tuple[int, int]
    components: int
    dtype: np.dtype
    alignment: int
    row: int


class Upload:
    """Uploads planes to textures. The caller owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._widest = int(context.info["GL_MAX_TEXTURE_SIZE"])
        self._sets: tuple[dict[str, _Slot], dict[str, _Slot]] = ({}, {})
        self._turn = 0

    def send(self, planes: Mapping[str, np.ndarray]) -> dict[str, moderngl.Texture]:
        """Upload planes to textures, valid until the second next call; planes may be modified at once.

        A texture can be wider than its plane, as rows are sent with their undefined padding.

        Args:
            planes: H x W or H x W x 3, uint8, uint16 or float32, by names that stay the same for all
                pictures.
        """
        slots = self._sets[self._turn]
        self._turn = 1 - self._turn
        for name in slots.keys() - planes.keys():
            slots.pop(name).release()
        return {name: self._send(slots, name, plane) for name, plane in planes.items()}

    def _send(self, slots: dict[str, _Slot], name: str, plane: np.ndarray) -> moderngl.Texture:
        layout, memory = _layout_and_memory(plane, self._widest)
        if name in slots and slots[name].layout != layout:
            slots.pop(name).release()
        if name not in slots:
            slots[name] = _Slot(self._context, layout)
        return slots[name].write(memory)


class _Slot:
    """A pixel buffer and the texture that it fills."""

    def __init__(self, context: moderngl.Context, layout: _Layout) -> None:
        self.layout = layout
        coding = Format(layout.components, _TEXTURE_TYPES[layout.dtype])
        self._buffer = context.buffer(reserve=layout.row * layout.size[1], dynamic=True)
        self._texture = new_texture(context, layout.size[::-1], coding)

    def write(self, memory: np.ndarray) -> moderngl.Texture:
        # Orphaned, as the GPU may still be reading the previous data.
        self._buffer.orphan()
        self._buffer.write(memory)
        self._texture.write(self._buffer, alignment=self.layout.alignment)
        return self._texture

    def release(self) -> None:
        self._buffer.release()
        self._texture.release()


def _layout_and_memory(plane: np.ndarray, widest: int) -> tuple[_Layout, np.ndarray]:
    """Return the layout of a plane and its memory, first to last sample; a copy if OpenGL cannot read it."""
    layout = _layout(plane)
    if layout is None or layout.size[0] > widest:
        plane = np.ascontiguousarray(plane, plane.dtype.newbyteorder("="))
        layout = _layout(plane)
        assert layout is not None
    used = (plane.shape[0] - 1) * layout.row + plane[0].nbytes
    samples = np.lib.stride_tricks.as_strided(
        plane, (used // plane.itemsize,), (plane.itemsize,), writeable=False
    )
    return layout, samples


def _layout(plane: np.ndarray) -> _Layout | None:
    """Return the layout of a plane, or None if OpenGL cannot read its rows."""
    if not (plane.dtype.isnative and plane[0].flags.c_contiguous):
        return None
    height, width, *channels = plane.shape
    components = math.prod(channels)
    pixel = components * plane.itemsize
    # The stride of a single row has no meaning.
    row = plane.strides[0] if height > 1 else width * pixel
    across = row // pixel
    if not width <= across <= width + _MAX_ROW_PADDING_PX:
        return None
    # Rows of RGB often end with less than a pixel of padding, which the alignment skips.
    for alignment in (1, 2, 4, 8):
        if -(-across * pixel // alignment) * alignment == row:
            return _Layout((across, height), components, plane.dtype, alignment, row)
    return None


class Download:
    """Downloads textures as planes. The caller owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._buffers = [context.buffer(reserve=1, dynamic=True) for _ in range(2)]
        # Weak references: a finished transfer holds its arrays, and an unreferenced one need not finish.
        self._transfers: list[Callable[[], PlaneTransfer | None]] = [lambda: None] * 2
        self._turn = 0

    def begin(
        self,
        textures: Sequence[moderngl.Texture],
        shapes: Sequence[tuple[int, int]] | None = None,
    ) -> PlaneTransfer:
        """Start reading the textures; wait only if the second last transfer is still in flight.

        After a compute shader has written, a memory barrier is required before this call.

        Args:
            textures: textures with one component, or with four components, of which the first three are read.
            shapes: numbers of rows and columns of each to read, from the first on; None for all.
        """
        shapes = shapes or [(texture.height, texture.width) for texture in textures]
        arrays = list(map(_empty_plane, textures, shapes))
        older, buffer = self._transfers[self._turn](), self._buffers[self._turn]
        if older is not None:
            older.arrays()
        *offsets, size = accumulate((_aligned(array.nbytes) for array in arrays), initial=0)
        if buffer.size != size:
            buffer.orphan(size)
        for texture, array, offset in zip(textures, arrays, offsets, strict=True):
            self._start(texture, array, buffer, offset)
        transfer = PlaneTransfer(arrays, offsets, buffer)
        self._transfers[self._turn] = weakref.ref(transfer)
        self._turn = 1 - self._turn
        return transfer

    def _start(
        self, texture: moderngl.Texture, array: np.ndarray, buffer: moderngl.Buffer, offset: int
    ) -> None:
        height, width, *channels = array.shape
        if texture.size == (width, height) and not channels:
            texture.read_into(buffer, write_offset=offset)
            return
        framebuffer = self._context.framebuffer([texture])
        framebuffer.read_into(
            buffer,
            viewport=(0, 0, width, height),
            components=math.prod(channels),
            dtype=texture.dtype,
            write_offset=offset,
        )
        # Not cached, as a cache would keep the memory of a texture that its owner has released.
        framebuffer.release()


class PlaneTransfer:
    """Textures in transfer from the GPU."""

    def __init__(self, arrays: list[np.ndarray], offsets: list[int], buffer: moderngl.Buffer) -> None:
        self._arrays = arrays
        self._offsets = offsets
        self._buffer: moderngl.Buffer | None = buffer

    def arrays(self) -> list[np.ndarray]:
        """Wait for the planes, H x W or H x W x 3; the same arrays each time.

        The samples have the type of the textures: uint8, uint16 or float32. Row 0 is the first row of the
            texture.
        """
        if self._buffer is not None:
            for array, offset in zip(self._arrays, self._offsets, strict=True):
                self._buffer.read_into(array, array.nbytes, offset)
            self._buffer = None
        return self._arrays


def _empty_plane(texture: moderngl.Texture, shape: tuple[int, int]) -> np.ndarray:
    return np.empty(shape if texture.components == 1 else (*shape, 3), _SAMPLE_TYPES[texture.dtype])


def _aligned(size: int) -> int:
    return -(-size // _OFFSET_ALIGNMENT_BYTES) * _OFFSET_ALIGNMENT_BYTES
