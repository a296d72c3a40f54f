"""How a shader reads pictures: textures that earlier passes wrote, and the planes of the source."""

from __future__ import annotations

from vidstyle.core.picture import Encoding
from vidstyle.gpu.formats import levels, plane_format, working_format
from vidstyle.gpu.includes import TYPES
from vidstyle.gpu.nodes import CHANNELS, Node
from vidstyle.gpu.shader import ImageOf, Shader

SWIZZLES = {1: "r", 2: "rg", 3: "rgb", 4: "rgba"}


def declare_image(shader: Shader, node: Node, name: str, encoding: Encoding) -> None:
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
        coding = working_format(node)
        shader.assembly.add(f"const float {name}_low = {coding.low}, {name}_span = {coding.span};")
        shader.assembly.add_template("frame/image.glsl", words)


def _declare_plane(shader: Shader, node: Node, name: str, encoding: Encoding, words: dict[str, str]) -> None:
    zero, one = levels(encoding, node.kind)
    top = plane_format(encoding.depth).most
    gain, offset = 1 / (one - zero), -zero / (one - zero)
    if node.kind == "chroma":
        shader.add_sampler(f"{name}_red", "sampler2D", ImageOf(node, 1))
        shader.assembly.add(f"const float {name}_gain = {top * gain}, {name}_offset = {offset};")
        shader.assembly.add_template("frame/plane_chroma.glsl", words)
    elif encoding.depth == 0:
        shader.assembly.add_template("frame/float_value.glsl", words)
    else:
        numbers = f"{name}_top = {float(top)}, {name}_gain = {gain}, {name}_offset = {offset}"
        shader.assembly.add(f"const float {numbers};")
        shader.assembly.add_template("frame/plane_value.glsl", words)
