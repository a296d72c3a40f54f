"""Describes the passes of a plan and their memory traffic, without a GPU.

Every texture that a pass reads or writes counts once, even if it reads a pixel several times, as caches serve
repeated reads. The result is a lower bound: time on a card is at least these bytes divided by its bandwidth.
It excludes the histograms of measured steps, about a megabyte for a picture of any size, and the overlap of
tiles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from math import prod
from typing import Any

from vidstyle.core.sampling import Sampling
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import RenderTarget
from vidstyle.gpu.compile.shader_nodes import CHANNEL_COUNTS, Format, ShaderNode, plane_format, working_format
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import Slots, TexturePool
from vidstyle.gpu.compile.tiles import MAX_SIDE, jobs_of
from vidstyle.style.nodes import Shape


@dataclass(frozen=True)
class Traffic:
    """Bytes per pixel of the source's page."""

    read: float
    written: float

    def __add__(self, other: Traffic) -> Traffic:
        return Traffic(self.read + other.read, self.written + other.written)


@dataclass(frozen=True)
class HeldTexture:
    """A texture: its height, width and format."""

    height: int
    width: int
    format: Format

    @property
    def bytes(self) -> int:
        """Size in bytes."""
        return self.height * self.width * self.format.bytes


def pass_traffic(plan: Plan, each: Pass) -> Traffic:
    """Return the traffic of a pass. A pass that samples only reads the pixels of its grid."""
    places = prod(Sampling.of(*each.shape).shape if each.sampled else each.shape)
    most = places if each.sampled else None
    read = sum(_image_bytes(plan, image, most) for image in each.images)
    written = sum(prod(target.shape) * target.format.bytes for target in write_shader(plan, each).targets)
    pixels = prod(plan.source.shape)
    return Traffic(read / pixels, written / pixels)


def plan_traffic(plan: Plan) -> Traffic:
    """Return the total traffic of all passes."""
    return sum((pass_traffic(plan, each) for each in plan.passes), Traffic(0, 0))


def upload_bytes(plan: Plan) -> float:
    """Return the bytes sent to the GPU per pixel of the source's page, without the padding of rows."""
    return sum(_image_bytes(plan, plane) for plane in plan.planes) / prod(plan.source.shape)


def download_bytes(plan: Plan) -> float:
    """Return the bytes read back per pixel of the source's page."""
    # Of the four components of an RGB texture, three are read back.
    sizes = (
        prod(target.shape) * target.format.bytes * (3 if target.name == "color" else 4) // 4
        for target in result_targets(plan)
    )
    return sum(sizes) / prod(plan.source.shape)


def result_targets(plan: Plan) -> list[RenderTarget]:
    """Return the planes of the result that the passes write."""
    targets = (target for each in plan.passes for target in write_shader(plan, each).targets)
    return [target for target in targets if target.is_plane]


def held_textures(plan: Plan, max_side: int) -> list[HeldTexture]:
    """Return the textures that the passes write; values that are not needed at the same time share one.

    Args:
        plan: plan of a style.
        max_side: maximum side of a texture in pixels.
    """
    made: list[HeldTexture] = []

    def make(shape: Shape, coding: Format) -> Any:
        made.append(HeldTexture(*shape, coding))
        return made[-1]

    shaders = {each: write_shader(plan, each) for each in plan.passes}
    Slots(TexturePool(make), plan, jobs_of(plan, max_side), shaders)
    return made


def _image_bytes(plan: Plan, image: ShaderNode, most: int | None = None) -> int:
    """Return the bytes of a picture, or of at most `most` of its pixels."""
    pixels = prod(image.shape) if most is None else min(prod(image.shape), most)
    if not image.is_plane:
        return working_format(image, plan.form).bytes * pixels
    return plane_format(plan.source.encoding.depth).bytes * CHANNEL_COUNTS[image.kind] * pixels


