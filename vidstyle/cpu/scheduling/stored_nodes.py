"""Which nodes of a style need planes, and which of them can be computed again instead of stored.

A neighborhood operation reads rows around its band: its inputs are stored as whole planes first, and the
per-pixel operations after it run in the same sweep. Conversions between RGB and luma with chroma, resampled
pictures, and luma that per-pixel operations compute from stored RGB which the filter reads for chroma, are
computed again for the necessary rows instead of stored.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from vidstyle.cpu.scheduling.sweeps import READS_PLANES, plane_bytes
from vidstyle.style.nodes import LoweredStyle, Node, in_order, nodes_in_order

MAX_RECOMPUTED_STEPS = 8
"""Most steps that compute RGB again for each sweep that reads it: `oil`, `pixel` and `neon` have 4 to 6. With
the 11 of `riso`, a frame of 3840x2160 takes 31 to 40 % more processor time."""
CONVERSION_OPERATIONS = ("luma_from_rgb", "chroma_from_rgb", "rgb_from_yuv", "rgb_from_gray", "upsample")


def needed_whole(outputs: Sequence[Node], fused_radius: int) -> set[Node]:
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
        if node.op == "rgb_from_yuv" and _has_toned_luma(node):
            return behind_conversions(node.inputs["chroma"])
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


def _has_toned_luma(color: Node) -> bool:
    """Whether per-pixel operations compute the luma of RGB from the RGB to which its chroma belongs."""
    luma, chroma = color.inputs["luma"], color.inputs["chroma"]
    if chroma.op != "chroma_from_rgb":
        return False
    before = chroma.inputs["color"]
    toned = in_order([luma], lambda node: [each for each in node.inputs.values() if each is not before])
    return all(node.inputs and _is_per_pixel(node) for node in toned)


def _is_per_pixel(node: Node) -> bool:
    """Whether a node reads only its own pixel of its inputs."""
    return not node.reads_neighbors and node.op not in READS_PLANES


def recomputable(lowered: LoweredStyle, whole: set[Node]) -> set[Node]:
    """Return RGB of `whole` that few per-pixel operations compute from no larger planes.

    Measured RGB is not among them, nor is RGB from which other RGB of its size is computed: it serves both.
    """
    measured = {node.measure.of for node in nodes_in_order(lowered.outputs) if node.measure is not None}
    measured |= {other for node in measured for other in node.inputs.values()}
    planes_of = {
        node: planes
        for node in whole - measured
        if node.kind == "color" and not node.is_given
        if (planes := _planes_computed_from(node, whole)) is not None
    }
    fits = {node for node, planes in planes_of.items() if _bytes(planes) <= plane_bytes(node)}
    return fits - {
        plane for node in fits for plane in planes_of[node] if _bytes({plane}) == plane_bytes(node)
    }


def _planes_computed_from(node: Node, whole: set[Node]) -> set[Node] | None:
    """Return the nodes of `whole` from which few steps compute a node pixel by pixel; None if they do not."""
    computed = in_order([node], lambda each: [other for other in each.inputs.values() if other not in whole])
    is_long = len(computed) > MAX_RECOMPUTED_STEPS
    if is_long or any(each.reads_neighbors or each.op == "network" for each in computed):
        return None
    return {other for each in computed for other in each.inputs.values() if other in whole}


def _bytes(planes: set[Node]) -> int:
    return sum(map(plane_bytes, planes))
