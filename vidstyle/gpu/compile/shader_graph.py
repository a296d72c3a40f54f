"""The GLSL functions that compute the nodes of a lowered style."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, cast

from vidstyle.blade.bank import MAX_CLIPS, MAX_RHO
from vidstyle.blade.bins import MIDDLE_CURVATURE, Bins, Feature
from vidstyle.blade.choice import feature_radius
from vidstyle.blade.inference import BankRun
from vidstyle.blade.structure_tensor import half_window, window_radius
from vidstyle.block import Block, Choice, Drift, LumaWeights
from vidstyle.core.picture import RANGES
from vidstyle.core.resample import METHODS
from vidstyle.gpu.compile.glsl import Form, functions_of_block, signatures
from vidstyle.gpu.compile.shader_nodes import (
    CHANNEL_COUNTS,
    Function,
    ShaderKind,
    ShaderNode,
    ShaderPercentileRequest,
)
from vidstyle.style.mask_declarations import fixed_mask_level
from vidstyle.style.nodes import Node, PercentileRequest, encoding_of, identity_key, nodes_in_order

OPERATION_FILES = {
    name: file for file in ("frame/color.glsl", "frame/layers.glsl") for name in signatures(file)
}
"""Operations with a GLSL function of the same name, and its file."""

MAX_TAPS = window_radius(MAX_RHO)
"""Number of weights of one half of the window in `chosen_filter`."""
UNCLIPPED_RANGE = (-1e30, 1e30)
"""Limits of a resampled picture that is not clipped: a change to a method that clips must not change the
shader."""
MAX_PARTS = 8
"""Maximum number of parts of a bank in `filtered`."""


class ShaderGraph:
    """Shader nodes for the nodes of a style, without duplicates.

    Args:
        form: form of the passes.
    """

    def __init__(self, form: Form) -> None:
        self._form = form
        self._nodes: dict[object, ShaderNode] = {}
        self._made: dict[Node, ShaderNode] = {}
        self._measures: dict[PercentileRequest[Node], ShaderPercentileRequest] = {}
        self._exact: set[Node] = set()

    def add(self, outputs: Iterable[Node]) -> None:
        """Create the shader nodes for these nodes and their inputs."""
        order = nodes_in_order(outputs)
        self._exact |= _exact_nodes(order)
        for node in order:
            made = self._make(node)
            if node in self._exact and not made.is_plane:
                made = self.node(replace(made, is_wide=True))
            self._made[node] = made

    def __getitem__(self, node: Node) -> ShaderNode:
        return self._made[node]

    def node(self, node: ShaderNode) -> ShaderNode:
        """Return the node, or an existing equal one."""
        return self._nodes.setdefault(identity_key(node), node)

    def recoded(self, chroma: Node) -> ShaderNode:
        """Return chroma on the target's grid, converted if its codes differ."""
        made = self[chroma]
        call = ShaderNode("chroma", made.shape, Function("frame/color.glsl", "same_chroma"), {"chroma": made})
        return self.node(replace(call, grid=made.grid, page=made.page))

    def _make(self, node: Node) -> ShaderNode:
        match node.op:
            case "plane":
                return self.node(ShaderNode(node.kind, node.shape, grid=node.grid, page=node.page))
            case "mask":
                return self._mask(node)
            case "upsample":
                return self._upsampled(node)
            case "resample":
                return self._resampled(node)
            case "filter_bank":
                return self._filter_bank(node)
            case "block":
                return self._block(node)
        inputs = {name: self[other] for name, other in node.inputs.items()}
        values, function = dict(node.values), Function(OPERATION_FILES[node.op], node.op)
        if node.matrix:
            encoding = encoding_of(node.matrix)
            values |= {"from_rgb": encoding.from_rgb, "to_rgb": encoding.to_rgb}
        return self.node(ShaderNode(node.kind, node.shape, function, inputs, values=values))

    def _mask(self, node: Node) -> ShaderNode:
        """Return a mask of the source; in the form "es", which has none, `fixed_mask_level`."""
        name = node.values["name"]
        if self._form != "es":
            return self.node(ShaderNode(node.kind, node.shape, mask=name))
        function = Function(OPERATION_FILES["constant_luma"], "constant_luma")
        values = {"level": fixed_mask_level(name)}
        level = self.node(ShaderNode("luma", node.shape, function, values=values))
        if node.kind == "luma":
            return level
        gray = Function(OPERATION_FILES["rgb_from_gray"], "rgb_from_gray")
        return self.node(ShaderNode("color", node.shape, gray, {"luma": level}))

    def _upsampled(self, node: Node) -> ShaderNode:
        chroma = self[node.inputs["chroma"]]
        assert chroma.grid is not None
        values = {"step": chroma.grid.subsampling, "siting": chroma.grid.siting}
        function = Function("frame/between.glsl", "IMAGE_between")
        return self.node(ShaderNode("chroma", node.shape, function, around=chroma, values=values))

    def _resampled(self, node: Node) -> ShaderNode:
        image = self[node.inputs["image"]]
        methods = tuple(METHODS)
        values = {
            "method": methods.index(node.values["method"]),
            "old_size": image.shape[::-1],
            "new_size": node.shape[::-1],
            "border": node.values.get("border", 0),
        }
        return self.node(
            ShaderNode(
                node.kind,
                node.shape,
                Function("frame/resampled.glsl", "resampled", CHANNEL_COUNTS[node.kind]),
                around=image,
                values=values,
                options={"method": methods},
                grid=node.grid,
                page=node.page,
                is_wide=node.is_wide,
                limits=node.limits or UNCLIPPED_RANGE,
            )
        )

    def _block(self, node: Node) -> ShaderNode:
        block = node.block
        assert block is not None
        image = self[node.inputs["image"]]
        pictures = {name: self[other] for name, other in node.inputs.items() if name != "image"}
        values, options = _numbered(block, node.values)
        weights = [name for name, kind in block.injected.items() if kind is LumaWeights]
        values |= {name: encoding_of(node.matrix).weights for name in weights}
        for signature in functions_of_block(block.name):
            call = ShaderNode(
                node.kind,
                node.shape,
                Function(signature.file, signature.name, CHANNEL_COUNTS[node.kind]),
                pictures,
                values=values,
                options=options,
                measure=self._measure(node.measure),
                is_wide=node.is_wide or node in self._exact,
                limits=node.limits,
                moves=Drift in block.injected.values(),
            )
            if block.kind == "filter":
                call = replace(call, around=image, radius=node.radius)
            else:
                call = replace(call, inputs={signature.parameters[0].name: image, **pictures})
            image = self.node(call)
        return image

    def _measure(self, measure: PercentileRequest[Node] | None) -> ShaderPercentileRequest | None:
        if measure is None:
            return None
        if measure not in self._measures:
            self._measures[measure] = replace(cast(Any, measure), of=self[measure.of])
        return self._measures[measure]

    def _filter_bank(self, node: Node) -> ShaderNode:
        """Return luma or chroma after all passes of a bank."""
        run: BankRun = node.values["run"]
        luma = self[node.inputs["luma"]]
        filtered = self[node.inputs[node.kind]]
        chosen: dict[int, ShaderNode] = {}
        for each in run.sequence:
            stage = each.run
            if each.selects:
                chosen[each.stage] = self._chosen(luma, stage)
            if node.kind == "chroma" and stage.bank.chroma is not None:
                of_chroma = replace(stage, bank=stage.bank.of_chroma)
                filtered = self._filtered(filtered, chosen[each.stage], of_chroma)
            if node.kind == "luma" or each.is_read:
                luma = self._filtered(luma, chosen[each.stage], stage)
        return luma if node.kind == "luma" else filtered

    def _filtered(self, image: ShaderNode, chosen: ShaderNode, run: BankRun) -> ShaderNode:
        """Return luma or chroma after one pass."""
        is_luma = image.kind == "luma"
        return self.node(
            ShaderNode(
                image.kind,
                image.shape,
                Function("blade/filtered.glsl", "filtered", CHANNEL_COUNTS[image.kind]),
                {"chosen": chosen},
                around=image,
                radius=run.bank.size // 2,
                values=filter_values(run),
                is_wide=is_luma and run.is_wide,
                limits=run.limits if is_luma else RANGES[image.kind],
            )
        )

    def _chosen(self, luma: ShaderNode, run: BankRun) -> ShaderNode:
        """Return the number of each pixel's filter."""
        chosen = self._of_tensor(luma, run.bank.bins, run.window)
        for feature in run.bank.bins.features:
            level = (
                self._of_mean(luma, feature)
                if feature.needs_mean
                else self._of_tensor(luma, feature.tensor_bins, feature.rho)
            )
            function = Function("blade/mean_level.glsl", "divided_choice")
            inputs = {"chosen": chosen, "level": level}
            values = {"levels": float(feature.bins)}
            chosen = self.node(ShaderNode("luma", luma.shape, function, inputs, values=values))
        return chosen

    def _of_mean(self, luma: ShaderNode, feature: Feature) -> ShaderNode:
        """Return the bin of a local mean, by the filter of the block `gaussian`, or of luma minus it."""
        mean, radius = luma, feature_radius(feature)
        for name in ("gaussian_across", "gaussian"):
            function = Function("blocks/gaussian.glsl", name)
            values = {"sigma": feature.rho}
            mean = self.node(
                ShaderNode("luma", luma.shape, function, around=mean, radius=radius, values=values)
            )
        start, density = map(float, feature.start_and_density)
        values = {"start": start, "density": density, "levels": float(feature.bins)}
        inputs = {"own": luma, "mean": mean} if feature.name == "difference" else {"mean": mean}
        function = Function("blade/mean_level.glsl", f"{feature.name}_level")
        return self.node(ShaderNode("luma", luma.shape, function, inputs, values=values))

    def _of_tensor(self, luma: ShaderNode, bins: Bins, rho: float) -> ShaderNode:
        """Return the bin of each pixel's structure tensor.

        A compute group shares the pixels that it reads. Fragments do not, so that one fragment selects for 2
        x 2 pixels in a separate pass; this is also done if 2 x 2 pixels share a filter.
        """
        if bins.curvatures == 1:
            return self._of_window(luma, bins, rho)
        if self._form == "compute":
            function = Function("blade/chosen_with_angle.glsl", "chosen_with_angle")
            direction = self._around(luma, "direction", function, bins, rho)
        else:
            angle = self._of_four(luma, "four_angles", bins, rho)
            inputs = {"number": self._of_window(luma, bins, rho), "angle": angle}
            function = Function("blade/number_and_angle.glsl", "number_and_angle")
            direction = self.node(ShaderNode("direction", luma.shape, function, inputs))
        function = Function("blade/curved_choice.glsl", "curved_choice")
        values = {
            "curvatures": float(bins.curvatures),
            "per_orientation": float(bins.strengths * bins.coherences),
            "curve": MIDDLE_CURVATURE,
        }
        return self.node(ShaderNode("luma", luma.shape, function, around=direction, radius=1, values=values))

    def _of_window(self, luma: ShaderNode, bins: Bins, rho: float) -> ShaderNode:
        """Return the bin of the tensor without curvature."""
        if self._form == "compute" and bins.pitch == 1:
            function = Function("blade/chosen_filter.glsl", "chosen_filter")
            return self._around(luma, "luma", function, bins, rho)
        return self._of_four(luma, "chosen_filters" if bins.pitch == 1 else "chosen_for_square", bins, rho)

    def _of_four(self, luma: ShaderNode, name: str, bins: Bins, rho: float) -> ShaderNode:
        """Return the result of a function for 2 x 2 pixels at each of these pixels."""
        file = "chosen_for_square" if bins.pitch == 2 else "chosen_filters"
        four = self._around(luma, "choices", Function(f"blade/{file}.glsl", name), bins, rho)
        own = Function("blade/own_choice.glsl", "IMAGE_own_choice")
        return self.node(ShaderNode("luma", luma.shape, own, around=four))

    def _around(
        self, luma: ShaderNode, kind: ShaderKind, function: Function, bins: Bins, rho: float
    ) -> ShaderNode:
        """Return the result of a function of the window around each pixel, or each 2 x 2 pixels."""
        shape, values = luma.shape, choice_values(bins, rho)
        if kind == "choices":
            shape = (shape[0] + 1) // 2, (shape[1] + 1) // 2
        names = {each.name for each in function.signature.parameters}
        values = {name: value for name, value in values.items() if name in names}
        radius = window_radius(rho)
        return self.node(ShaderNode(kind, shape, function, around=luma, radius=radius, values=values))


