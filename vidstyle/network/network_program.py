"""Runs a network in a separate process, as a damaged file may crash the library that reads it.

The program reads requests from standard input and writes answers to standard output. A message is a header,
JSON after its length, and the numbers of an array.
"""

from __future__ import annotations

import json
import math
import os
import struct
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import IO, Any

import numpy as np

THREADS_VARIABLE = "VIDSTYLE_NETWORK_THREADS"
"""The environment variable with the number of threads that a network may use."""
MAX_MEMORY_BYTES = 4 << 30
"""Maximum memory of the process, where the system can limit it."""
_MAX_HEADER_BYTES = 1 << 16

MAX_STATE_BYTES = 256 << 20
"""Maximum size of all that a network remembers."""

RunNetwork = Callable[[np.ndarray, bool], np.ndarray]
"""Maps a batch of one picture, float32, to another; with True, earlier pictures are forgotten."""
RunNamed = Callable[[dict[str, np.ndarray], list[str]], list[np.ndarray]]
"""Maps inputs by name to the outputs with these names."""


def send(stream: IO[bytes], header: dict[str, Any], content: bytes | memoryview = b"") -> None:
    """Write a message."""
    text = json.dumps(header | {"bytes": len(content)}).encode()
    stream.write(struct.pack("<I", len(text)) + text)
    stream.write(content)
    stream.flush()


def receive(stream: IO[bytes], max_bytes: int) -> tuple[dict[str, Any], bytes]:
    """Read a message.

    Raises:
        EOFError: the stream has ended, or what it holds is no message.
    """
    (length,) = struct.unpack("<I", _read(stream, 4, 4))
    header: dict[str, Any] = json.loads(_read(stream, length, _MAX_HEADER_BYTES))
    return header, _read(stream, int(header["bytes"]), max_bytes)


def _read(stream: IO[bytes], size: int, max_bytes: int) -> bytes:
    content = stream.read(size) if 0 <= size <= max_bytes else b""
    if len(content) != size:
        raise EOFError
    return content


def main() -> None:
    """Answer requests until standard input ends."""
    # What a library prints must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    _limit_memory()
    network: RunNetwork | None = None
    with suppress(EOFError, KeyboardInterrupt, BrokenPipeError):
        while True:
            header, content = receive(sys.stdin.buffer, 1 << 40)
            try:
                if "shape" not in header:
                    network = open_network(content, header["kind"], header["ports"])
                    send(answers, {})
                    continue
                assert network is not None
                picture = np.frombuffer(content, np.float32).reshape(header["shape"])
                result = network(picture, header["is_first"])
                result = np.ascontiguousarray(result, np.float32)
                send(answers, {"shape": result.shape}, result.tobytes())
            except Exception as error:  # libraries raise their own exceptions
                text = " ".join(str(error).split())
                send(answers, {"error": text[:200] or type(error).__name__})


def open_network(content: bytes, kind: str, ports: dict[str, Any] | None = None) -> RunNetwork:
    """Return the network of a file: of an ONNX file by onnxruntime if it is installed, else by OpenCV.

    Args:
        content: of the file.
        kind: "onnx" or "tflite".
        ports: the attributes of `RecurrentPorts`, if the network remembers earlier pictures.
    """
    try:
        import onnxruntime
    except ImportError:
        return _open_with_opencv(content, kind, ports)
    if kind != "onnx":
        return _open_with_opencv(content, kind, ports)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = int(os.environ.get(THREADS_VARIABLE, "0"))
    options.log_severity_level = 4
    session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    if ports:
        return _RecurrentNetwork(lambda values, names: session.run(names, values), ports)
    name = session.get_inputs()[0].name
    return lambda picture, _: np.asarray(session.run(None, {name: picture})[0])


def _open_with_opencv(content: bytes, kind: str, ports: dict[str, Any] | None) -> RunNetwork:
    import cv2

    cv2.setNumThreads(int(os.environ.get(THREADS_VARIABLE, "-1")))
    read = cv2.dnn.readNetFromTFLite if kind == "tflite" else cv2.dnn.readNetFromONNX
    network = read(np.frombuffer(content, np.uint8))

    def run(picture: np.ndarray, _: bool) -> np.ndarray:
        network.setInput(picture)
        return np.asarray(network.forward())

    def run_named(values: dict[str, np.ndarray], names: list[str]) -> list[np.ndarray]:
        for name, value in values.items():
            network.setInput(value, name)
        return [np.array(each) for each in network.forward(names)]

    return _RecurrentNetwork(run_named, ports) if ports else run


class _RecurrentNetwork:
    """A network whose outputs are inputs for the next picture; the first ones are 0."""

    def __init__(self, run: RunNamed, ports: dict[str, Any]) -> None:
        self._run, self._ports = run, ports
        self._constants = {name: np.ones(shape, np.float32) for name, shape in ports["constants"].items()}
        self._states = dict[str, np.ndarray]()

    def __call__(self, picture: np.ndarray, is_first: bool) -> np.ndarray:
        """Run the network; see `RunNetwork`."""
        states: dict[str, tuple[list[int], str]] = self._ports["states"]
        if is_first or not self._states:
            # Free sizes are 1: the network extends the state to its own size.
            sizes = {name: [size or 1 for size in shape] for name, (shape, _) in states.items()}
            self._states = {name: np.zeros(_checked(name, size), np.float32) for name, size in sizes.items()}
        names = [self._ports["result"], *(output for _, output in states.values())]
        values = {self._ports["picture"]: picture, **self._constants, **self._states}
        result, *found = self._run(values, names)
        for (name, (shape, _)), state in zip(states.items(), found, strict=True):
            if len(shape) != state.ndim or any(a and a != b for a, b in zip(shape, state.shape, strict=True)):
                raise ValueError(f"returns {state.shape} for its input {name!r} of {tuple(shape)}")
            self._states[name] = np.ascontiguousarray(state, np.float32)
            _checked(name, state.shape)
        return result


def _checked(name: str, shape: Sequence[int]) -> Sequence[int]:
    """Return the shape of a state; raise ValueError if it is too large."""
    if 4 * math.prod(shape) > MAX_STATE_BYTES:
        raise ValueError(f"its input {name!r} is larger than {MAX_STATE_BYTES >> 20} MB")
    return shape


def _limit_memory() -> None:
    with suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))


if __name__ == "__main__":
    main()
