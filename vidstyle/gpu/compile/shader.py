"""The shader of a pass: its source, its render targets, and the uniforms and samplers to bind."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

from vidstyle.core.picture import MASK_ENCODING, Encoding
from vidstyle.core.sampling import Sampling
from vidstyle.gpu.compile.glsl import VALUE_TYPES, Assembly, Form, ShaderParameter
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader_nodes import (
    CHANNEL_COUNTS,
    Format,
    ShaderKind,
    ShaderNode,
    ShaderPercentileRequest,
    levels,
    plane_format,
    sample_format,
    working_format,
)
from vidstyle.gpu.compile.shared import Pair


@dataclass(frozen=True)
class RenderTarget:
    """A texture that a pass writes.

    Attributes:
        name: "working" for the result of a node that later passes read, "samples" for samples to measure, or
            the
            plane of the result: "luma", "blue", "red", "color".
        node: the node that is written.
        format: format of the texture.
        shape: height and width of the texture.
    """

    name: str
    node: ShaderNode
    format: Format
    shape: tuple[int, int]

    @property
    def is_plane(self) -> bool:
        """Whether it is a plane of the result."""
        return self.name not in ("working", "samples")


@dataclass(frozen=True)
class ImageOf:
    """A picture that a sampler reads; `part` is 1 for the second plane, red difference."""

    node: ShaderNode
    part: int = 0


DRIFT: Literal["drift"] = "drift"
"""The input of a sampler that reads the drift of the marks of a film."""
SamplerInput = ImageOf | ShaderPercentileRequest | tuple | Literal["drift"]
"""The input of a sampler: a picture, the percentiles of a measure, an asset's arrays, or `DRIFT`."""


@dataclass(eq=False)
class ShaderText:
    """The source of a shader, which holds no number of a style, and where a pass has its numbers.

    Attributes:
        assembly: its source and the files of the source.
        groups: pixels across and down that a group of a compute pass writes.
        uniforms: for each uniform a function that takes its value from a pass.
        types: types of the uniforms: GLSL's name, and the length of an array, or 0.
        samplers: for each sampler a function that takes its input from a pass.
    """

    assembly: Assembly
    groups: Pair
    uniforms: dict[str, Callable[[Pass], Any]] = field(default_factory=dict)
    types: dict[str, tuple[str, int]] = field(default_factory=dict)
    samplers: dict[str, Callable[[Pass], SamplerInput]] = field(default_factory=dict)

    @cached_property
    def digest(self) -> str:
        """A text that stands for the finished source."""
        return hashlib.sha256(self.assembly.text.encode()).hexdigest()

    def add_sampler(self, name: str, kind: str, take: Callable[[Pass], SamplerInput]) -> None:
        """Declare a sampler and record where its input comes from."""
        self.assembly.add(f"uniform {kind} {name};")
        self.samplers[name] = take

    def add_uniform(self, name: str, parameter: ShaderParameter, take: Callable[[Pass], Any]) -> str:
        """Declare a uniform unless it exists, record where its value comes from, and return its name."""
        count = f"[{parameter.count}]" if parameter.count else ""
        if name not in self.uniforms:
            self.assembly.add(f"uniform {parameter.type} {name}{count};")
        self.uniforms[name], self.types[name] = take, (parameter.type, parameter.count)
        return name


@dataclass(frozen=True)
class Shader:
    """The shader of a pass, and the uniforms and samplers to bind.

    Attributes:
        text: its source, shared by passes that differ only in numbers.
        targets: textures that it writes, in the order of the bindings.
        uniforms: values by name.
        samplers: the input of each sampler.
    """

    text: ShaderText
    targets: list[RenderTarget]
    uniforms: dict[str, Any]
    samplers: dict[str, SamplerInput]

    @property
    def assembly(self) -> Assembly:
        return self.text.assembly


def declare_image(shader: ShaderText, node: ShaderNode, number: int, plan: Plan) -> str:
    """Declare picture `number` of a pass, and NAME_at, which reads it at a pixel of the page; return NAME."""
    name = f"image_{number}"
    shader.assembly.add(f"uniform ivec2 {name}_origin, {name}_last;")
    shader.add_sampler(name, "sampler2D", lambda each: ImageOf(each.images[number]))
    words = {
        "IMAGE": name,
        "VALUE": VALUE_TYPES[CHANNEL_COUNTS[node.kind]],
        "CHANNELS": "rgba"[: CHANNEL_COUNTS[node.kind]],
    }
    if node.is_plane:
        if node.kind == "chroma":
            shader.add_sampler(f"{name}_red", "sampler2D", lambda each: ImageOf(each.images[number], 1))
        encoding = MASK_ENCODING if node.mask else plan.source.encoding
        _declare_plane(shader, node, name, encoding, words)
    elif plan.form == "es" and node.kind == "luma":
        shader.assembly.add_template("frame/image_halves.glsl", words)
    else:
        _declare_levels(shader, name, working_format(node, plan.form), words)
    return name


