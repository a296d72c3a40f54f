"""ONNX files of small networks, encoded without the onnx package."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

FLOAT, INTS, INT = 1, 7, 2
"""ONNX codes of the type of tensors and of the types of attributes."""


def field(number: int, value: int | bytes | str) -> bytes:
    """Encode a field of a protocol buffer."""
    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    content = value.encode() if isinstance(value, str) else value
    return varint(number << 3 | 2) + varint(len(content)) + content


def varint(value: int) -> bytes:
    parts = []
    while value > 127:
        parts.append(value & 127 | 128)
        value >>= 7
    return bytes([*parts, value])


def tensor(name: str, values: np.ndarray) -> bytes:
    dims = b"".join(field(1, size) for size in values.shape)
    return dims + field(2, FLOAT) + field(8, name) + field(9, values.astype("<f4").tobytes())


def picture_info(name: str, shape: Sequence[int | str], kind: int = FLOAT) -> bytes:
    """Encode a `ValueInfoProto`; free sizes have names."""
    sizes = b"".join(field(1, field(1 if isinstance(size, int) else 2, size)) for size in shape)
    return field(1, name) + field(2, field(1, field(1, kind) + field(2, sizes)))


def node(kind: str, inputs: Sequence[str], output: str, **attributes: Sequence[int]) -> bytes:
    content = b"".join(field(1, name) for name in inputs) + field(2, output) + field(4, kind)
    for name, values in attributes.items():
        ints = b"".join(field(8, value) for value in values)
        content += field(5, field(1, name) + ints + field(20, INTS))
    return content


def model(nodes: Sequence[bytes], weights: Sequence[bytes], inputs: Sequence[bytes], out: bytes) -> bytes:
    graph = b"".join(field(1, each) for each in nodes) + field(2, "style")
    graph += b"".join(field(5, each) for each in weights)
    graph += b"".join(field(11, each) for each in inputs) + field(12, out)
    return field(1, 7) + field(7, graph) + field(8, field(2, 13))


def convolution(
    kernel: np.ndarray,
    offsets: Sequence[float],
    shape: Sequence[int | str] = (1, 3, "height", "width"),
    padding: int | None = None,
) -> bytes:
    """Return a network of one convolution with a kernel of outputs x inputs x rows x columns."""
    pads = [kernel.shape[2] // 2 if padding is None else padding] * 4
    conv = node("Conv", ["in", "kernel", "offsets"], "out", kernel_shape=kernel.shape[2:], pads=pads)
    weights = [tensor("kernel", kernel), tensor("offsets", np.array(offsets))]
    return model([conv], weights, [picture_info("in", shape)], picture_info("out", shape))


def layered(channels: int = 16, layers: int = 3) -> bytes:
    """Return a network of convolutions with rectifiers, like style networks."""
    random, nodes, weights = np.random.default_rng(2), [], []
    counts, name = [3, *[channels] * (layers - 1), 3], "in"
    for number, (before, after) in enumerate(zip(counts, counts[1:], strict=False)):
        kernel = random.normal(0, 1 / (3 * before**0.5), (after, before, 3, 3))
        weights += [tensor(f"kernel{number}", kernel), tensor(f"offsets{number}", np.zeros(after))]
        inputs = [name, f"kernel{number}", f"offsets{number}"]
        nodes.append(node("Conv", inputs, f"sum{number}", kernel_shape=[3, 3], pads=[1] * 4))
        nodes.append(node("Relu", [f"sum{number}"], name := f"value{number}"))
    shape = (1, 3, "height", "width")
    return model(nodes, weights, [picture_info("in", shape)], picture_info(name, shape))


def negative(white: float = 255.0) -> bytes:
    """Return a network that inverts pictures."""
    return convolution(-np.eye(3).reshape(3, 3, 1, 1), [white] * 3)
