"""A network of a style: checked, tried, and run in another process."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import weakref
from collections import OrderedDict
from contextlib import suppress
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.machine.cores import available_cores
from vidstyle.network.network_program import THREADS_VARIABLE, receive, send
from vidstyle.network.onnx_file import MAX_FILE_BYTES, read_layout
from vidstyle.network.recurrent_ports import RecurrentPorts

MAX_SECONDS = 120.0
"""Time after which a network that has not answered is ended."""
MAX_KEPT_NETWORKS = 4
"""Number of networks whose processes are kept for the next use."""
TRIAL_SIDE_PX = 64
"""Side of the picture with which a network of any size is tried."""


class NetworkProcess:
    """A process that runs one network after another; it ends with this object."""

    def __init__(self) -> None:
        path = [each or os.curdir for each in sys.path]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(path),
            THREADS_VARIABLE: str(available_cores()),
        }
        command = [sys.executable, "-P", "-m", "vidstyle.network.network_program"]
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        # In a separate session, so that Ctrl-C ends the program before its networks.
        self._process = subprocess.Popen(command, env=environment, start_new_session=True, **pipes)
        self._lock = threading.Lock()
        self._end = weakref.finalize(self, _end_process, self._process)

    @property
    def is_running(self) -> bool:
        """Whether requests can be answered."""
        return self._end.alive

    def open(self, content: bytes, kind: str = "onnx", ports: RecurrentPorts | None = None) -> None:
        """Use the network of a file from now on.

        Args:
            content: of the file.
            kind: "onnx" or "tflite".
            ports: inputs and outputs of a network that remembers earlier pictures.

        Raises:
            ValueError: it cannot be read, or crashes the process.
        """
        self._ask({"kind": kind, "ports": ports and asdict(ports)}, content, 0)

    def run(self, batch: np.ndarray, is_first: bool = True) -> np.ndarray:
        """Return the network's result for a batch of pictures, float32.

        Args:
            batch: of one picture.
            is_first: whether to forget earlier pictures.

        Raises:
            ValueError: the network fails, or crashes the process.
        """
        request = {"shape": batch.shape, "is_first": is_first}
        header, content = self._ask(request, batch.tobytes(), 16 * batch.nbytes)
        return np.frombuffer(content, np.float32).reshape(header["shape"])

    def close(self) -> None:
        """End the process."""
        self._end()

    def _ask(
        self, header: dict[str, Any], content: bytes | memoryview, max_bytes: int
    ) -> tuple[dict[str, Any], bytes]:
        """Send a request, and return the answer, of at most `max_bytes`."""
        assert self._process.stdin and self._process.stdout
        timer = threading.Timer(MAX_SECONDS, self._process.kill)
        with self._lock:
            timer.start()
            try:
                send(self._process.stdin, header, content)
                answer, result = receive(self._process.stdout, max_bytes)
            except (EOFError, OSError, ValueError):
                self.close()
                raise ValueError("crashes the program that runs it, or takes too long") from None
            finally:
                timer.cancel()
        if "error" in answer:
            raise ValueError(f"cannot be run: {answer['error']}")
        return answer, result


class StyleNetwork:
    """Maps pictures to pictures in a separate process, which starts now.

    Attributes:
        layout: the pictures that it takes.
        process: runs it.
    """

    def __init__(self, content: bytes) -> None:
        """Check an ONNX file, and try it on a small picture.

        Raises:
            ValueError: it is damaged, or no network that maps an RGB picture to another of the same size.
        """
        self.layout = read_layout(content)
        self.process = NetworkProcess()
        self.process.open(content)
        shape = self.layout.height or TRIAL_SIDE_PX, self.layout.width or TRIAL_SIDE_PX
        self.run(np.full((*shape, 3), 0.5, np.float32))

    def run(self, picture: np.ndarray) -> np.ndarray:
        """Return the network's result for a picture, H x W x 3 float32, in its own range.

        Raises:
            ValueError: the network fails, or its result is no picture of the same size.
        """
        first = self.layout.channels_first
        batch = np.ascontiguousarray((picture.transpose(2, 0, 1) if first else picture)[None])
        result = self.process.run(batch)
        if result.shape != batch.shape:
            sizes = (" x ".join(map(str, shape)) for shape in (result.shape, batch.shape))
            raise ValueError("returns {} for a picture of {}".format(*sizes))
        if not np.isfinite(result).all():
            raise ValueError("returns numbers that are not finite")
        return result[0].transpose(1, 2, 0) if first else result[0]


_kept: OrderedDict[bytes, StyleNetwork] = OrderedDict()
_kept_lock = threading.Lock()


def open_network(path: Path) -> StyleNetwork:
    """Return the network in an ONNX file; the same one for the same content.

    Raises:
        ValueError: see `StyleNetwork`, or the file is larger than `MAX_FILE_BYTES`.
        OSError: the file cannot be read.
    """
    content = read_regular_file(path, MAX_FILE_BYTES)
    key = sha256(content).digest()
    with _kept_lock:
        if key not in _kept or not _kept[key].process.is_running:
            _kept[key] = StyleNetwork(content)
        _kept.move_to_end(key)
        while len(_kept) > MAX_KEPT_NETWORKS:
            _kept.popitem(last=False)
        return _kept[key]


def _end_process(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):
                pipe.close()
