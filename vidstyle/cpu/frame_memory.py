"""How many pictures fit into memory while they are restyled."""

from __future__ import annotations

import numpy as np

from vidstyle.core.bands import ONE_THREAD, BandWorkers, band_rows
from vidstyle.core.machine.free_memory import frame_memory, memory_option
from vidstyle.core.picture import Encoding
from vidstyle.cpu.schedule import Schedule, Sweep
from vidstyle.errors import log
from vidstyle.style.limits import CHANNELS
from vidstyle.style.nodes import Node, PercentileRequest, Shape

_CODEC_FRAMES = 120
"""Pictures that decoder, queues and encoder hold, measured with x264 at preset medium."""
_FLOAT_BYTES = 4
_KEPT_FACTOR = 1.25
"""Memory that a thread keeps relative to `_peak_bytes`. At least the measured growth of the process per
thread, for ink, comic, paint, watercolor and ascii at 720p to 4K."""


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
    free = frame_memory() - _CODEC_FRAMES * _plane_bytes(shape, target)
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
    planes = _plane_bytes(shape, target)
    # The source and the result; the stabilized source and result have twice the bits, the weights half.
    pictures = 2 * planes + (5 * planes if is_steady else 0)
    return int(_KEPT_FACTOR * (_peak_bytes(schedule, shape, workers) + pictures))


def _plane_bytes(shape: Shape, encoding: Encoding) -> int:
    across, down = encoding.subsampling
    samples = shape[0] * shape[1] * (1 + 2 / (across * down))
    return int(samples * np.dtype(encoding.dtype).itemsize)


def _peak_bytes(schedule: Schedule, shape: Shape, workers: BandWorkers) -> int:
    """Return the most bytes of stored planes and bands at once."""
    stored: dict[Node, int] = {}
    most = 0
    for task, releases in [*schedule.tasks, (schedule.output, ())]:
        if not isinstance(task, PercentileRequest) and task.steps:
            stored |= {node: _float_bytes(node, node.shape[0]) for node in task.stores}
            page = task.stores[0].shape if task.stores else shape
            most = max(most, sum(stored.values()) + _band_bytes(task, page, workers))
        for node in releases:
            stored.pop(node, None)
    return most


def _band_bytes(sweep: Sweep, page: Shape, workers: BandWorkers) -> int:
    """Return the most bytes of the values of bands at once, in all threads."""
    rows = min(band_rows(workers, page, sweep.radius, sweep.channels), page[0])
    values: dict[object, int] = {}
    most = 0
    for step in sweep.steps:
        if not step.is_loaded:
            for node in filter(None, (step.node, step.twin)):
                values[node, step.margin] = _float_bytes(node, min(rows + 2 * step.margin, node.shape[0]))
        most = max(most, sum(values.values()))
        for key in step.releases:
            values.pop(key, None)
    return workers.count * most


def _float_bytes(node: Node, rows: int) -> int:
    return _FLOAT_BYTES * CHANNELS[node.kind] * rows * node.shape[1]
