"""Arrays of any type with odd numbers, and views with any strides and byte order."""

from __future__ import annotations

import io
from collections.abc import Callable
from random import Random

import numpy as np

from tools.fuzzing.damage import ODD_FLOATS

DTYPES = (
    *("uint8", "uint8", "uint16", "uint16", "float16", "float32", "float32", "float64"),
    *("int8", "int32", "int64", "uint64", "bool", "complex64", "longdouble"),
)


def array_case(random: Random) -> tuple[str, bytes]:
    """Return an array file: mostly a picture, else odd numbers, types or shapes."""
    sides = random.randint(1, 40), random.randint(1, 40)
    if random.random() < 0.75:
        return ".npy", array_bytes(_picture(random, (*sides, random.choice((3, 3, 4)))))
    shape = random.choice(
        ((*sides, 3), (*sides, 3), (*sides, 3), sides, (*sides, 5), (*sides, 3, 1), (0, 3, 3))
    )
    return ".npy", array_bytes(make_odd_array(random, shape))


def make_odd_array(random: Random, shape: tuple[int, ...]) -> np.ndarray:
    """Return random numbers of any type, some of them infinite, huge or not a number."""
    numbers = np.random.default_rng(random.randrange(2**32))
    array = np.asarray(numbers.uniform(-0.2, 1.2, shape)) * random.choice((1, 1, 1, 255, 1e30))
    for _ in range(random.choice((0, 1, 5)) if array.ndim and array.size else 0):
        array[tuple(random.randrange(side) for side in shape)] = random.choice(ODD_FLOATS)
    with np.errstate(all="ignore"):
        return array.astype(random.choice(DTYPES))


def _picture(random: Random, shape: tuple[int, ...]) -> np.ndarray:
    """Return random numbers in the range of pictures, of a type that pictures have."""
    dtype = np.dtype(random.choice(("uint8", "uint16", "float16", "float32", "float64")))
    high = 1.0 if dtype.kind == "f" else float(np.iinfo(dtype).max)
    return np.random.default_rng(random.randrange(2**32)).uniform(0, high, shape).astype(dtype)


def array_bytes(array: np.ndarray) -> bytes:
    """Return the content of a `.npy` file."""
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def _with_other_byte_order(array: np.ndarray) -> np.ndarray:
    return array.astype(array.dtype.newbyteorder())


def _in_a_larger_one(array: np.ndarray) -> np.ndarray:
    """Return a view of every third row, second column and second channel of a larger array."""
    larger = np.zeros([3 * array.shape[0], *(2 * side for side in array.shape[1:])], array.dtype)
    view = larger[tuple(slice(None, None, 3 if axis == 0 else 2) for axis in range(array.ndim))]
    view[...] = array
    return view


def _unaligned(array: np.ndarray) -> np.ndarray:
    """Return a copy at an odd address."""
    memory = np.zeros(array.nbytes + 1, np.uint8)
    view = memory[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


def _read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


VIEWS: tuple[Callable[[np.ndarray], np.ndarray], ...] = (
    lambda array: array[::-1],
    lambda array: array[:, ::-1],
    lambda array: array[..., ::-1],
    lambda array: array.swapaxes(0, 1),
    lambda array: array[::2, ::3],
    lambda array: np.broadcast_to(array[:1], array.shape),
    lambda array: np.broadcast_to(array[..., :1], array.shape),
    np.asfortranarray,
    _in_a_larger_one,
    _unaligned,
    _read_only,
    _with_other_byte_order,
    lambda array: _with_other_byte_order(array)[::-1, ::2],
    lambda array: np.lib.stride_tricks.sliding_window_view(array, 1, axis=0)[..., 0],
)
"""Functions that return an array with another memory layout."""


def to_native(array: np.ndarray) -> np.ndarray:
    """Return a contiguous copy in native byte order."""
    return np.ascontiguousarray(array).astype(array.dtype.newbyteorder("="))