def _declare_plane(
    shader: ShaderText, node: ShaderNode, name: str, encoding: Encoding, words: dict[str, str]
) -> None:
    zero, one = levels(encoding, node.kind)
    top = plane_format(encoding.depth).most
    gain, offset = 1 / (one - zero), -zero / (one - zero)
    if node.kind == "chroma":
        shader.assembly.add(f"const float {name}_gain = {top * gain}, {name}_offset = {offset};")
        shader.assembly.add_template("frame/plane_chroma.glsl", words)
    elif encoding.depth == 0:
        _declare_levels(shader, name, plane_format(0), words)
    else:
        numbers = f"{name}_top = {float(top)}, {name}_gain = {gain}, {name}_offset = {offset}"
        shader.assembly.add(f"const float {numbers};")
        shader.assembly.add_template("frame/plane_value.glsl", words)


def _declare_levels(shader: ShaderText, name: str, coding: Format, words: dict[str, str]) -> None:
    """Declare functions that read a texture and convert its numbers to values."""
    shader.assembly.add(f"const float {name}_low = {coding.low}, {name}_span = {coding.span};")
    shader.assembly.add_template("frame/image.glsl", words)


def targets_of(plan: Plan, each: Pass) -> list[RenderTarget]:
    """Return the textures that the pass writes, in the order of the bindings."""
    targets = [
        RenderTarget("working", node, working_format(node, plan.form), node.shape) for node in each.stored
    ]
    if each.sampled:
        node = each.sampled.of
        shape = Sampling.of(*node.shape).shape
        targets.append(RenderTarget("samples", node, sample_format(plan.form), shape))
    for node in each.result.nodes if each.result else ():
        targets += _planes_of(plan, node)
    return targets


def _planes_of(plan: Plan, node: ShaderNode) -> list[RenderTarget]:
    encoding, shape = plan.target, plan.source.shape
    if node.kind == "color":
        return [RenderTarget("color", node, plane_format(encoding.depth, 4), shape)]
    if node.kind == "luma":
        return [RenderTarget("luma", node, plane_format(encoding.depth), shape)]
    small = encoding.chroma_shape(*shape)
    return [RenderTarget(name, node, plane_format(encoding.depth), small) for name in ("blue", "red")]


def shrinks(plan: Plan, each: Pass) -> bool:
    """Whether the pass averages chroma to the result's grid."""
    result = each.result
    if result is None or result.role != "planes" or plan.target.subsampling == (1, 1):
        return False
    return any(node.kind == "chroma" for node in result.nodes)


def declare_targets(text: Assembly, targets: list[RenderTarget], invocations: Pair | None) -> None:
    """Declare render targets, and functions `store_0`, `store_1` and so on that write to them.

    Args:
        invocations: number across and down in a group of a compute pass; None in a fragment pass.
    """
    if invocations is not None:
        text.add(f"layout(local_size_x = {invocations[0]}, local_size_y = {invocations[1]}) in;")
    for number, target in enumerate(targets):
        name = f"target_{number}"
        if invocations is not None:
            text.add(f"layout({target.format.image}, binding = {number}) writeonly uniform image2D {name};")
            store = f"imageStore({name}, place, value);"
        else:
            text.add(f"layout(location = {number}) out vec4 {name};")
            store = f"{name} = value;"
        text.add(f"void store_{number}(ivec2 place, vec4 value) {{ {store} }}")


def store_working(text: Assembly, form: Form, target: RenderTarget, name: str, number: int) -> str:
    """Return the line that stores a named value in target `number`, for later passes."""
    if form == "es" and target.node.kind == "luma":
        text.add_once("uniform bool halved;")
        text.include("frame/halves.glsl")
        return f"store_{number}(place, halves({name}, halved));"
    coding, padding = target.format, ", 0.0" * (4 - CHANNEL_COUNTS[target.node.kind])
    return f"store_{number}(place, vec4(({name} - {coding.low}) / {coding.span}{padding}));"


def store_planes(text: Assembly, encoding: Encoding, kind: ShaderKind, name: str, number: int) -> list[str]:
    """Return lines that store a named value in planes of the result, from target `number` on."""
    zero, one = levels(encoding, kind)
    coding = plane_format(encoding.depth)
    numbers = f"{zero}, {one}, {float(2**encoding.depth - 1)}, {float(coding.most)}"
    names = [f"{name}.x", f"{name}.y"] if kind == "chroma" else [name]
    if encoding.depth:
        text.include("frame/code.glsl", 3 if kind == "color" else 1)
        names = [f"code({each}, {numbers})" for each in names]
    elif kind == "color":
        names = [f"clamp({name}, 0.0, 1.0)"]
    padding = "1.0" if kind == "color" else "0.0, 0.0, 1.0"
    return [f"store_{number + offset}(place, vec4({each}, {padding}));" for offset, each in enumerate(names)]
