"""Writes the shader of a pass: uniforms, included GLSL files, and calls of their functions in order.

The source does not depend on the values of parameters, which become uniforms: moving a slider writes and
compiles nothing, unless it changes the amount of shared memory that a filter needs.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.errors import VidstyleError
from vidstyle.gpu.compile.glsl import VALUE_TYPES, Assembly, ShaderParameter, signatures
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import (
    DRIFT,
    Shader,
    ShaderText,
    declare_image,
    declare_targets,
    shrinks,
    store_planes,
    store_working,
    targets_of,
)
from vidstyle.gpu.compile.shader_key import shader_key
from vidstyle.gpu.compile.shader_nodes import CHANNEL_COUNTS, ShaderNode
from vidstyle.gpu.compile.shared import Pair, sharing_of
from vidstyle.gpu.compile.work_group import work_group_of

MAX_TEXTS = 1000
"""Number of texts that are kept; a style has up to thirty."""

_texts: dict[object, ShaderText] = {}
_texts_lock = threading.Lock()


def write_shader(plan: Plan, each: Pass) -> Shader:
    """Return the shader of one pass of a plan, in the plan's form; write its text only if it is new.

    Raises:
        VidstyleError: a GLSL function has a parameter that its block does not declare.
    """
    key = shader_key(plan, each)
    with _texts_lock:
        text = _texts.pop(key, None) or _Writer(plan, each).shader
        _texts[key] = text  # at the end, as the most recently used
        if len(_texts) > MAX_TEXTS:
            del _texts[next(iter(_texts))]
    uniforms = {name: take(each) for name, take in text.uniforms.items()}
    samplers = {name: take(each) for name, take in text.samplers.items()}
    return Shader(text, targets_of(plan, each), uniforms, samplers)


class _Writer:
    def __init__(self, plan: Plan, each: Pass) -> None:
        self._plan, self._pass = plan, each
        self._names: dict[ShaderNode, str] = {}
        self._group = work_group_of(plan, each)
        self._targets = targets_of(plan, each)
        self._shrinks = shrinks(plan, each)
        self.shader = ShaderText(Assembly(plan.form), self._group.written)
        self._text = self.shader.assembly
        if plan.form != "es" and any(node.kind == "choices" for node in each.nodes):
            self._text.add("#extension GL_ARB_texture_gather : enable")
        self._declare_targets()
        self._images = {
            node: declare_image(self.shader, node, number, plan) for number, node in enumerate(each.images)
        }
        self._declare_sharing()
        loads = [line for node in each.loads for line in self._load(node)]
        body = [line for node in each.nodes for line in self._compute(node)]
        self._write_prepare()
        self._write_evaluate(loads, body)
        self._text.include("frame/main_planes.glsl" if self._shrinks else "frame/main.glsl")

    def _declare_targets(self) -> None:
        self._text.add("uniform ivec2 origin, size, corner, stride, page;")
        invocations = self._group.invocations if self._plan.form == "compute" else None
        declare_targets(self._text, self._targets, invocations)
        if self._shrinks:
            self._declare_tile()

    def _declare_tile(self) -> None:
        target, group = self._plan.target, self._group
        for name, (across, down) in {
            "TILE": group.written,
            "RIM_BEFORE": (group.rims[0][0], group.rims[1][0]),
            "AREA": group.computed,
            "STEP": target.subsampling,
        }.items():
            self._text.add(f"const ivec2 {name} = ivec2({across}, {down});")
        self._text.add(f"const vec2 SITING = vec2{target.siting};", "const int INVOCATIONS = 256;")
        blue = [target.name for target in self._targets].index("blue")
        self._text.include("frame/code.glsl")
        lines = store_planes(self._text, target, "chroma", "value", blue)
        self._text.add("void store_chroma(ivec2 place, vec2 value) {", *lines, "}")

    def _declare_sharing(self) -> None:
        sharing, capacities = self._group.sharing, self._group.capacities
        if sharing is None or capacities is None:
            return
        self._text.add(f"#define AROUND_ROOM {capacities[0]}")
        if sharing.prepares:
            self._text.add(f"#define PREPARED_ROOM {capacities[1]}")
        self.shader.add_uniform("around_radius", ShaderParameter("ivec2", "around_radius"), _shared_radius)
        image = sharing.image
        words = {"IMAGE": self._images[image], "VALUE": VALUE_TYPES[CHANNEL_COUNTS[image.kind]]}
        self._text.add_template("frame/around.glsl", words)

    def _load(self, node: ShaderNode) -> list[str]:
        """Return lines that load a picture at the pixel; `between` reads chroma on another grid instead."""
        if node.grid is not None and node.shape != self._pass.shape:
            return []
        name = self._names[node] = f"loaded_{len(self._names)}"
        return [f"{VALUE_TYPES[CHANNEL_COUNTS[node.kind]]} {name} = {self._images[node]}_at(at);"]

    def _compute(self, node: ShaderNode) -> list[str]:
        assert node.function is not None
        number = len(self._names)
        for parameter, words in node.options.items():
            for option, word in enumerate(words):
                owner = Path(node.function.file).stem
                self._text.add_once(f"const int {owner}_{parameter}_{word} = {option};")
        if node.is_enlarged:
            function = self._add_enlarging(node)
        else:
            function = node.function.name
            if node.around is not None:
                self._add_around(node)
            if node.moves:
                self._add_drift()
            self._text.include(node.function.file, node.function.channels)
        parameters = node.function.signature.parameters
        arguments = ", ".join(self._argument(node, number, each) for each in parameters)
        name = self._names[node] = f"value_{number}"
        call = f"{function}({arguments})"
        if node.limits:
            limits = self._add_uniform(
                f"limits_{number}", ShaderParameter("vec2", "limits"), node, lambda own: own.limits
            )
            call = f"clamp({call}, {limits}.x, {limits}.y)"
        return [f"{VALUE_TYPES[CHANNEL_COUNTS[node.kind]]} {name} = {call};"]

    def _add_enlarging(self, node: ShaderNode) -> str:
        assert node.around is not None and node.function is not None
        image = self._images[node.around]
        name = node.function.name.replace("IMAGE", image)
        self._add_template_once(node.function.file, name, {"IMAGE": image})
        return name

    def _add_template_once(self, file: str, name: str, words: dict[str, str]) -> None:
        """Add a template once for all calls of its function of this name."""
        if not any(f"{name}(" in line for line in self._text.lines):
            self._text.add_template(file, words)

    def _add_around(self, node: ShaderNode) -> None:
        assert node.around is not None and node.function is not None
        type_name, image = VALUE_TYPES[CHANNEL_COUNTS[node.around.kind]], self._images[node.around]
        if node.kind == "choices":
            self._add_template_once("blade/quad.glsl", "quad_at", {"IMAGE": image})
            return
        if self._group.sharing is not None:
            return
        reads = "chroma_at" if node.function.name == "shrunk_chroma" else "picture_at"
        self._text.add_once(f"{type_name} {reads}(ivec2 at) {{ return {image}_at(at); }}")

    def _add_drift(self) -> None:
        """Add the function for the movement of marks, which is 0 on a page in a browser."""
        if self._plan.form == "es":
            self._text.include("lib/no_drift.glsl")
        elif DRIFT not in self.shader.samplers:
            self.shader.add_sampler(DRIFT, "sampler2D", lambda each: DRIFT)
            self._text.include("lib/drift.glsl")

    def _argument(self, node: ShaderNode, number: int, parameter: ShaderParameter) -> str:
        name = parameter.name.rstrip("_")  # added to names that are keywords of GLSL
        if name in node.inputs:
            return self._names[node.inputs[name]]
        if name == "at":
            return "at"
        if name == "page":
            return self._add_uniform(f"page_{number}", parameter, node, lambda own: own.shape[::-1])
        if name == "moment":
            self._text.add_once("uniform uint moment;")
            return "moment"
        if name == "measured" and node.measure is not None:
            self._add_sampler(f"measured_{number}", "sampler2D", node, lambda own: own.measure)
            return f"texelFetch(measured_{number}, ivec2(0), 0).{'xyzw'[: len(node.measure.percentages)]}"
        if parameter.type == "sampler2DArray" and name in node.values:
            self._add_sampler(f"{name}_{number}", parameter.type, node, lambda own: own.values[name] or ())
            return f"{name}_{number}"
        take = _value_taker(node, parameter)
        return self._add_uniform(f"{name}_{number}", parameter, node, take)

    def _add_uniform(
        self, name: str, parameter: ShaderParameter, node: ShaderNode, take: Callable[[ShaderNode], Any]
    ) -> str:
        """Declare a uniform whose value comes from this node of the pass."""
        place = self._pass.nodes.index(node)
        return self.shader.add_uniform(name, parameter, lambda each: take(each.nodes[place]))

    def _add_sampler(self, name: str, kind: str, node: ShaderNode, take: Callable[[ShaderNode], Any]) -> None:
        """Declare a sampler whose input comes from this node of the pass."""
        place = self._pass.nodes.index(node)
        self.shader.add_sampler(name, kind, lambda each: take(each.nodes[place]))

    def _write_prepare(self) -> None:
        """Write the function that all invocations of a work group run together before the first pixel."""
        if self._plan.form != "compute":
            return
        sharing = self._group.sharing
        lines = ["load_around(first, area);"] if sharing else []
        node = sharing.prepares if sharing else None
        if node is not None:
            assert node.function is not None
            name = f"{node.function.name}_prepare"
            parameters = signatures(node.function.file)[name].parameters
            number = int(self._names[node].rpartition("_")[2])
            lines.append(f"{name}({', '.join(self._argument(node, number, each) for each in parameters)});")
        self._text.add("void prepare(ivec2 first, ivec2 area) {", *(f"    {line}" for line in lines), "}")

    def _write_evaluate(self, loads: list[str], body: list[str]) -> None:
        self._text.include("frame/code.glsl")
        result = self._pass.result
        chroma = next((node for node in result.nodes if node.kind == "chroma"), None) if result else None
        returned = self._names[chroma] if chroma and self._shrinks else "vec2(0.0)"
        stores = [line for number in range(len(self._targets)) for line in self._store(number)]
        self._text.add(
            "// Compute the values at a pixel of the page; store them at a place of the targets if `own`.",
            "vec2 evaluate(ivec2 at, ivec2 place, bool own) {",
            *(f"    {line}" for line in [*loads, *body]),
            "    if (own) {",
            *(f"        {line}" for line in stores),
            "    }",
            f"    return {returned};",
            "}",
        )

    def _store(self, number: int) -> list[str]:
        target = self._targets[number]
        name = self._names[target.node]
        if not target.is_plane:
            return [store_working(self._text, self._plan.form, target, name, number)]
        if target.name == "blue" and self._shrinks or target.name == "red":
            return []
        return store_planes(self._text, self._plan.target, target.node.kind, name, number)


def _value_taker(node: ShaderNode, parameter: ShaderParameter) -> Callable[[ShaderNode], Any]:
    """Return the function that takes a parameter, the same for all pixels, from nodes like this one.

    NAME_count and NAME_sizes describe the asset NAME, NAME_size an asset that is a single array.

    Raises:
        VidstyleError: nodes have no such parameter.
    """
    name = parameter.name.rstrip("_")
    owner, _, what = name.rpartition("_")
    if name in node.values:
        return lambda own: own.values[name]
    if what == "count" and owner in node.values:
        return lambda own: len(own.values[owner] or ())
    if what == "size" and owner in node.values:
        return lambda own: own.values[owner][0].shape[::-1]
    if what == "sizes" and owner in node.values:
        return lambda own: _padded_sizes(own.values[owner] or (), parameter.count)
    if parameter.type == "float":  # an optional saved picture that is not set
        return lambda own: 1.0
    file = node.function.file if node.function else ""
    raise VidstyleError(f"shaders/{file}", f"unknown parameter {parameter.name!r}", "correct it")


def _padded_sizes(arrays: tuple[np.ndarray, ...], count: int) -> list[tuple[int, ...]]:
    """Return width and height of each array, and 1 x 1 up to a number of arrays."""
    sizes = [array.shape[::-1] for array in arrays]
    return [*sizes, *[(1, 1)] * (count - len(sizes))]


def _shared_radius(each: Pass) -> Pair:
    sharing = sharing_of(each)
    assert sharing is not None
    return sharing.radius
