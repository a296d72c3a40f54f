"""The memory of pictures while they are restyled: how many fit, and where their planes lie."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vidstyle.core.bands import ONE_THREAD, BandWorkers, band_rows
from vidstyle.core.kernels import aligned_empty
from vidstyle.core.kernels.aligned import CACHE_LINE_FLOATS, round_up
from vidstyle.core.machine.free_memory import frame_memory, memory_option
from vidstyle.core.picture import Encoding
from vidstyle.cpu.pixel_operations import Value
from vidstyle.cpu.scheduling.peak_memory import peak_bytes
from vidstyle.cpu.scheduling.sweeps import Schedule, Sweep
from vidstyle.errors import log
from vidstyle.style.nodes import Node, Shape

_CODEC_FRAMES = 120
"""Pictures that decoder, queues and encoder hold, measured with x264 at preset medium."""
_KEPT_FACTOR = 1.25
"""Memory that a thread keeps relative to `peak_bytes`. At least the measured growth of the process per
thread, for ink, comic, paint, watercolor and ascii at 720p to 4K."""

MAX_LEAD_SHARE = 0.5
"""Most additional rows of a plane, relative to its height, for which another one follows in its memory."""


def pictures_in_memory(
    schedule: Schedule, shape: Shape, target: Encoding, is_steady: bool, threads: int
) -> int:
    """Return how many pictures can be restyled at the same time, from 1 to `threads`.

    Args:
        shape: height and width of a picture.
        target: encoding of the result.
        is_steady: whether pictures are stabilized.
    """
    each = frame_bytes(schedule, shape, target, is_steady, ONE_THREAD)
    free = frame_memory() - _CODEC_FRAMES * _picture_bytes(shape, target)
    if free < each and memory_option() is not None:
        log.warning(
            "--memory: a frame of %dx%d takes about %d MB more; frames are restyled one at a time",
            *(shape[1], shape[0], (each - free) >> 20),
        )
    return max(1, min(threads, free // each))


def processes_in_memory(each: int, most: int) -> int:
    """Return how many processes that take `each` bytes can be started, from 0 to `most`."""
    return min(most, frame_memory() // each)


def frame_bytes(
    schedule: Schedule, shape: Shape, target: Encoding, is_steady: bool, workers: BandWorkers
) -> int:
    """Return about how many bytes restyling a picture takes; see `pictures_in_memory`."""
    planes = _picture_bytes(shape, target)
    # The source and the result; the stabilized source and result have twice the bits, the weights half.
    pictures = 2 * planes + (5 * planes if is_steady else 0)
    return int(_KEPT_FACTOR * (peak_bytes(schedule, shape, workers) + pictures))


def _picture_bytes(shape: Shape, encoding: Encoding) -> int:
    across, down = encoding.subsampling
    samples = shape[0] * shape[1] * (1 + 2 / (across * down))
    return int(samples * np.dtype(encoding.dtype).itemsize)


class PlaneMemory:
    """Makes the planes of one picture.

    One thread computes bands from the top on. A plane that lies some rows below the beginning of its memory
    then gives way to one at the beginning: what a band writes lies above all rows that it and later bands
    read.

    Args:
        workers: threads for the bands.
        successors: see `Schedule`.
    """

    def __init__(self, workers: BandWorkers, successors: Mapping[Node, tuple[Sweep, Node]]) -> None:
        self._workers, self._successors = workers, successors if workers.count == 1 else {}
        self._promised: dict[Node, np.ndarray] = {}

    def planes(self, sweep: Sweep) -> dict[Node, Value]:
        """Return new planes for the nodes that a sweep stores; the sweeps are in order."""
        return {node: self._planes_of(node) for node in sweep.stores}

    def _planes_of(self, node: Node) -> Value:
        height = node.shape[0]
        if node in self._promised:
            return self._promised.pop(node)
        if node.kind == "chroma":
            return aligned_empty(node.shape), aligned_empty(node.shape)
        sweep, successor = self._successors.get(node, (None, node))
        lead = height if sweep is None else self._lead(sweep)
        if lead > MAX_LEAD_SHARE * height:
            return self._empty(node, height)
        memory = self._empty(node, height + lead)
        self._promised[successor] = memory[:height]
        return memory[lead:]

    def _lead(self, sweep: Sweep) -> int:
        """Return the rows by which a plane lies below the one that a sweep stores in its memory."""
        rows = band_rows(self._workers, sweep.stores[0].shape, sweep.radius, sweep.channels)
        return round_up(rows + sweep.radius, CACHE_LINE_FLOATS)  # so that both planes are aligned

    @staticmethod
    def _empty(node: Node, rows: int) -> np.ndarray:
        return aligned_empty((rows, node.shape[1], *((3,) if node.kind == "color" else ())))
