"""When planes are read for the last time, and which planes can follow in their memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from vidstyle.cpu.scheduling.sweeps import READS_PLANES, Sweep, Task
from vidstyle.style.nodes import Node, PercentileRequest, nodes_in_order


def successors(
    tasks: Iterable[tuple[Task, tuple[Node, ...]]], recomputed: Mapping[Node, Sweep]
) -> dict[Node, tuple[Sweep, Node]]:
    """Return `Schedule.successors`. No plane follows one that follows another."""
    found: dict[Node, tuple[Sweep, Node]] = {}
    for task, releases in tasks:
        if isinstance(task, PercentileRequest):
            continue
        followers = {node for _, node in found.values()}
        loaded, whole = {step.node for step in task.steps if step.is_loaded}, _read_whole(task, recomputed)
        banded = loaded - set(whole) - followers
        free = [node for node in releases if node in banded and not node.is_given and node.kind != "chroma"]
        for node in task.stores:
            alike = (each for each in free if (each.kind, each.shape) == (node.kind, node.shape))
            if (before := next(alike, None)) is not None and before not in found:
                found[before] = task, node
                free.remove(before)
    return found


def _read_whole(sweep: Sweep, recomputed: Mapping[Node, Sweep]) -> Iterator[Node]:
    """Yield the nodes of which a sweep may read other rows than those around its band."""
    for step in sweep.steps:
        if step.is_loaded and step.node in recomputed:
            yield from _read_whole(recomputed[step.node], recomputed)
        elif not step.is_loaded and step.node.op in READS_PLANES:
            for image in step.node.inputs.values():
                yield from planes_read(recomputed[image], recomputed) if image in recomputed else [image]


def planes_read(task: Task, recomputed: Mapping[Node, Sweep]) -> Iterator[Node]:
    """Yield the nodes whose planes a task reads."""
    if isinstance(task, PercentileRequest):
        yield from nodes_in_order([task.of])
        return
    for step in task.steps:
        if step.is_loaded and step.node in recomputed:
            yield from planes_read(recomputed[step.node], recomputed)
        elif step.is_loaded:
            yield step.node
    yield from _read_whole(task, recomputed)
