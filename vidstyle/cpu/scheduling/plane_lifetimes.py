"""When planes are read for the last time, and which planes can follow in their memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from vidstyle.cpu.scheduling.sweeps import Sweep, Task
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
        loaded = {step.node for step in task.steps if step.is_loaded}
        banded = loaded - set(_read_elsewhere(task, recomputed)) - followers
        free = [node for node in releases if node in banded and not node.is_given and node.kind != "chroma"]
        for node in task.stores:
            alike = (each for each in free if (each.kind, each.shape) == (node.kind, node.shape))
            if (before := next(alike, None)) is not None and before not in found:
                found[before] = task, node
                free.remove(before)
    return found


def _read_elsewhere(sweep: Sweep, recomputed: Mapping[Node, Sweep]) -> Iterator[Node]:
    """Yield the nodes whose planes a sweep may read in other rows than those around its band."""
    for step in sweep.steps:
        for node in step.loads:
            if not step.is_loaded or node in recomputed:
                yield from _planes_behind(node, recomputed)


def planes_read(task: Task, recomputed: Mapping[Node, Sweep]) -> Iterator[Node]:
    """Yield the nodes whose planes a task reads."""
    if isinstance(task, PercentileRequest):
        yield from nodes_in_order([task.of])
        return
    for step in task.steps:
        for node in step.loads:
            yield from _planes_behind(node, recomputed)


def _planes_behind(node: Node, recomputed: Mapping[Node, Sweep]) -> Iterator[Node]:
    """Yield the node itself, or the nodes from whose planes it is recomputed."""
    if node in recomputed:
        yield from planes_read(recomputed[node], recomputed)
    else:
        yield node
