"""The inputs and outputs of a network that remembers earlier pictures, such as a video matting network."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from vidstyle.network.onnx_file import Port, read_ports

NEXT_NAMES = (r"i$", "o"), (r"in$", "out"), (r"input", "output"), (r"past", "present"), (r"prev", "next")
"""Parts of the name of a state, and their replacements in the name of its output: r1i, r1o."""
RESULT_NAMES = "pha", "alpha", "mask"
"""Names that mark the result where several outputs have one or two planes."""


@dataclass(frozen=True)
class RecurrentPorts:
    """Names of the inputs and outputs of a network.

    Attributes:
        picture: the input of the picture, of `shape`, 1 x 3 x H x W; 0 for a free size.
        result: the output of the result.
        states: for each input of a state, its shape with 0 for a free size, and the output of its next value.
        constants: shapes of the inputs of single numbers, which are 1, such as scales.
    """

    picture: str
    shape: tuple[int, ...]
    result: str
    states: dict[str, tuple[tuple[int, ...], str]]
    constants: dict[str, tuple[int, ...]]


def recurrent_ports(content: bytes) -> RecurrentPorts | None:
    """Return the inputs and outputs of an ONNX file; None if it takes only a picture.

    Raises:
        ValueError: it is no ONNX file, or an input or output has no known meaning.
    """
    inputs, outputs = read_ports(content)
    if len(inputs) == 1:
        return None
    pictures = [each for each in inputs if len(each.shape) == 4 and each.shape[1] == 3]
    if len(pictures) != 1:
        raise ValueError(f"has {len(pictures)} inputs of 1 x 3 x H x W among its {len(inputs)} inputs")
    constants = [each for each in inputs if each.shape in ((), (1,))]
    states = {
        each.name: (each.shape, _next_name(each.name, outputs))
        for each in inputs
        if each not in (*pictures, *constants)
    }
    taken = {name for _, name in states.values()}
    result = _result_name([each for each in outputs if each.name not in taken])
    shapes = {each.name: each.shape for each in constants}
    return RecurrentPorts(pictures[0].name, pictures[0].shape, result, states, shapes)


def _next_name(name: str, outputs: Sequence[Port]) -> str:
    """Return the name of the output with the next value of a state."""
    names = {re.sub(*change, name) for change in NEXT_NAMES} - {name}
    found = [each.name for each in outputs if each.name in names]
    if len(found) != 1:
        raise ValueError(f"has no output for the next value of its input {name[:40]!r}, as r1o is for r1i")
    return found[0]


def _result_name(outputs: Sequence[Port]) -> str:
    """Return the name of the output with one or two planes."""
    planes = [
        each.name
        for each in outputs
        if not each.shape or (len(each.shape) == 4 and each.shape[1] in (0, 1, 2))
    ]
    named = [name for name in planes if name in RESULT_NAMES]
    if len(planes) != 1 and len(named) != 1:
        raise ValueError(f"has {len(planes)} outputs of one or two planes; name one of them alpha")
    return (named or planes)[0]
