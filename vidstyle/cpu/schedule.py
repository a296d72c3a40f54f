"""Which nodes of a lowered style are computed together in bands of rows, and which are kept as whole planes.

A sweep computes nodes band by band, on all cores, so that a band stays in a core's cache from the first node
to the last. A neighborhood operation reads rows around its band: what it reads is stored as whole planes
first, and the per-pixel operations after it run in the same sweep. Conversions between RGB and luma with
chroma, and resampled pictures, are computed again for the rows in question rather than stored.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from vidstyle.style.limits import CHANNELS
from vidstyle.style.nodes import LoweredStyle, Measure, Node, in_order, nodes_in_order

CONVERSIONS = ("luma_from_rgb", "chroma_from_rgb", "rgb_from_yuv", "rgb_from_gray", "upsample")
READS_PLANES = ("resample", "upsample")
"""Operations that read planes of another size, which are stored for them."""

Key = tuple[Node, int]
"""A node, and how many rows above and below the band it is computed for."""


@dataclass(frozen=True)
class BandStep:
    """One node computed in a band.

    Attributes:
        margin: rows above and below the band that it is computed for.
        is_loaded: whether it is read from planes instead.
        inputs: what it is computed from, by the names of the operation's inputs.
        twin: the other half of a conversion from RGB, which is computed along with it.
        releases: what no later step of the band reads.
    """

    node: Node
    margin: int
    is_loaded: bool
    inputs: tuple[tuple[str, Key], ...]
    twin: Node | None
    releases: tuple[Key, ...]


@dataclass(frozen=True, eq=False)
class Sweep:
    """Nodes that are computed together, band by band.

    Attributes:
        steps: in order.
        results: nodes that it is for.
        stores: nodes that are stored as whole planes.
        radius: rows that are read around each band.
    """

    steps: tuple[BandStep, ...]
    results: tuple[Node, ...]
    stores: tuple[Node, ...]
    radius: int

    @property
    def channels(self) -> int:
        """Numbers of a pixel in its largest value."""
        return max(CHANNELS[step.node.kind] for step in self.steps)


Task = Sweep | Measure[Node]
"""A sweep, or percentiles to be measured."""


@dataclass(frozen=True)
class Schedule:
    """What is done for each picture.

    Attributes:
        tasks: in order, each with the stored nodes that no later task reads.
        output: the sweep that computes the result at every pixel; it stores nothing.
    """

    tasks: tuple[tuple[Task, tuple[Node, ...]], ...]
    output: Sweep


def schedule(lowered: LoweredStyle, kept: Sequence[Node] = ()) -> Schedule:
    """The schedule of a lowered style. What several sweeps would compute is stored by the first.

    Args:
        kept: nodes whose planes are wanted as well (`FrameExecutor.planes`).
    """
    whole = _needed_whole([*lowered.outputs, *kept]) | set(kept)
    repeated: set[Node] = set()
    while True:
        scheduler = _Scheduler(lowered, whole, repeated, kept)
        more = scheduler.computed_twice()
        if not more:
            return scheduler.schedule()
        repeated |= more
        whole |= {node for node in more if node.op == "resample"}  # a sweep may have it with margins only


def _needed_whole(outputs: Sequence[Node]) -> set[Node]:
    """The nodes that neighborhood operations, measures and resampling need as whole planes, or subsampled."""
    nodes = nodes_in_order(outputs)
    users = Counter([*outputs, *(other for node in nodes for other in node.inputs.values())])

    def behind_conversions(node: Node) -> set[Node]:
        if node.op == "plane":
            return set()
        color = node.inputs.get("color")
        is_used_once = node.op == "luma_from_rgb" and color and color.op != "plane" and users[color] == 1
        if node.op not in CONVERSIONS or is_used_once:  # then one plane is stored instead of three
            return {node}
        return set().union(*map(behind_conversions, node.inputs.values()))

    whole = {node for node in outputs if node.grid}
    for node in nodes:
        if node.measure is not None:
            whole |= behind_conversions(node.measure.of)
        if node.op in READS_PLANES:
            whole |= set(node.inputs.values())
        elif node.reads_neighbors:
            read = set().union(*map(behind_conversions, node.inputs.values()))
            whole |= {each for each in read if each.op != "resample"}
    return whole


class _Scheduler:
    """One attempt.

    Args:
        whole: nodes for each of which there is a sweep.
        repeated: nodes that the first sweep that computes them stores along with its own.
        kept: nodes that are never released.
    """

    def __init__(
        self, lowered: LoweredStyle, whole: set[Node], repeated: set[Node], kept: Sequence[Node]
    ) -> None:
        self._stores, self._kept = whole | repeated, kept
        self._done: set[Node] = set()
        self._tasks: list[Task] = []
        for node in nodes_in_order([*lowered.outputs, *kept]):
            if node.measure is not None and node.measure not in self._tasks:
                self._tasks.append(node.measure)
            if node in whole - self._done and node.op != "plane":
                self._tasks.append(self._sweep([node]))
        self._output = self._sweep(_results(lowered, self._stores), is_output=True)

    def schedule(self) -> Schedule:
        """The tasks, with what each releases."""
        last = {
            node: number
            for number, task in enumerate([*self._tasks, self._output])
            for node in _planes_read(task)
        }
        tasks = (
            (task, tuple(node for node, end in last.items() if end == number and node not in self._kept))
            for number, task in enumerate(self._tasks)
        )
        return Schedule(tuple(tasks), self._output)

    def computed_twice(self) -> set[Node]:
        """What more than one sweep computes, but for conversions and for what only such nodes read."""
        sweeps = [each for each in (*self._tasks, self._output) if isinstance(each, Sweep)]
        computed = Counter(step.node for each in sweeps for step in each.steps if not step.is_loaded)
        twice = {
            node
            for node, count in computed.items()
            if count > 1 and node.inputs and node.op not in CONVERSIONS
        }
        return twice - {other for node in twice for other in node.inputs.values()}

    def _sweep(self, roots: Sequence[Node], is_output: bool = False) -> Sweep:
        order = in_order([(root, 0) for root in roots], lambda key: [each for _, each in self._inputs(key)])
        stores = [
            node
            for node, margin in order
            if node in self._stores and not margin and not self._is_loaded(node)
        ]
        twins = self._twins(order)
        order = [key for key in order if key not in twins.values()]
        last = {key: number for number, each in enumerate(order) for _, key in self._inputs(each)}
        kept = roots if is_output else ()
        steps = tuple(
            BandStep(
                *key,
                self._is_loaded(key[0]),
                self._inputs(key),
                twins[key][0] if key in twins else None,
                tuple(each for each, end in last.items() if end == number and each[0] not in kept),
            )
            for number, key in enumerate(order)
        )
        self._done |= set(stores)
        return Sweep(steps, tuple(roots), tuple(stores), max((margin for _, margin in order), default=0))

    def _is_loaded(self, node: Node) -> bool:
        return node in self._done or node.op == "plane"

    def _inputs(self, key: Key) -> tuple[tuple[str, Key], ...]:
        """The inputs of a node at its own size, with the rows that it reads of them."""
        node, margin = key
        if self._is_loaded(node) or node.op in READS_PLANES:
            return ()
        return tuple((name, (other, margin + node.radius)) for name, other in node.inputs.items())

    def _twins(self, order: list[Key]) -> dict[Key, Key]:
        """Conversions from RGB, each with the later one that is the other half of it."""
        firsts: dict[object, Key] = {}
        twins: dict[Key, Key] = {}
        for node, margin in order:
            if node.op in ("luma_from_rgb", "chroma_from_rgb") and not self._is_loaded(node):
                first = firsts.setdefault((node.inputs["color"], node.matrix, margin), (node, margin))
                if first[0] is not node:
                    twins[first] = node, margin
        return twins


def _results(lowered: LoweredStyle, stored: set[Node]) -> list[Node]:
    """What the last sweep computes; RGB where luma and chroma are converted from it and from nothing else."""
    luma = None if lowered.luma_untouched else lowered.luma
    chroma = lowered.chroma if lowered.chroma and not lowered.chroma.grid else None
    if luma and chroma and {luma.op, chroma.op} == {"luma_from_rgb", "chroma_from_rgb"}:
        color = luma.inputs["color"]
        if color is chroma.inputs["color"] and not {luma, chroma} & stored:
            return [color]
    return [node for node in (lowered.color, luma, chroma) if node]


def _planes_read(task: Task) -> Iterable[Node]:
    """The nodes whose planes a task reads."""
    if isinstance(task, Measure):
        return nodes_in_order([task.of])
    loaded = [step.node for step in task.steps if step.is_loaded]
    others = [step.node for step in task.steps if not step.is_loaded and step.node.op in READS_PLANES]
    return loaded + [image for node in others for image in node.inputs.values()]
