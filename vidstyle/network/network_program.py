"""Runs a network in a separate process, as a damaged file may crash the library that reads it.

The program reads requests from standard input and writes answers to standard output. A message is a header,
JSON after its length, and the numbers of an array.
"""

from __future__ import annotations

import json
import os
import struct
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

import numpy as np

THREADS_VARIABLE = "VIDSTYLE_NETWORK_THREADS"
"""The environment variable with the number of threads that a network may use."""
MAX_MEMORY_BYTES = 4 << 30
"""Maximum memory of the process, where the system can limit it."""
_MAX_HEADER_BYTES = 1 << 16

RunNetwork = Callable[[np.ndarray], np.ndarray]
"""Maps a batch of one picture, float32, to another."""


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
                    network = open_network(content, header["kind"])
                    send(answers, {})
                    continue
                assert network is not None
                result = network(np.frombuffer(content, np.float32).reshape(header["shape"]))
                result = np.ascontiguousarray(result, np.float32)
                send(answers, {"shape": result.shape}, result.tobytes())
            except Exception as error:  # libraries raise their own exceptions
                text = " ".join(str(error).split())
                send(answers, {"error": text[:200] or type(error).__name__})


def open_network(content: bytes, kind: str) -> RunNetwork:
    """Return the network of a file: of an ONNX file by onnxruntime if it is installed, else by OpenCV."""
    try:
        import onnxruntime
    except ImportError:
        return _open_with_opencv(content, kind)
    if kind != "onnx":
        return _open_with_opencv(content, kind)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = int(os.environ.get(THREADS_VARIABLE, "0"))
    options.log_severity_level = 4
    session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    name = session.get_inputs()[0].name
    return lambda picture: np.asarray(session.run(None, {name: picture})[0])


def _open_with_opencv(content: bytes, kind: str) -> RunNetwork:
    import cv2

    cv2.setNumThreads(int(os.environ.get(THREADS_VARIABLE, "-1")))
    read = cv2.dnn.readNetFromTFLite if kind == "tflite" else cv2.dnn.readNetFromONNX
    network = read(np.frombuffer(content, np.uint8))

    def run(picture: np.ndarray) -> np.ndarray:
        network.setInput(picture)
        return np.asarray(network.forward())

    return run


def _limit_memory() -> None:
    with suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))


if __name__ == "__main__":
    main()
