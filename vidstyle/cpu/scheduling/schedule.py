"""Schedules nodes of a lowered style: which are computed together in bands, and which are stored as planes.

A compact schedule, for styles that would store large planes, stores fewer: it computes RGB again that
per-pixel operations compute from less data, and the rows next to a band that small filters read.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from vidstyle.core.bands import ONE_THREAD
from vidstyle.cpu.scheduling.peak_memory import peak_bytes
from vidstyle.cpu.scheduling.plane_lifetimes import planes_read, successors
from vidstyle.cpu.scheduling.stored_nodes import CONVERSION_OPERATIONS, needed_whole, recomputable
from vidstyle.cpu.scheduling.sweep_builder import SweepBuilder
from vidstyle.cpu.scheduling.sweeps import Schedule, Sweep, Task
from vidstyle.style.nodes import LoweredStyle, Node, nodes_in_order

MAX_STORED_BYTES_PER_PIXEL = 20
"""Most bytes per pixel that planes may take at once without a compact schedule. Of the shipped styles, `oil`
takes 39, `pixel` 34, `neon` 26, `blueprint` 25, `riso` 24, `impressionist` and `pointillist` 23."""
MAX_COMPACT_RATIO = 0.85
"""Most bytes that planes and bands of a compact schedule may take at once, relative to the usual schedule:
fewer planes are stored, but a band has more values.

At 1920x1080, `oil`, `pixel`, `neon` and `pointillist` take 0.44 to 0.82, `impressionist` 1, and `cartoon` and
`blueprint` 1.6 and 1.8.
"""
MAX_FUSED_RADIUS = 1
"""Greatest radius of filters whose inputs a compact schedule computes in the same sweep."""


def schedule(lowered: LoweredStyle, kept: Sequence[Node] = ()) -> Schedule:
    """Schedule a lowered style. Nodes that several sweeps would compute are stored by the first.

    Args:
        kept: additional nodes whose planes are requested (`FrameExecutor.planes`); the schedule is then not
            compact, as these planes take most of the memory.
    """
    usual, shape = _scheduled(lowered, kept, is_compact=False), lowered.source.shape
    if kept or usual.stored_bytes <= MAX_STORED_BYTES_PER_PIXEL * math.prod(shape):
        return usual
    compact = _scheduled(lowered, (), is_compact=True)
    most, fewest = (peak_bytes(each, shape, ONE_THREAD) for each in (usual, compact))
    return compact if fewest <= MAX_COMPACT_RATIO * most else usual


def _scheduled(lowered: LoweredStyle, kept: Sequence[Node], is_compact: bool) -> Schedule:
    whole = needed_whole([*lowered.outputs, *kept], MAX_FUSED_RADIUS if is_compact else 0) | set(kept)
    repeated: set[Node] = set()
    while True:
        recomputed = recomputable(lowered, whole) if is_compact else set()
        scheduler = _Scheduler(lowered, whole, repeated, kept, recomputed)
        more = scheduler.computed_twice()
        if not more:
            return scheduler.schedule()
        # A sweep may only compute them with margins, and then does not store them.
        whole |= more if is_compact else {node for node in more if node.op == "resample" or node in repeated}
        repeated |= more


class _Scheduler:
    """One attempt at a schedule.

    Args:
        whole: nodes that each get a sweep.
        repeated: nodes that are also stored by the first sweep that computes them.
        kept: nodes that are never released.
        recomputed: nodes of `whole` that are not stored.
    """

    def __init__(
        self,
        lowered: LoweredStyle,
        whole: set[Node],
        repeated: set[Node],
        kept: Sequence[Node],
        recomputed: set[Node],
    ) -> None:
        nodes = nodes_in_order([*lowered.outputs, *kept])
        self._stores, self._kept = (whole | repeated) - recomputed, kept
        self._done = {node for node in nodes if node.is_given}
        self._tasks: list[Task] = []
        self._recomputed: dict[Node, Sweep] = {}
        for node in nodes:
            if node.measure is not None and node.measure not in self._tasks:
                self._tasks.append(node.measure)
            if node in recomputed:
                self._recomputed[node] = self._sweep([node])
                self._done.add(node)
            elif node in whole - self._done:
                self._tasks.append(self._sweep([node]))
        self._output = self._sweep(_results(lowered, self._stores), is_output=True)

    def schedule(self) -> Schedule:
        """Return the tasks, and the nodes that each releases."""
        last = {
            node: number
            for number, task in enumerate([*self._tasks, self._output])
            for node in planes_read(task, self._recomputed)
        }
        tasks = tuple(
            (task, tuple(node for node, end in last.items() if end == number and node not in self._kept))
            for number, task in enumerate(self._tasks)
        )
        return Schedule(tasks, self._output, successors(tasks, self._recomputed), self._recomputed)

    def computed_twice(self) -> set[Node]:
        """Return nodes that several sweeps compute, except conversions and nodes read only by such nodes."""
        sweeps = [each for each in (*self._tasks, self._output) if isinstance(each, Sweep)]
        computed = Counter(step.node for each in sweeps for step in each.steps if not step.is_loaded)
        twice = {
            node
            for node, count in computed.items()
            if count > 1 and node.inputs and node.op not in CONVERSION_OPERATIONS
        }
        return twice - {other for node in twice for other in node.inputs.values()}

    def _sweep(self, roots: Sequence[Node], is_output: bool = False) -> Sweep:
        sweep = SweepBuilder(roots, self._done, self._stores, is_output).sweep()
        self._done |= set(sweep.stores)
        return sweep


def _results(lowered: LoweredStyle, stored: set[Node]) -> list[Node]:
    """Return the results of the last sweep; RGB if luma and chroma are only converted from it."""
    luma = None if lowered.luma_untouched else lowered.luma
    chroma = lowered.chroma if lowered.chroma and not lowered.chroma.grid else None
    if luma and chroma and {luma.op, chroma.op} == {"luma_from_rgb", "chroma_from_rgb"}:
        color = luma.inputs["color"]
        if color is chroma.inputs["color"] and not {luma, chroma} & stored:
            return [color]
    return [node for node in (lowered.color, luma, chroma) if node]
