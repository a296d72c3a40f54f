"""A schedule: tasks, and the sweeps of bands that compute nodes.

A sweep computes nodes band by band, on all cores, so that a band stays in a core's cache from the first node
to the last.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vidstyle.style.limits import CHANNELS
from vidstyle.style.nodes import Node, PercentileRequest

READS_PLANES = ("resample", "upsample", "network")
"""Operations that read stored planes: of another size, or the whole picture."""
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

    @property
    def loads(self) -> tuple[Node, ...]:
        """Nodes of which it reads rows of planes, or rows that are recomputed."""
        if self.is_loaded:
            return (self.node,)
        return tuple(self.node.inputs.values()) if self.node.op in READS_PLANES else ()


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
        return any(node.op == "network" for sweep, _ in self.sweeps() for node in sweep.results)

    @property
    def stored_bytes(self) -> int:
        """Most bytes of planes that are stored at the same time."""
        return max(sum(map(plane_bytes, stored)) for _, stored in self.sweeps())

    def sweeps(self) -> Iterator[tuple[Sweep, frozenset[Node]]]:
        """Yield each sweep, and the nodes that are stored while it runs."""
        stored = frozenset[Node]()
        for task, releases in [*self.tasks, (self.output, ())]:
            if isinstance(task, Sweep):
                stored |= set(task.stores)
                yield task, stored
            stored -= set(releases)


def plane_bytes(node: Node, rows: int | None = None) -> int:
    """Return the bytes of some rows of a node, or of all, as float32."""
    height, width = node.shape
    return _FLOAT_BYTES * CHANNELS[node.kind] * (height if rows is None else rows) * width
