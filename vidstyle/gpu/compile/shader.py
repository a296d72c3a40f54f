"""The shader of a pass: its text, and what has to be bound before it runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from vidstyle.core.picture import Encoding
from vidstyle.gpu.compile.formats import Format, levels, plane_format, working_format
from vidstyle.gpu.compile.glsl import TYPES, Assembly, ShaderParameter
from vidstyle.gpu.compile.shader_nodes import CHANNELS, ShaderMeasure, ShaderNode
from vidstyle.gpu.compile.shared import Pair
from vidstyle.gpu.compile.targets import RenderTarget

GROUPS: dict[Pair | None, Pair] = {None: (16, 16), (1, 0): (32, 8), (0, 1): (8, 32)}
"""Invocations across and down in a group of a compute pass: more in the direction in which its filters read,
because neighbours in that direction read the same pixels."""


@dataclass(frozen=True)
class ImageOf:
    """A picture that a sampler reads; `part` is 1 for the second plane, red difference."""

    node: ShaderNode
    part: int = 0


@dataclass
class Shader:
    """The text of a pass and what has to be bound before it runs.

    Attributes:
        assembly: the text, and the files that it comes from.
        targets: what it writes, in the order of the bindings.
        uniforms: values by the names of uniforms.
        samplers: what each reads: a picture, the numbers of a measure, or an asset's arrays.
        groups: pixels across and down for each group of a compute pass.
    """

    assembly: Assembly
    targets: list[RenderTarget] = field(default_factory=list)
    uniforms: dict[str, Any] = field(default_factory=dict)
    samplers: dict[str, ImageOf | ShaderMeasure | tuple] = field(default_factory=dict)
    groups: Pair = GROUPS[None]

    def add_sampler(self, name: str, kind: str, what: ImageOf | ShaderMeasure | tuple) -> None:
        """Declare a sampler, and keep what it reads."""
        self.assembly.add(f"uniform {kind} {name};")
        self.samplers[name] = what

    def add_uniform(self, name: str, parameter: ShaderParameter, value: Any) -> str:
        """Declare a uniform unless it is there, keep its value, and return its name."""
        count = f"[{parameter.count}]" if parameter.count else ""
        if name not in self.uniforms:
            self.assembly.add(f"uniform {parameter.type} {name}{count};")
        self.uniforms[name] = value
        return name


SWIZZLES = {1: "r", 2: "rg", 3: "rgb", 4: "rgba"}


def declare_image(shader: Shader, node: ShaderNode, name: str, encoding: Encoding) -> None:
    """Declare a picture and NAME_at, which reads it at a pixel of the page.

    Args:
        encoding: of the source's planes.
    """
    shader.assembly.add(f"uniform ivec2 {name}_origin, {name}_last;")
    shader.add_sampler(name, "sampler2D", ImageOf(node))
    words = {
        "IMAGE": name,
        "VALUE": TYPES[CHANNELS[node.kind]],
        "CHANNELS": SWIZZLES[CHANNELS[node.kind]],
    }
    if node.is_plane:
        _declare_plane(shader, node, name, encoding, words)
    else:
        _declare_levels(shader, name, working_format(node), words)


def _declare_plane(
    shader: Shader, node: ShaderNode, name: str, encoding: Encoding, words: dict[str, str]
) -> None:
    zero, one = levels(encoding, node.kind)
    top = plane_format(encoding.depth).most
    gain, offset = 1 / (one - zero), -zero / (one - zero)
    if node.kind == "chroma":
        shader.add_sampler(f"{name}_red", "sampler2D", ImageOf(node, 1))
        shader.assembly.add(f"const float {name}_gain = {top * gain}, {name}_offset = {offset};")
        shader.assembly.add_template("frame/plane_chroma.glsl", words)
    elif encoding.depth == 0:
        _declare_levels(shader, name, plane_format(0), words)
    else:
        numbers = f"{name}_top = {float(top)}, {name}_gain = {gain}, {name}_offset = {offset}"
        shader.assembly.add(f"const float {numbers};")
        shader.assembly.add_template("frame/plane_value.glsl", words)


def _declare_levels(shader: Shader, name: str, coding: Format, words: dict[str, str]) -> None:
    """Declare what reads a texture whose numbers stand for a range of values, or for themselves."""
    shader.assembly.add(f"const float {name}_low = {coding.low}, {name}_span = {coding.span};")
    shader.assembly.add_template("frame/image.glsl", words)
