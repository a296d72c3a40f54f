"""The work groups of a compute pass: the pixels that they write, and the memory that they share."""

from __future__ import annotations

from dataclasses import dataclass, replace

from vidstyle.core.codes import chroma_radius
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import shrinks
from vidstyle.gpu.compile.shared import VALUE_BYTES, Pair, Sharing, sharing_of

INVOCATIONS: dict[Pair | None, Pair] = {None: (16, 16), (1, 0): (32, 8), (0, 1): (8, 32)}
"""Invocations across and down: more in the direction in which filters read, as neighbours in this direction
read the same pixels."""

TILE_SIZES: dict[Pair | None, Pair] = {None: (32, 16), (1, 0): (32, 16), (0, 1): (16, 32)}
"""Pixels across and down that a work group writes if it averages chroma."""


@dataclass(frozen=True)
class WorkGroup:
    """A work group of a pass; a fragment pass has no shared memory.

    Attributes:
        invocations: number of invocations across and down.
        written: pixels across and down that it writes.
        rims: pixels before and after them, across and down, that it also computes to average chroma.
        sharing: what it reads through shared memory, or None.
        capacities: numbers of pixels and of prepared values in shared memory, or None.
    """

    invocations: Pair
    written: Pair
    rims: tuple[Pair, Pair] = ((0, 0), (0, 0))
    sharing: Sharing | None = None
    capacities: tuple[int, int] | None = None

    @property
    def computed(self) -> Pair:
        """Pixels across and down that it computes."""
        across, down = self.rims
        return self.written[0] + sum(across), self.written[1] + sum(down)


def work_group_of(plan: Plan, each: Pass) -> WorkGroup:
    """Return the work group of a pass of a plan."""
    sharing = sharing_of(each) if plan.form == "compute" else None
    line, used = sharing.line if sharing else None, 0
    group = WorkGroup(INVOCATIONS[line], INVOCATIONS[line])
    if shrinks(plan, each):
        rims = chroma_radius(plan.target, 0), chroma_radius(plan.target, 1)
        group = replace(group, written=TILE_SIZES[line], rims=rims)
        used = VALUE_BYTES[2] * group.computed[0] * group.computed[1]
    capacities = sharing.capacities(group.computed, used) if sharing else None
    return replace(group, sharing=sharing, capacities=capacities) if capacities else group
