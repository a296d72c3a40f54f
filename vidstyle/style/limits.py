"""Limits of a style's working size, memory and time, from the declarations of its nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from vidstyle.block import PageRegion
from vidstyle.style.nodes import Node, Shape, nodes_in_order

MAX_GROWTH = 16
"""The largest working size, by the pixels of the picture: a `scale` by 4 in all."""
MAX_WORK = 1 << 16
"""The most operations for each pixel of the picture. Shipped styles take a thousand or two, of 8192 x 8192
pixels up to eight thousand, as lengths grow with the picture."""
MAX_SAMPLES = 1 << 28
"""The most numbers that are kept at once, 1 GiB; large pictures may take `MAX_PIXEL_SAMPLES` instead."""
MAX_PIXEL_SAMPLES = 32

NODE_COST = 32
"""Operations per number of a node that reads no neighbours; resampling costs half for each number that it
reads or writes."""
MIN_COUNTED_PIXELS = 64 * 64
"""Smaller pictures count as this many pixels: rounding makes their working sizes larger."""
CHANNELS = {"luma": 1, "chroma": 2, "color": 3}
STROKE_SAMPLE_COUNT = 2
"""Numbers per pixel that a block fixed to the page keeps between pictures."""


def excess(outputs: Sequence[Node], page: Shape) -> str:
    """Return the reason why a result takes too much work or memory, or an empty string.

    Args:
        outputs: the nodes of the result.
        page: height and width of the picture.
    """
    nodes, pixels = nodes_in_order(outputs), max(page[0] * page[1], MIN_COUNTED_PIXELS)
    found = []
    height, width = max((node.shape for node in nodes), key=math.prod)
    if height * width > MAX_GROWTH * pixels:
        found.append(f"works at {width} x {height}")
    if (work := sum(map(_work, nodes)) / pixels) > MAX_WORK:
        found.append(f"takes {work:.0f} operations for each pixel, more than {MAX_WORK}")
    if (samples := _most_samples(nodes)) > max(MAX_SAMPLES, MAX_PIXEL_SAMPLES * pixels):
        found.append(f"keeps {4 * samples / (1 << 30):.1f} GiB at once")
    if not found:
        return ""
    remedy = "it needs fewer passes and steps, shorter lengths or smaller working sizes"
    return f"{' and '.join(found)} for pictures of {page[1]} x {page[0]}; {remedy}"


def _samples(node: Node) -> int:
    return CHANNELS[node.kind] * node.shape[0] * node.shape[1]


def _work(node: Node) -> float:
    """Operations for the whole picture, roughly: multiplications, mostly."""
    if node.op == "filter_bank":
        return _samples(node) * float(node.values["run"].work)
    if node.op == "resample":
        return NODE_COST / 2 * (_samples(node) + _samples(node.inputs["image"]))
    return _samples(node) * (NODE_COST + 4.0 * node.radius)


def _most_samples(nodes: Sequence[Node]) -> int:
    """Return the most numbers kept at once if each node is kept until the last one that reads it."""
    last = {other: number for number, node in enumerate(nodes) for other in node.inputs.values()}
    ending: dict[int, int] = {}
    now = most = 0
    for number, node in enumerate(nodes):
        ending[last.get(node, -1)] = ending.get(last.get(node, -1), 0) + _samples(node)
        now += _samples(node)
        if node.block is not None and PageRegion in node.block.injected.values():
            now += STROKE_SAMPLE_COUNT * node.shape[0] * node.shape[1]
        most = max(most, now)
        now -= ending.pop(number, 0)
    return most
