"""Minimal networks as ONNX files that treat red as a face (like YuNet) or as people, and a classifier."""

from __future__ import annotations

import struct
from collections.abc import Iterable

import numpy as np
from media import photograph

STRIDES = (8, 16, 32)
FACE = 64
"""Side of the box around each red cell of the last stride, in pixels."""

_FLOAT, _INT64 = 1, 7


def red_finder() -> bytes:
    """Return a face detector as an ONNX file, whose scores are the redness of each cell."""
    nodes, tensors = list[bytes](), list[bytes]()
    outputs = []
    for stride in STRIDES:
        cells = f"cells_{stride}"
        sides = [stride, stride]
        nodes.append(_node("AveragePool", ["input"], cells, kernel_shape=sides, strides=sides))
        # Blue, green, red, 0..255; only the coarsest cells are ever sure.
        red = np.array([[-0.2, -0.2, 0.2]], np.float32)
        sure = -20.0 if stride == STRIDES[-1] else -1000.0
        size = np.log(FACE / stride)
        for name, weights, biases in (
            ("cls", red, [sure]),
            ("obj", red, [sure]),
            ("bbox", np.zeros((4, 3), np.float32), [0.5, 0.5, size, size]),
            ("kps", np.zeros((10, 3), np.float32), [0.0] * 10),
        ):
            output = f"{name}_{stride}"
            channels = len(weights)
            tensors.append(_tensor(f"{output}_w", weights.reshape(channels, 3, 1, 1)))
            tensors.append(_tensor(f"{output}_b", np.array(biases, np.float32)))
            tensors.append(_tensor(f"{output}_shape", np.array([1, -1, channels], np.int64)))
            nodes.append(_node("Conv", [cells, f"{output}_w", f"{output}_b"], f"{output}_raw"))
            scored = f"{output}_scored" if name in ("cls", "obj") else f"{output}_raw"
            if scored != f"{output}_raw":
                nodes.append(_node("Sigmoid", [f"{output}_raw"], scored))
            nodes.append(_node("Transpose", [scored], f"{output}_rows", perm=[0, 2, 3, 1]))
            nodes.append(_node("Reshape", [f"{output}_rows", f"{output}_shape"], output))
            outputs.append((output, [1, (64 // stride) ** 2, channels]))
    # YuNet's own order: all of one kind, then the next.
    outputs.sort(key=lambda each: ("cls", "obj", "bbox", "kps").index(each[0].split("_")[0]))
    return _model(b"red", nodes, tensors, ("input", [1, 3, 64, 64]), outputs)


def brightness_judge(classes: int) -> bytes:
    """Return a classifier of 1 x 3 x 224 x 224 input; the last classes are for bright pictures."""
    slopes = np.linspace(-2, 2, classes) if classes > 1 else np.ones(1)
    weights = np.repeat(slopes[:, None], 3, 1).astype(np.float32)
    nodes = [
        _node("AveragePool", ["picture"], "mean", kernel_shape=[224, 224], strides=[224, 224]),
        _node("Conv", ["mean", "weights", "biases"], "raw"),
        _node("Sigmoid", ["raw"], "shares"),
    ]
    tensors = [
        _tensor("weights", weights.reshape(classes, 3, 1, 1)),
        _tensor("biases", np.zeros(classes, np.float32)),
    ]
    return _model(b"judge", nodes, tensors, ("picture", [1, 3, 224, 224]), [("shares", [1, classes, 1, 1])])


def red_people(size: tuple[int, int] = (256, 144)) -> bytes:
    """Return a model with a high probability of people for red pixels; `size` is (width, height)."""
    tensors = [
        _tensor("weights", np.array([20, -10, -10], np.float32).reshape(1, 3, 1, 1)),
        _tensor("biases", np.array([-8], np.float32)),
    ]
    nodes = [_node("Conv", ["picture", "weights", "biases"], "raw"), _node("Sigmoid", ["raw"], "people")]
    shape = [1, 3, *size[::-1]]
    return _model(b"people", nodes, tensors, ("picture", shape), [("people", [1, 1, *size[::-1]])])


def remembering_people(
    state: tuple[str, str] = ("r1i", "r1o"),
    result: str = "pha",
    size: tuple[int, int] = (256, 144),
    state_shape: list[int] | None = None,
) -> bytes:
    """Return a model like `red_people` that adds half of its previous result, like video matting networks.

    Args:
        state: names of the input and output of what it remembers.
        result: name of the probability of people.
        size: width and height.
        state_shape: the shape of the state that it declares; None: 1 x 1 x height x width.
    """
    shape = [1, 1, *size[::-1]]
    tensors = [
        _tensor("weights", np.array([20, -10, -10], np.float32).reshape(1, 3, 1, 1)),
        _tensor("biases", np.array([-8], np.float32)),
        _tensor("half", np.full((1, 1, 1, 1), 0.5, np.float32)),
    ]
    nodes = [
        _node("Conv", ["src", "weights", "biases"], "raw"),
        _node("Sigmoid", ["raw"], "now"),
        _node("Add", ["now", state[0]], "sum"),
        _node("Mul", ["sum", "scale"], "scaled"),
        _node("Mul", ["scaled", "half"], result),
        _node("Identity", [result], state[1]),
    ]
    inputs = [("src", [1, 3, *size[::-1]]), (state[0], state_shape or shape), ("scale", [1])]
    return _model(b"matting", nodes, tensors, inputs, [(result, shape), (state[1], shape)])


def _model(
    name: bytes,
    nodes: list[bytes],
    tensors: list[bytes],
    given: tuple[str, list[int]] | list[tuple[str, list[int]]],
    outputs: list[tuple[str, list[int]]],
) -> bytes:
    graph = [_field(1, node) for node in nodes] + [_field(2, name)] + [_field(5, each) for each in tensors]
    graph += [_field(11, _value(*each)) for each in (given if isinstance(given, list) else [given])]
    graph += [_field(12, _value(*each)) for each in outputs]
    return _field(1, 7) + _field(8, _field(1, b"") + _field(2, 11)) + _field(7, b"".join(graph))


def _node(kind: str, inputs: Iterable[str], output: str, **numbers: list[int]) -> bytes:
    parts = [_field(1, each.encode()) for each in inputs] + [_field(2, output.encode())]
    parts += [_field(3, f"{kind} {output}".encode()), _field(4, kind.encode())]
    for name, values in numbers.items():
        ints = b"".join(_field(8, value) for value in values)
        parts.append(_field(5, _field(1, name.encode()) + ints + _field(20, 7)))
    return b"".join(parts)


def _tensor(name: str, array: np.ndarray) -> bytes:
    kind = _FLOAT if array.dtype == np.float32 else _INT64
    sides = b"".join(_field(1, side) for side in array.shape)
    return sides + _field(2, kind) + _field(8, name.encode()) + _field(9, array.tobytes())


def _value(name: str, shape: list[int]) -> bytes:
    sides = b"".join(_field(1, _field(1, side)) for side in shape)
    return _field(1, name.encode()) + _field(2, _field(1, _field(1, _FLOAT) + _field(2, sides)))


def _field(number: int, value: int | bytes) -> bytes:
    """Encode a field of a protocol buffer."""
    if isinstance(value, int):
        return _varint(number << 3) + _varint(value)
    return _varint(number << 3 | 2) + _varint(len(value)) + value


def _varint(value: int) -> bytes:
    parts = bytearray()
    while value > 127:
        parts.append(value & 127 | 128)
        value >>= 7
    return struct.pack(f"{len(parts) + 1}B", *parts, value)


def gray_and_red() -> np.ndarray:
    """Return a gray photograph whose right half is red."""
    color = np.repeat(photograph()[:144, :256, 1:2], 3, axis=2)
    color[:, 128:] = 250, 10, 10
    return color
