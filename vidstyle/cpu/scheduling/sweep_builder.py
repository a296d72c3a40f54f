"""Puts nodes into one sweep: in which order, with which rows, and how long their values are kept."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from vidstyle.cpu.scheduling.sweeps import READS_PLANES, BandStep, Key, Sweep
from vidstyle.style.nodes import Node, in_order


class SweepBuilder:
    """Builds the sweep that computes some nodes.

    Args:
        roots: the nodes to compute.
        done: nodes that are loaded, not computed.
        stores: nodes to store where the sweep computes them for the rows of its band.
        is_output: whether the values of the roots are kept until the end of the band.
    """

    def __init__(
        self, roots: Sequence[Node], done: Collection[Node], stores: Collection[Node], is_output: bool
    ) -> None:
        self._roots, self._done, self._kept = roots, done, roots if is_output else ()
        self._nodes = in_order(roots, lambda node: self._inputs(node).values())
        self._margins = self._margins_read()
        computed = [node for node in self._nodes if 0 in self._margins[node] and node not in done]
        self._stores = [node for node in computed if node in stores]

    def sweep(self) -> Sweep:
        """Return the sweep."""
        keys = [(node, max(self._margins[node])) for node in self._nodes]
        twins = self._twins(keys)
        keys = [key for key in keys if key not in twins.values()]
        last = {key: number for number, each in enumerate(keys) for _, key in self._keys_read(each)}
        ends: list[list[Key]] = [[] for _ in keys]
        for key, number in last.items():
            if key[0] not in self._kept:
                ends[number].append(key)
        steps = (self._step(key, twins.get(key), each) for key, each in zip(keys, ends, strict=True))
        radius = max((margin for _, margin in keys), default=0)
        return Sweep(tuple(steps), tuple(self._roots), tuple(self._stores), radius)

    def _step(self, key: Key, twin: Key | None, releases: Sequence[Key]) -> BandStep:
        node, margin = key
        halves = [node for node, _ in filter(None, (key, twin))]
        return BandStep(
            node,
            margin,
            is_loaded=node in self._done,
            narrower=tuple((half, each) for half in halves for each in self._margins[half] - {margin}),
            inputs=self._keys_read(key),
            twin=twin[0] if twin else None,
            stores=tuple(half for half in halves if half in self._stores),
            releases=tuple(releases),
        )

    def _margins_read(self) -> dict[Node, set[int]]:
        """Return the margins with which later nodes read each node; the roots also have 0."""
        margins = {node: {0} if node in self._roots else set[int]() for node in self._nodes}
        for node in reversed(self._nodes):
            for _, (other, margin) in self._keys_read((node, max(margins[node]))):
                margins[other].add(margin)
        return margins

    def _inputs(self, node: Node) -> dict[str, Node]:
        """Return the inputs of a node at its size that the sweep computes or loads."""
        return {} if node in self._done or node.op in READS_PLANES else node.inputs

    def _keys_read(self, key: Key) -> tuple[tuple[str, Key], ...]:
        """Return the inputs of a node at its size, with the rows that it reads."""
        node, margin = key
        return tuple((name, (other, margin + node.radius)) for name, other in self._inputs(node).items())

    def _twins(self, keys: Sequence[Key]) -> dict[Key, Key]:
        """Map conversions from RGB to the later conversion that is their other half."""
        firsts: dict[object, Key] = {}
        twins: dict[Key, Key] = {}
        for node, margin in keys:
            if node.op in ("luma_from_rgb", "chroma_from_rgb") and node not in self._done:
                first = firsts.setdefault((node.inputs["color"], node.matrix, margin), (node, margin))
                if first[0] is not node:
                    twins[first] = node, margin
        return twins
