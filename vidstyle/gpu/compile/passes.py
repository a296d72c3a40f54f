"""Partitions a graph into passes: decides which calls are fused and which values become textures.

A pass computes values at every pixel of a page, one after the other, in registers. Each neighborhood filter
starts a pass; per-pixel operations are fused into it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from vidstyle.gpu.compile.shader_nodes import CHANNEL_COUNTS, ShaderNode, ShaderPercentileRequest
from vidstyle.style.nodes import Shape, in_order

MAX_RECOMPUTED_CALLS = 12
"""Maximum number of per-pixel calls to repeat in each pass instead of storing their value in a texture, as
arithmetic costs less than memory traffic."""

MAX_STORED_VALUES = 5
"""Maximum number of values that a pass stores: OpenGL guarantees eight render targets, of which three may be
planes."""


@dataclass(frozen=True, eq=False)
class Result:
    """Values that are written together as planes of the result.

    Attributes:
        role: "planes" for luma, with or without chroma, which is averaged to the result's grid; "chroma" for
            chroma that already has this grid; "color" for RGB.
        nodes: the values.
        shape: height and width of their page.
    """

    role: Literal["planes", "chroma", "color"]
    nodes: tuple[ShaderNode, ...]
    shape: Shape


@dataclass(eq=False)
class Pass:
    """Values computed together at every pixel of a page.

    Attributes:
        shape: the page's height and width.
        stored: values stored in textures for later passes.
        sampled: the value that is measured at a grid of pixels; the pass then computes nothing else.
        result: values written as planes.
        before: the passes that it depends on.
        nodes: all values computed, in order.
        loads: textures and planes that it reads only at the position of each pixel.
        images: all pictures that it reads, without duplicates.
    """

    shape: Shape
    stored: list[ShaderNode] = field(default_factory=list)
    sampled: ShaderPercentileRequest | None = None
    result: Result | None = None
    before: set[Pass] = field(default_factory=set)
    nodes: list[ShaderNode] = field(default_factory=list)
    loads: list[ShaderNode] = field(default_factory=list)
    images: list[ShaderNode] = field(default_factory=list)

    @property
    def roots(self) -> list[ShaderNode]:
        """The values that it computes for other passes and the result."""
        sampled = [self.sampled.of] if self.sampled else []
        return [*self.stored, *(self.result.nodes if self.result else ()), *sampled]

    @property
    def is_light(self) -> bool:
        """Whether it reads no neighbours and computes every pixel."""
        return self.sampled is None and not any(node.is_heavy for node in self.nodes)

    def needs(self, other: Pass) -> bool:
        """Whether it depends on the other pass, directly or indirectly."""
        seen, waiting = set(self.before), list(self.before)
        while waiting:
            each = waiting.pop()
            if each is other:
                return True
            waiting += each.before - seen
            seen |= each.before
        return False


def partition(results: Sequence[Result], fused: bool = True) -> list[Pass]:
    """Return the passes that compute the results and the necessary measurements, in order.

    Args:
        fused: False to store the result of every call in a texture, for comparison.
    """
    kept = set() if fused else {node for node in _ordered(results) if not node.is_plane}
    while True:
        attempt = _Partition(results, kept)
        again = attempt.worth_keeping()
        if not again:
            return attempt.in_order()
        kept |= again


class _Partition:
    """One attempt at a partition, given the nodes to store in textures."""

    def __init__(self, results: Sequence[Result], kept: set[ShaderNode]) -> None:
        nodes = _ordered(results)
        around = {node.around for node in nodes if node.around is not None}
        self._stored = {node for node in kept | around if not node.is_plane}
        self._homes: dict[ShaderNode, Pass] = {}
        self._needs: dict[ShaderNode, set[Pass]] = {node: set() for node in nodes if node.is_plane}
        self._measured: dict[ShaderPercentileRequest, Pass] = {}
        self._passes: list[Pass] = []
        for node in nodes:
            self._settle_measure(node.measure)
            if not node.is_plane:
                self._settle(node)
        for result in results:
            self._settle_result(result)
        for each in list(self._passes):
            self._divide(each, nodes)
        for each in self._passes:
            each.nodes = self._calls(each.roots, each)
            wanted = [*each.roots, *(node for call in each.nodes for node in call.inputs.values())]
            each.loads = [node for node in dict.fromkeys(wanted) if node not in each.nodes]
            filtered = [node.around for node in each.nodes if node.around is not None]
            each.images = list(dict.fromkeys([*each.loads, *filtered]))

    def worth_keeping(self) -> set[ShaderNode]:
        """Return per-pixel nodes that need too many calls to repeat them in several passes."""
        users = Counter(node for each in self._passes if each.sampled is None for node in each.nodes)
        often = [node for node, count in users.items() if count > 1 and node not in self._stored]
        long = {node for node in often if len(self._calls([node], None)) > MAX_RECOMPUTED_CALLS}
        return long - {other for node in long for other in node.inputs.values()}

    def in_order(self) -> list[Pass]:
        """Return the passes in the order of their dependencies."""
        roots = [each for each in self._passes if each.roots]
        return in_order(roots, lambda each: sorted(each.before, key=self._passes.index))

    def _settle_measure(self, measure: ShaderPercentileRequest | None) -> None:
        if measure is None or measure in self._measured:
            return
        if home := self._homes.get(measure.of):
            self._store(measure.of, home)
        sampling = self._new_pass(measure.of.shape)
        sampling.sampled, sampling.before = measure, set(self._needs[measure.of])
        self._measured[measure] = sampling

    def _settle(self, node: ShaderNode) -> None:
        """Find the pass that computes a node; light nodes are computed by each pass that needs them."""
        others = [*node.inputs.values(), *([node.around] if node.around else [])]
        measured = {self._measured[node.measure]} if node.measure else set()
        needed = measured.union(*(self._needs[other] for other in others))
        home: Pass | None
        if node.is_heavy:
            home = self._pass_around(node, measured) or self._new_pass(node.shape)
            self._store_elsewhere(node.inputs.values(), home)
        else:
            # It needs a complete neighbourhood, so it cannot be fused into the pass that computes its input.
            before = measured.union(self._needs[node.around] if node.around else ())
            home = self._ride(node.inputs.values(), before, node.shape)
        if home is None and node in self._stored:
            home = self._light_pass(node.shape, needed)
            home.stored.append(node)
        if home is None:
            self._needs[node] = needed
            return
        home.before |= needed - {home}
        home.nodes.append(node)
        self._needs[node] = {home}
        if home.is_light:
            self._homes.setdefault(node, home)
            return
        self._homes[node] = home
        if node in self._stored:
            self._store(node, home)

    def _pass_around(self, node: ShaderNode, measured: set[Pass]) -> Pass | None:
        """Return a pass that already filters the same picture, so that it reads each sample only once."""
        assert node.around is not None
        finished = measured | self._needs[node.around]
        beside = set().union(*(self._needs[other] for other in node.inputs.values()))
        for each in self._passes:
            readers = [other for other in each.nodes if other.is_heavy and other.around is node.around]
            # At 1 x 1, choices of 2 x 2 pixels have the size of the filters that read them.
            alike = all((other.kind == "choices") == (node.kind == "choices") for other in readers)
            if not readers or not alike or each.shape != node.shape or _both_prepare(each, node):
                continue
            if each not in finished and not any(other.needs(each) for other in finished | beside - {each}):
                return each
        return None

    def _store_elsewhere(self, nodes: Iterable[ShaderNode], home: Pass | None) -> None:
        """Store the nodes that other passes compute."""
        for node in nodes:
            other = self._homes.get(node)
            if other is not None and other is not home and not other.is_light:
                self._store(node, other)

    def _ride(self, nodes: Iterable[ShaderNode], measured: set[Pass], shape: Shape) -> Pass | None:
        """Return the pass of one of the nodes that all can be added to; store nodes of other passes.

        It is the pass of the node with the most channels, as other nodes are cheaper to store.
        """
        nodes = list(nodes)
        riding = [node for node in nodes if node in self._homes and not self._homes[node].is_light]
        riding.sort(key=lambda node: -CHANNEL_COUNTS[node.kind])
        homes = (self._homes[node] for node in riding)
        found = next((home for home in homes if self._can_ride(home, nodes, measured, shape)), None)
        self._store_elsewhere(riding, found)
        return found

    def _can_ride(self, home: Pass, nodes: list[ShaderNode], measured: set[Pass], shape: Shape) -> bool:
        others = (self._needs[node] for node in nodes if self._homes.get(node) is not home)
        needed = measured.union(*others)
        return home.shape == shape and not any(each is home or each.needs(home) for each in needed)

    def _light_pass(self, shape: Shape, needed: set[Pass]) -> Pass:
        """Return a per-pixel pass: an existing one if the order of dependencies allows it."""
        for each in self._passes:
            if each.is_light and each.shape == shape:
                if not any(other.needs(each) for other in needed if other is not each):
                    return each
        return self._new_pass(shape)

    def _settle_result(self, result: Result) -> None:
        home = self._ride(result.nodes, set(), result.shape)
        needed = set().union(*(self._needs[node] for node in result.nodes))
        home = home or self._light_pass(result.shape, needed)
        home.result = result
        home.before |= needed - {home}

    def _store(self, node: ShaderNode, home: Pass) -> None:
        self._stored.add(node)
        if node not in home.stored:
            home.stored.append(node)

    def _new_pass(self, shape: Shape) -> Pass:
        self._passes.append(Pass(shape))
        return self._passes[-1]

    def _divide(self, each: Pass, order: list[ShaderNode]) -> None:
        """Move values that exceed the limit of a pass to new passes before it."""
        while len(each.stored) > MAX_STORED_VALUES:
            each.stored.sort(key=order.index)
            first = self._new_pass(each.shape)
            first.before = set(each.before)
            first.stored, each.stored = each.stored[:MAX_STORED_VALUES], each.stored[MAX_STORED_VALUES:]
            self._homes.update(dict.fromkeys(first.stored, first))
            for other in self._passes:
                if each in other.before:
                    other.before.add(first)
            each.before.add(first)

    def _calls(self, roots: list[ShaderNode], home: Pass | None) -> list[ShaderNode]:
        """Return the nodes computed for the roots, in order, without planes and values of other passes."""

        def is_at_hand(node: ShaderNode) -> bool:
            return node.is_plane or (node in self._stored and self._homes.get(node) is not home)

        def needs(node: ShaderNode) -> list[ShaderNode]:
            return [] if is_at_hand(node) else list(node.inputs.values())

        return [node for node in in_order(roots, needs) if not is_at_hand(node)]


def _both_prepare(each: Pass, node: ShaderNode) -> bool:
    """Whether both the node and a node of the pass prepare data for a compute group; only one node can."""
    functions = (other.function for other in (node, *each.nodes) if other.is_heavy)
    return sum(function is not None and function.signature.prepares for function in functions) > 1


def _ordered(results: Sequence[Result]) -> list[ShaderNode]:
    """Return all nodes that the results need, each after its inputs."""

    def needs(node: ShaderNode) -> list[ShaderNode]:
        around = [node.around] if node.around else []
        return [*node.inputs.values(), *around, *([node.measure.of] if node.measure else [])]

    return in_order((node for result in results for node in result.nodes), needs)
