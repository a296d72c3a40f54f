"""Reads from an ONNX file what its pictures are, and refuses what no style needs.

Only the fields that are needed are decoded, by the wire format of Protocol Buffers; their numbers are those
of onnx.proto3. Everything else is left to the library that runs the network, in another process.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import count

MAX_FILE_BYTES = 256 << 20
"""Networks of styles have 1 to 50 MB."""
MIN_SIDE_PX, MAX_SIDE_PX = 32, 4096
"""Sides of the pictures of a network with a fixed size."""
_MAX_DEPTH = 8
"""Maximum number of graphs inside one another."""
MAX_FIELDS = 1_000_000
"""Networks of styles have some thousands; a second's work."""
_FLOAT_TYPE_CODE = 1
"""The type of 32-bit floats in TensorProto.DataType."""


@dataclass(frozen=True)
class _Message:
    """Bytes of a field, as of a message; `places` counts the fields of the whole file."""

    content: memoryview
    places: Iterator[int]


_Value = int | _Message | None
"""The value of a field: a number or a message; None where it is absent."""


@dataclass(frozen=True)
class NetworkLayout:
    """What pictures a network takes and returns.

    Attributes:
        channels_first: whether an array is 1 x 3 x H x W; else 1 x H x W x 3.
        height, width: in pixels; 0: any.
    """

    channels_first: bool
    height: int
    width: int


@dataclass(frozen=True)
class Port:
    """An input or output; the sizes in its shape are 0 where they are free.

    An output without a known shape of floats has none.
    """

    name: str
    shape: tuple[int, ...]


def read_ports(content: bytes) -> tuple[list[Port], list[Port]]:
    """Return the inputs and outputs of a network.

    Raises:
        ValueError: the content is no ONNX file, refers to other files, or takes other numbers than floats.
    """
    try:
        graph = _last(_fields(_Message(memoryview(content), count())), 7)
        inputs, outputs = _ports(graph)
        return [Port(_name(each), tuple(_shape(each))) for each in inputs], [*map(_output_port, outputs)]
    except (IndexError, UnicodeDecodeError):
        raise ValueError("is not an ONNX file") from None


def read_layout(content: bytes) -> NetworkLayout:
    """Return the layout of a network that maps one RGB picture to another.

    Raises:
        ValueError: the content is no ONNX file, refers to other files, or is another kind of network.
    """
    try:
        return _layout(_input_shape(_last(_fields(_Message(memoryview(content), count())), 7)))
    except IndexError:
        raise ValueError("is not an ONNX file") from None


def _input_shape(graph: _Value) -> list[int]:
    """Return the shape of the only input of a graph; 0 for a free size."""
    inputs, outputs = _ports(graph)
    if len(inputs) != 1 or len(outputs) != 1:
        raise ValueError(f"has {len(inputs)} inputs and {len(outputs)} outputs; a style needs one of each")
    return _shape(inputs[0])


def _ports(graph: _Value) -> tuple[list[_Value], list[_Value]]:
    """Return the inputs of a graph that are no weights, and its outputs."""
    _refuse_other_files(graph, 0)
    fields = list(_fields(graph))
    weights = {_text(each, 8) for number, each in fields if number == 5}
    inputs = [each for number, each in fields if number == 11 and _text(each, 1) not in weights]
    return list(inputs), [each for number, each in fields if number == 12]


def _name(value: _Value) -> str:
    return _text(value, 1).decode()


def _output_port(value: _Value) -> Port:
    shape: list[int] = []
    with suppress(ValueError, IndexError):
        shape = _shape(value)
    return Port(_name(value), tuple(shape))


def _layout(shape: list[int]) -> NetworkLayout:
    """Return the layout for the shape of the input; sizes of 0 are free."""
    if len(shape) == 4 and shape[0] in (0, 1) and 3 in (shape[1], shape[3]):
        channels_first = shape[1] == 3
        height, width = shape[2:] if channels_first else shape[1:3]
        if all(side == 0 or MIN_SIDE_PX <= side <= MAX_SIDE_PX for side in (height, width)):
            return NetworkLayout(channels_first, height, width)
    sizes = " x ".join(str(size) if size else "?" for size in shape) or "unknown shape"
    wanted = f"1 x 3 x H x W or 1 x H x W x 3, of {MIN_SIDE_PX} to {MAX_SIDE_PX} pixels"
    raise ValueError(f"takes {sizes} instead of a picture: {wanted}")


def _shape(value: _Value) -> list[int]:
    """Return the shape of an input of floats; 0 for a free size."""
    tensor = _last(_fields(_last(_fields(value), 2)), 1)
    kind, shape = _last(_fields(tensor), 1), _last(_fields(tensor), 2)
    if kind != _FLOAT_TYPE_CODE:
        raise ValueError("takes numbers other than 32-bit floats")
    sizes = (_last(_fields(size), 1) for number, size in _fields(shape) if number == 1)
    return [size if isinstance(size, int) else 0 for size in sizes]


def _refuse_other_files(graph: _Value, depth: int) -> None:
    """Refuse tensors whose data is in another file."""
    if depth > _MAX_DEPTH:
        raise ValueError(f"has more than {_MAX_DEPTH} graphs inside one another")
    for number, value in _fields(graph):
        if number == 5:
            _refuse_other_file(value)
        elif number == 15:
            for _, part in _fields(value):
                if isinstance(part, _Message):
                    _refuse_other_file(part)
        elif number == 1:
            for name, attribute in _fields(value):
                if name == 5:
                    _check_attribute(attribute, depth)


def _check_attribute(attribute: _Value, depth: int) -> None:
    for number, value in _fields(attribute):
        if number in (5, 10):
            _refuse_other_file(value)
        elif number in (6, 11):
            _refuse_other_files(value, depth + 1)


def _refuse_other_file(tensor: _Value) -> None:
    if any(number == 13 or (number == 14 and value) for number, value in _fields(tensor)):
        raise ValueError("keeps its weights in another file; a style needs them in one file")


def _fields(value: _Value) -> Iterator[tuple[int, int | _Message]]:
    """Yield numbers and values of the fields of a message; 0 for values of fixed width, which are not used.

    Raises:
        IndexError: it is no message, or is cut off.
        ValueError: the file has too many fields.
    """
    if not isinstance(value, _Message):
        raise IndexError
    message, place = value.content, 0
    while place < len(message):
        if next(value.places) >= MAX_FIELDS:
            raise ValueError(f"has more than {MAX_FIELDS:,} fields; a network of a style has some thousands")
        key, place = _varint(message, place)
        field: int | _Message = 0
        match key & 7:
            case 0:
                field, place = _varint(message, place)
            case 1:
                place += 8
            case 5:
                place += 4
            case 2:
                size, place = _varint(message, place)
                field, place = _Message(message[place : place + size], value.places), place + size
            case _:
                raise IndexError
        if place > len(message):
            raise IndexError
        yield key >> 3, field


def _varint(message: memoryview, place: int) -> tuple[int, int]:
    """Return the number at a place, and the place after it."""
    value = 0
    for shift in range(0, 70, 7):
        byte = message[place]
        place += 1
        value |= (byte & 127) << shift
        if byte < 128:
            return value, place
    raise IndexError


def _last(fields: Iterator[tuple[int, int | _Message]], wanted: int) -> _Value:
    """Return the value of a field; the last one counts, as in Protocol Buffers."""
    found: _Value = None
    for number, value in fields:
        found = value if number == wanted else found
    return found


def _text(message: _Value, wanted: int) -> bytes:
    value = _last(_fields(message), wanted)
    return bytes(value.content) if isinstance(value, _Message) else b""