def _exact_nodes(order: Sequence[Node]) -> set[Node]:
    """Return the nodes to store as float32, as rounding to 16 bits would be visible in later results.

    These are all inputs of directions, and of banks that multiply differences or run at a reduced size, where
    a different filter for one pixel is visible in many; also directions and filtered directions.
    """
    directions: set[Node] = set()
    for node in order:
        block = node.block
        if block and (block.exact or (block.kind == "filter" and node.inputs["image"] in directions)):
            directions.add(node)
    leading = {other for node in order if _is_sensitive(node) for other in node.inputs.values()}
    for node in reversed(order):
        if node in leading:
            leading |= set(node.inputs.values())
    return directions | leading


def _is_sensitive(node: Node) -> bool:
    if node.op == "filter_bank":
        run: BankRun = node.values["run"]
        return run.is_wide or run.scale != 1
    return node.block is not None and node.block.exact


def _numbered(block: Block, values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, tuple[str, ...]]]:
    """Return the values with each choice replaced by its number, and the words of the choices."""
    controls = {name: block.parameters[name].control for name in values}
    options = {name: control.options for name, control in controls.items() if isinstance(control, Choice)}
    numbered = {
        name: options[name].index(value) if name in options else value for name, value in values.items()
    }
    return numbered, options


def choice_values(bins: Bins, rho: float) -> dict[str, Any]:
    """Return the arguments of the functions that select filters."""
    radius = window_radius(rho)
    half = tuple(map(float, half_window(rho, bins.pitch)))
    orientations, strengths, coherences, _, *ranges = (float(number) for number in bins.as_array)
    return {
        "radius": radius,
        "window": half + (0.0,) * (MAX_TAPS - len(half)),
        "bins": (orientations, strengths, coherences),
        "start": (ranges[0], ranges[2]),
        "density": (ranges[1], ranges[3]),
    }


def filter_values(run: BankRun) -> dict[str, Any]:
    """Return the arguments of `filtered`."""
    bank, padding = run.bank, (0.0,) * (MAX_PARTS - len(run.weights))
    # Weights of twenty or more, constants, and weights that cancel make the rounding of half floats visible.
    is_exact = run.is_wide or bank.constants is not None or bank.clips
    limits = tuple(each / 255 for each in bank.clips)
    return {
        "bank": bank.packed if is_exact else bank.packed_in_half,
        "size": bank.size,
        "clip_count": len(limits),
        "clips": (*limits, *(0.0,) * (MAX_CLIPS - len(limits))),
        "part_weights": (*map(float, run.weights), *padding),
        "part_sums": (*bank.sums, *padding),
        "identity": float(run.identity),
    }
