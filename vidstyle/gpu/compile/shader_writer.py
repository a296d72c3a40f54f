"""Writes the shader of a pass: uniforms, included GLSL files, and calls of their functions in order.

The source does not depend on the values of parameters, which become uniforms: moving a slider compiles
nothing, unless it changes the amount of shared memory that a filter needs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vidstyle.core.codes import chroma_radius
from vidstyle.errors import VidstyleError
from vidstyle.gpu.compile.glsl import VALUE_TYPES, Assembly, ShaderParameter, signatures
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import (
    GROUP_SIZES,
    Shader,
    declare_image,
    declare_targets,
    shrinks,
    store_planes,
    store_working,
    targets_of,
)
from vidstyle.gpu.compile.shader_nodes import CHANNEL_COUNTS, ShaderNode
from vidstyle.gpu.compile.shared import VALUE_BYTES, Pair, sharing_of

TILE_SIZES: dict[Pair | None, Pair] = {None: (32, 16), (1, 0): (32, 16), (0, 1): (16, 32)}
"""Pixels across and down that a work group computes if it averages chroma."""


def write_shader(plan: Plan, each: Pass) -> Shader:
    """Write the shader of one pass of a plan, in the plan's form.

    Raises:
        VidstyleError: a GLSL function has a parameter that its block does not declare.
    """
    return _Writer(plan, each).shader


class _Writer:
    def __init__(self, plan: Plan, each: Pass) -> None:
        self._plan, self._pass = plan, each
        self._names: dict[ShaderNode, str] = {}
        self._images = {node: f"image_{number}" for number, node in enumerate(each.images)}
        self.shader = Shader(Assembly(plan.form))
        self._text = self.shader.assembly
        if plan.form != "es" and any(node.kind == "choices" for node in each.nodes):
            self._text.add("#extension GL_ARB_texture_gather : enable")
        self._shrinks = shrinks(plan, each)
        self._sharing = sharing_of(each) if plan.form == "compute" else None
        self._area = self.shader.groups = GROUP_SIZES[self._sharing.line if self._sharing else None]
        self._declare_targets()
        for node, name in self._images.items():
            declare_image(self.shader, node, name, plan)
        self._declare_sharing()
        loads = [line for node in each.loads for line in self._load(node)]
        body = [line for node in each.nodes for line in self._compute(node)]
        self._write_prepare()
        self._write_evaluate(loads, body)
        self._text.include("frame/main_planes.glsl" if self._shrinks else "frame/main.glsl")

    def _declare_targets(self) -> None:
        self._text.add("uniform ivec2 origin, size, corner, stride, page;")
        self.shader.targets = targets_of(self._plan, self._pass)
        groups = self.shader.groups if self._plan.form == "compute" else None
        declare_targets(self._text, self.shader.targets, groups)
        if self._shrinks:
            self._declare_tile()

    def _declare_tile(self) -> None:
        target = self._plan.target
        rims = [chroma_radius(target, axis) for axis in (0, 1)]
        tile = self.shader.groups = TILE_SIZES[self._sharing.line if self._sharing else None]
        self._area = tile[0] + sum(rims[0]), tile[1] + sum(rims[1])
        for name, (across, down) in {
            "TILE": tile,
            "RIM_BEFORE": (rims[0][0], rims[1][0]),
            "AREA": self._area,
            "STEP": target.step,
        }.items():
            self._text.add(f"const ivec2 {name} = ivec2({across}, {down});")
        self._text.add(f"const vec2 SITING = vec2{target.siting};", "const int INVOCATIONS = 256;")
        blue = [target.name for target in self.shader.targets].index("blue")
        self._text.include("frame/code.glsl")
        lines = store_planes(self._text, target, "chroma", "value", blue)
        self._text.add("void store_chroma(ivec2 place, vec2 value) {", *lines, "}")

    def _declare_sharing(self) -> None:
        used = VALUE_BYTES[2] * self._area[0] * self._area[1] if self._shrinks else 0
        capacities = self._sharing.capacities(self._area, used) if self._sharing else None
        if self._sharing is None or capacities is None:
            self._sharing = None
            return
        self._text.add(f"#define AROUND_ROOM {capacities[0]}")
        if self._sharing.prepares:
            self._text.add(f"#define PREPARED_ROOM {capacities[1]}")
        self._text.add("uniform ivec2 around_radius;")
        self.shader.uniforms["around_radius"] = self._sharing.radius
        image = self._sharing.image
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
            self._text.include(node.function.file, node.function.channels)
        parameters = node.function.signature.parameters
        arguments = ", ".join(self._argument(node, number, each) for each in parameters)
        name = self._names[node] = f"value_{number}"
        call = f"{function}({arguments})"
        if node.limits:
            limits = self.shader.add_uniform(
                f"limits_{number}", ShaderParameter("vec2", "limits"), node.limits
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
        if self._sharing is not None:
            return
        reads = "chroma_at" if node.function.name == "shrunk_chroma" else "picture_at"
        self._text.add_once(f"{type_name} {reads}(ivec2 at) {{ return {image}_at(at); }}")

    def _argument(self, node: ShaderNode, number: int, parameter: ShaderParameter) -> str:
        name = parameter.name.rstrip("_")  # added to names that are keywords of GLSL
        if name in node.inputs:
            return self._names[node.inputs[name]]
        if name == "at":
            return "at"
        if name == "page":
            return self.shader.add_uniform(f"page_{number}", parameter, (node.shape[1], node.shape[0]))
        if name == "moment":
            self._text.add_once("uniform uint moment;")
            return "moment"
        if name == "measured" and node.measure is not None:
            self.shader.add_sampler(f"measured_{number}", "sampler2D", node.measure)
            return f"texelFetch(measured_{number}, ivec2(0), 0).{'xyzw'[: len(node.measure.percentages)]}"
        if parameter.type == "sampler2DArray" and name in node.values:
            self.shader.add_sampler(f"{name}_{number}", parameter.type, node.values[name] or ())
            return f"{name}_{number}"
        return self.shader.add_uniform(f"{name}_{number}", parameter, self._value(node, parameter))

    def _value(self, node: ShaderNode, parameter: ShaderParameter) -> Any:
        """Return a parameter that is the same for all pixels.

        NAME_count and NAME_sizes describe the asset NAME, NAME_size an asset that is a single array.
        """
        name = parameter.name.rstrip("_")
        owner, _, what = name.rpartition("_")
        if name in node.values:
            return node.values[name]
        if what == "count" and owner in node.values:
            return len(node.values[owner] or ())
        if what == "size" and owner in node.values:
            return node.values[owner][0].shape[::-1]
        if what == "sizes" and owner in node.values:
            sizes = [array.shape[::-1] for array in node.values[owner] or ()]
            return [*sizes, *[(1, 1)] * (parameter.count - len(sizes))]
        if parameter.type == "float":  # an optional saved picture that is not set
            return 1.0
        file = node.function.file if node.function else ""
        raise VidstyleError(f"shaders/{file}", f"unknown parameter {parameter.name!r}", "correct it")

    def _write_prepare(self) -> None:
        """Write the function that all invocations of a work group run together before the first pixel."""
        if self._plan.form != "compute":
            return
        lines = ["load_around(first, area);"] if self._sharing else []
        node = self._sharing.prepares if self._sharing else None
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
        stores = [line for number in range(len(self.shader.targets)) for line in self._store(number)]
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
        target = self.shader.targets[number]
        name = self._names[target.node]
        if not target.is_plane:
            return [store_working(self.shader, self._plan.form, name, number)]
        if target.name == "blue" and self._shrinks or target.name == "red":
            return []
        return store_planes(self._text, self._plan.target, target.node.kind, name, number)
