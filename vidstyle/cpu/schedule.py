"""Schedules nodes of a lowered style: which are computed together in bands, and which are stored as planes.

A sweep computes nodes band by band, on all cores, so that a band stays in a core's cache from the first node
to the last. A neighborhood operation reads rows around its band: its inputs are stored as whole planes first,
and the per-pixel operations after it run in the same sweep. Conversions between RGB and luma with chroma, and
resampled pictures, are computed again for the necessary rows instead of stored.

A compact schedule, for styles that would store much, also computes RGB again that per-pixel operations make
of smaller planes, and the rows next to a band for filters that read no others.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from vidstyle.style.limits import CHANNELS
from vidstyle.style.nodes import LoweredStyle, Node, PercentileRequest, in_order, nodes_in_order

CONVERSION_OPERATIONS = ("luma_from_rgb", "chroma_from_rgb", "rgb_from_yuv", "rgb_from_gray", "upsample")
READS_PLANES = ("resample", "upsample", "network")
"""Operations that read stored planes: of another size, or the whole picture."""

MAX_STORED_BYTES_PER_PIXEL = 25
"""Most bytes per pixel that planes may take at once without a compact schedule. Of the shipped styles, `oil`
takes 39, `pixel` 34, `neon` and `pointillist` 26."""
MAX_COMPACT_RATIO = 0.8
"""Most bytes of the planes of a compact schedule, relative to those of the usual one; it is 0.98 for
`pointillist`, which has the usual one."""
MAX_FUSED_RADIUS = 1
"""Greatest radius of filters whose inputs a compact schedule computes in the same sweep."""
_FLOAT_BYTES = 4

Key = tuple[Node, int]
"""A node, and the numbers of rows above and below the band that it is computed for."""


@dataclass(frozen=True)
class BandStep:
    """One node computed in a band.

    Attributes:
        margin: numbers of rows above and below the band that it is computed for.
        is_loaded: whether it is read from planes instead of computed.
        narrower: smaller margins with which later steps read it or its twin.
        inputs: its inputs, by the names of the operation's inputs.
        twin: the other half of a conversion from RGB, computed together with it.
        stores: the pictures of both halves that are stored as whole planes.
        releases: values that no later step of the band reads.
    """

    node: Node
    margin: int
    is_loaded: bool
    narrower: tuple[Key, ...]
    inputs: tuple[tuple[str, Key], ...]
    twin: Node | None
    stores: tuple[Node, ...]
    releases: tuple[Key, ...]


@dataclass(frozen=True, eq=False)
class Sweep:
    """Nodes that are computed together, band by band.

    Attributes:
        steps: in order.
        results: the nodes to compute.
        stores: nodes that are stored as whole planes.
        radius: number of rows that are read around each band.
    """

    steps: tuple[BandStep, ...]
    results: tuple[Node, ...]
    stores: tuple[Node, ...]
    radius: int

    @property
    def channels(self) -> int:
        """Numbers per pixel of its largest value."""
        return max(CHANNELS[step.node.kind] for step in self.steps)


Task = Sweep | PercentileRequest[Node]
"""A sweep, or percentiles to measure."""


@dataclass(frozen=True)
class Schedule:
    """The tasks for each picture.

    Attributes:
        tasks: in order, each with the stored nodes that no later task reads.
        output: the sweep that computes the result at every pixel; it stores nothing.
        successors: of planes of which a sweep reads only rows around its band, and that no later task reads:
            the sweep, and planes that it stores and that can follow in their memory.
        recomputed: nodes that are not stored, and the sweeps that compute their rows each time they are read.
    """

    tasks: tuple[tuple[Task, tuple[Node, ...]], ...]
    output: Sweep
    successors: dict[Node, tuple[Sweep, Node]]
    recomputed: dict[Node, Sweep]

    @property
    def has_network(self) -> bool:
        """Whether it runs a network, which has a separate process."""
        sweeps = [task for task, _ in self.tasks if isinstance(task, Sweep)]
        return any(node.op == "network" for sweep in sweeps for node in sweep.results)

    def at_once(self) -> Iterator[tuple[Sweep, set[Node]]]:
        """Yield each sweep, and the nodes that are stored while it runs."""
        stored = set[Node]()
        for task, releases in [*self.tasks, (self.output, ())]:
            if isinstance(task, Sweep):
                stored |= set(task.stores)
                yield task, stored
            stored -= set(releases)


def schedule(lowered: LoweredStyle, kept: Sequence[Node] = ()) -> Schedule:
    """Schedule a lowered style. Nodes that several sweeps would compute are stored by the first.

    Args:
        kept: additional nodes whose planes are requested (`FrameExecutor.planes`).
    """
    usual = _scheduled(lowered, kept, is_compact=False)
    most = _stored_bytes(usual)
    if kept or most <= MAX_STORED_BYTES_PER_PIXEL * math.prod(lowered.source.shape):
        return usual
    compact = _scheduled(lowered, (), is_compact=True)
    return compact if _stored_bytes(compact) <= MAX_COMPACT_RATIO * most else usual


def _stored_bytes(schedule: Schedule) -> int:
    """Return the most bytes of stored planes at once."""
    return max(sum(map(plane_bytes, stored)) for _, stored in schedule.at_once())


def plane_bytes(node: Node, rows: int | None = None) -> int:
    """Return the bytes of some rows of a node, or of all, as float32."""
    height, width = node.shape
    return _FLOAT_BYTES * CHANNELS[node.kind] * (height if rows is None else rows) * width


def _scheduled(lowered: LoweredStyle, kept: Sequence[Node], is_compact: bool) -> Schedule:
    whole = _needed_whole([*lowered.outputs, *kept], MAX_FUSED_RADIUS if is_compact else 0) | set(kept)
    repeated: set[Node] = set()
    while True:
        recomputed = _recomputable(lowered, whole) if is_compact else set()
        scheduler = _Scheduler(lowered, whole, repeated, kept, recomputed)
        more = scheduler.computed_twice()
        if not more:
            return scheduler.schedule()
        repeated |= more
        # A sweep may only have them with margins.
        whole |= more if is_compact else {node for node in more if node.op == "resample"}


def _recomputable(lowered: LoweredStyle, whole: set[Node]) -> set[Node]:
    """Return RGB of `whole` that per-pixel operations make of smaller planes, and that is not measured."""
    measured = {node.measure.of for node in nodes_in_order(lowered.outputs) if node.measure is not None}
    measured |= {other for node in measured for other in node.inputs.values()}

    def is_recomputable(node: Node) -> bool:
        planes, open_nodes = set[Node](), [node]
        for each in open_nodes:
            if each.reads_neighbors or each.op == "network":
                return False
            planes |= {other for other in each.inputs.values() if other in whole}
            open_nodes += [other for other in each.inputs.values() if other not in whole]
        return sum(map(plane_bytes, planes)) < plane_bytes(node)

    colors = {node for node in whole - measured if node.kind == "color" and not node.is_given}
    return set(filter(is_recomputable, colors))


def _needed_whole(outputs: Sequence[Node], fused_radius: int) -> set[Node]:
    """Return the nodes that neighborhood operations, measures and resampling need as whole planes.

    Args:
        fused_radius: greatest radius of filters that do not need them.
    """
    nodes = nodes_in_order(outputs)
    users = Counter([*outputs, *(other for node in nodes for other in node.inputs.values())])

    def behind_conversions(node: Node) -> set[Node]:
        if node.is_given:
            return set()
        color = node.inputs.get("color")
        is_used_once = node.op == "luma_from_rgb" and color and not color.is_given and users[color] == 1
        if node.op not in CONVERSION_OPERATIONS or is_used_once:  # store one plane instead of three
            return {node}
        return set().union(*map(behind_conversions, node.inputs.values()))

    whole = {node for node in outputs if node.grid}
    whole |= {node for node in nodes if node.op == "network"}
    for node in nodes:
        if node.measure is not None:
            whole |= behind_conversions(node.measure.of)
        if node.op in READS_PLANES:
            whole |= set(node.inputs.values())
        elif node.reads_neighbors and node.radius > fused_radius:
            read = set().union(*map(behind_conversions, node.inputs.values()))
            whole |= {each for each in read if each.op != "resample"}
    return whole


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
        self._stores, self._kept = (whole | repeated) - recomputed, kept
        self._done: set[Node] = set()
        self._tasks: list[Task] = []
        self._recomputed: dict[Node, Sweep] = {}
        for node in nodes_in_order([*lowered.outputs, *kept]):
            if node.measure is not None and node.measure not in self._tasks:
                self._tasks.append(node.measure)
            if node in recomputed:
                self._recomputed[node] = self._sweep([node])
                self._done.add(node)
            elif node in whole - self._done and not node.is_given:
                self._tasks.append(self._sweep([node]))
        self._output = self._sweep(_results(lowered, self._stores), is_output=True)

    def schedule(self) -> Schedule:
        """Return the tasks, and the nodes that each releases."""
        last = {
            node: number
            for number, task in enumerate([*self._tasks, self._output])
            for node in _planes_read(task, self._recomputed)
        }
        tasks = tuple(
            (task, tuple(node for node, end in last.items() if end == number and node not in self._kept))
            for number, task in enumerate(self._tasks)
        )
        successors = _successors(tasks, self._recomputed)
        return Schedule(tasks, self._output, successors, self._recomputed)

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
        nodes = in_order(roots, lambda node: self._inputs(node).values())
        margins = self._margins(roots, nodes)
        computed = [node for node in nodes if 0 in margins[node] and not self._is_loaded(node)]
        stores = [node for node in computed if node in self._stores]
        order = [(node, max(margins[node])) for node in nodes]
        twins = self._twins(order)
        order = [key for key in order if key not in twins.values()]
        last = {key: number for number, each in enumerate(order) for _, key in self._keys_read(each)}
        kept = roots if is_output else ()
        steps = list[BandStep]()
        for number, key in enumerate(order):
            (node, margin), twin = key, twins[key][0] if key in twins else None
            made = [each for each in (node, twin) if each is not None]
            narrower = [(each, other) for each in made for other in margins[each] - {margin}]
            stored = tuple(each for each in made if each in stores)
            ends = tuple(each for each, end in last.items() if end == number and each[0] not in kept)
            inputs = self._keys_read(key)
            steps.append(BandStep(*key, self._is_loaded(node), tuple(narrower), inputs, twin, stored, ends))
        self._done |= set(stores)
        return Sweep(tuple(steps), tuple(roots), tuple(stores), max(map(max, margins.values()), default=0))

    def _margins(self, roots: Sequence[Node], nodes: Sequence[Node]) -> dict[Node, set[int]]:
        """Return the margins with which each of the nodes of a sweep is read; the roots have none."""
        margins = {node: {0} if node in roots else set[int]() for node in nodes}
        for node in reversed(nodes):
            for _, (other, margin) in self._keys_read((node, max(margins[node]))):
                margins[other].add(margin)
        return margins

    def _is_loaded(self, node: Node) -> bool:
        return node in self._done or node.is_given

    def _inputs(self, node: Node) -> dict[str, Node]:
        """Return the inputs of a node at its size that a sweep computes or loads."""
        return {} if self._is_loaded(node) or node.op in READS_PLANES else node.inputs

    def _keys_read(self, key: Key) -> tuple[tuple[str, Key], ...]:
        """Return the inputs of a node at its size, with the rows that it reads."""
        node, margin = key
        return tuple((name, (other, margin + node.radius)) for name, other in self._inputs(node).items())

    def _twins(self, order: list[Key]) -> dict[Key, Key]:
        """Map conversions from RGB to the later conversion that is their other half."""
        firsts: dict[object, Key] = {}
        twins: dict[Key, Key] = {}
        for node, margin in order:
            if node.op in ("luma_from_rgb", "chroma_from_rgb") and not self._is_loaded(node):
                first = firsts.setdefault((node.inputs["color"], node.matrix, margin), (node, margin))
                if first[0] is not node:
                    twins[first] = node, margin
        return twins


def _results(lowered: LoweredStyle, stored: set[Node]) -> list[Node]:
    """Return the results of the last sweep; RGB if luma and chroma are only converted from it."""
    luma = None if lowered.luma_untouched else lowered.luma
    chroma = lowered.chroma if lowered.chroma and not lowered.chroma.grid else None
    if luma and chroma and {luma.op, chroma.op} == {"luma_from_rgb", "chroma_from_rgb"}:
        color = luma.inputs["color"]
        if color is chroma.inputs["color"] and not {luma, chroma} & stored:
            return [color]
    return [node for node in (lowered.color, luma, chroma) if node]


def _successors(
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
                yield from _planes_read(recomputed[image], recomputed) if image in recomputed else [image]


def _planes_read(task: Task, recomputed: Mapping[Node, Sweep]) -> Iterator[Node]:
    """Yield the nodes whose planes a task reads."""
    if isinstance(task, PercentileRequest):
        yield from nodes_in_order([task.of])
        return
    for step in task.steps:
        if step.is_loaded and step.node in recomputed:
            yield from _planes_read(recomputed[step.node], recomputed)
        elif step.is_loaded:
            yield step.node
    yield from _read_whole(task, recomputed)