def explain(plan: Plan) -> dict[str, Any]:
    """Return the passes and traffic of a plan as plain data; bytes are per pixel of the source."""
    names, traffic, textures = _names_of_values(plan), plan_traffic(plan), held_textures(plan, MAX_SIDE)
    return {
        "size": _size(plan.source.shape),
        "form": plan.form,
        "passes": [_explain_pass(plan, each, names) for each in plan.passes],
        "textures": len(textures),
        "texture_bytes": sum(texture.bytes for texture in textures),
        "bytes": round(traffic.read + traffic.written, 3),
        "bytes_up": round(upload_bytes(plan), 3),
        "bytes_down": round(download_bytes(plan), 3),
    }


def calls_of(plan: Plan, each: Pass) -> list[str]:
    """Return the functions that a pass calls, in order: "gaussian (across)" for gaussian_across."""
    runs = [(call, len(list(alike))) for call, alike in groupby(map(_call, each.nodes))]
    made = [call if count == 1 else f"{count} x {call}" for call, count in runs]
    if each.sampled:
        return [*made, "sample for " + ", ".join(f"{number:g} %" for number in each.sampled.percentages)]
    chroma = [target for target in write_shader(plan, each).targets if target.name == "blue"]
    if chroma and chroma[0].shape != each.shape:
        made.append("shrunk_chroma")
    return made


def lines_of(explained: dict[str, Any]) -> Iterator[str]:
    """Format the data of `explain` as lines of text."""
    width, height = explained["size"]
    count = len(explained["passes"])
    yield f"{width}x{height}, {explained['form']} form: {count} pass{'' if count == 1 else 'es'}"
    for number, each in enumerate(explained["passes"], 1):
        place = "" if each["size"] == explained["size"] else f"at {each['size'][0]}x{each['size'][1]}: "
        yield f"  {number:2}  {place}{', '.join(each['calls'])}"
        yield f"      reads {', '.join(each['reads']) or 'nothing'}"
        yield f"      writes {', '.join(each['writes'])}"
        yield f"      {each['bytes_read']:.2f} + {each['bytes_written']:.2f} bytes a pixel"
    megabytes = explained["texture_bytes"] / 1e6
    yield f"  textures held: {explained['textures']}, {megabytes:.1f} MB"
    yield f"  bytes a pixel: {explained['bytes']:.2f}"
    yield f"  bytes a pixel up: {explained['bytes_up']:.2f}, down: {explained['bytes_down']:.2f}"


def _explain_pass(plan: Plan, each: Pass, names: dict[ShaderNode, str]) -> dict[str, Any]:
    traffic = pass_traffic(plan, each)
    return {
        "size": _size(each.shape),
        "calls": calls_of(plan, each),
        "reads": [_image(plan, image, names) for image in each.images],
        "writes": [_target(target, names) for target in write_shader(plan, each).targets],
        "bytes_read": round(traffic.read, 3),
        "bytes_written": round(traffic.written, 3),
    }


def _names_of_values(plan: Plan) -> dict[ShaderNode, str]:
    """Name each value that is stored between passes: its kind and a number."""
    stored = (node for each in plan.passes for node in each.stored)
    return {node: f"{node.kind} {number}" for number, node in enumerate(stored, 1)}


def _call(node: ShaderNode) -> str:
    function = node.function
    assert function is not None
    name = function.name.removeprefix("IMAGE_")
    block = function.file.rpartition("/")[2].removesuffix(".glsl")
    part = name.removeprefix(f"{block}_")
    return name if part == name else f"{block} ({part})"


def _image(plan: Plan, image: ShaderNode, names: dict[ShaderNode, str]) -> str:
    if image in names:
        return f"{names[image]} ({_format_name(working_format(image, plan.form))})"
    texture = _format_name(plane_format(plan.source.encoding.depth, 3 if image.kind == "color" else 1))
    return f"the source's {image.kind} ({'2 x ' if image.kind == 'chroma' else ''}{texture})"


def _target(target: RenderTarget, names: dict[ShaderNode, str]) -> str:
    name = {"working": names.get(target.node), "samples": "samples"}.get(target.name)
    return f"{name or f'the result: {target.name}'} ({_format_name(target.format)})"


def _format_name(coding: Format) -> str:
    """Return OpenGL's name of a format.

    >>> _format_name(Format(4, "nu2"))
    'RGBA16'
    """
    return coding.image.upper()


def _size(shape: Shape) -> list[int]:
    return [shape[1], shape[0]]
