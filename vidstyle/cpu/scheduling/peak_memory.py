"""The most memory that a picture takes at once while it is restyled."""

from __future__ import annotations

from collections.abc import Mapping

from vidstyle.core.bands import BandWorkers, band_rows
from vidstyle.core.resample import Resampling
from vidstyle.cpu.scheduling.sweeps import BandStep, Schedule, Sweep, plane_bytes
from vidstyle.style.nodes import Node, Shape


def peak_bytes(schedule: Schedule, shape: Shape, workers: BandWorkers) -> int:
    """Return the most bytes of stored planes and bands at once, for a picture of this height and width."""
    most = 0
    for sweep, stored in schedule.sweeps():
        page = sweep.stores[0].shape if sweep.stores else shape
        if sweep.steps:
            rows = min(band_rows(workers, page, sweep.radius, sweep.channels), page[0])
            bands = workers.count * _band_bytes(sweep, rows, schedule.recomputed)
            most = max(most, sum(map(plane_bytes, stored)) + bands)
    return most


def _band_bytes(sweep: Sweep, rows: int, recomputed: Mapping[Node, Sweep]) -> int:
    """Return the most bytes of the values of a band at once."""
    values: dict[object, int] = {}
    most = 0
    for step in sweep.steps:
        high = min(rows + 2 * step.margin, step.node.shape[0])
        again = [node for node in step.loads if node in recomputed]
        for node in again:
            inner = _band_bytes(recomputed[node], _rows_loaded(step, node, high), recomputed)
            most = max(most, sum(values.values()) + inner)
        if again or not step.is_loaded:
            for node in filter(None, (step.node, step.twin)):
                values[node, step.margin] = plane_bytes(node, high)
        most = max(most, sum(values.values()))
        for key in step.releases:
            values.pop(key, None)
    return most


def _rows_loaded(step: BandStep, node: Node, rows: int) -> int:
    """Return how many rows of a node a step loads to compute `rows` rows, far from the edges."""
    if step.is_loaded:
        return rows
    if step.node.op == "network":
        return node.shape[0]
    top = (step.node.shape[0] - rows) // 2
    first, last = Resampling(node.shape, step.node.shape, **step.node.values).rows_read(top, top + rows)
    return last - first
