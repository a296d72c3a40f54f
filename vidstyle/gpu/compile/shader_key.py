"""The key of a shader's text: passes that differ only in numbers share one."""

from __future__ import annotations

from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader_nodes import ShaderNode
from vidstyle.gpu.compile.work_group import work_group_of


def shader_key(plan: Plan, each: Pass) -> tuple[object, ...]:
    """Return all that the text of a pass's shader depends on: everything but numbers."""
    places = {node: number for number, node in enumerate([*each.images, *each.nodes])}
    return (
        plan.form,
        plan.source.encoding,
        plan.target,
        work_group_of(plan, each).capacities,
        tuple(_picture_key(node, each) for node in each.images),
        tuple(_call_key(node, places) for node in each.nodes),
        *(tuple(places[node] for node in nodes) for nodes in (each.loads, each.stored)),
        each.sampled and places[each.sampled.of],
        each.result and (each.result.role, *(places[node] for node in each.result.nodes)),
    )


def _picture_key(node: ShaderNode, each: Pass) -> tuple[object, ...]:
    return node.kind, node.is_plane, not node.mask, node.is_wide, node.grid is None, node.shape == each.shape


def _call_key(node: ShaderNode, places: dict[ShaderNode, int]) -> tuple[object, ...]:
    """Return the parts of a node that its call depends on; other nodes by their places."""
    return (
        node.kind,
        node.function,
        tuple((name, places[other]) for name, other in node.inputs.items()),
        node.around and (places[node.around], node.around.shape == node.shape),
        tuple(node.values),
        tuple(node.options.items()),
        node.measure and len(node.measure.percentages),
        node.is_wide,
        node.is_enlarged,
        node.limits is None,
    )
