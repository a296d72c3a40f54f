"""The passes of a plan in words, for people and programs: without a GPU."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import Any

from vidstyle.core.picture import Encoding, PictureLayout
from vidstyle.gpu.compile.cost import (
    download_bytes,
    held_textures,
    pass_traffic,
    plan_traffic,
    upload_bytes,
)
from vidstyle.gpu.compile.formats import Format, plane_format, working_format
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Form, Plan, make_plan
from vidstyle.gpu.compile.shader_nodes import ShaderNode
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.targets import RenderTarget
from vidstyle.gpu.session import MAX_SIDE
from vidstyle.style import Style
from vidstyle.style.nodes import Shape
from vidstyle.style.resolve import resolve


def plan_for_video(style: Style, width: int, height: int, form: Form) -> Plan:
    """The plan for the commonest pictures: 4:2:0, 8 bit.

    Raises:
        StyleError: an asset of the style cannot be read.
    """
    source = PictureLayout(Encoding(), (height, width), "chroma")
    return make_plan(style, resolve(style, height, width), source, source.encoding, False, form)


def explain(plan: Plan) -> dict[str, Any]:
    """What the plan does and moves: sizes are width and height, bytes those for each pixel of the source."""
    names = _names_of_values(plan)
    rooms = held_textures(plan, MAX_SIDE)
    return {
        "size": _size(plan.source.shape),
        "form": plan.form,
        "passes": [_explain_pass(plan, each, names) for each in plan.passes],
        "textures": len(rooms),
        "texture_bytes": sum(room.bytes for room in rooms),
        "bytes": round(plan_traffic(plan).total, 3),
        "bytes_up": round(upload_bytes(plan), 3),
        "bytes_down": round(download_bytes(plan), 3),
    }


def calls_of(plan: Plan, each: Pass) -> list[str]:
    """What a pass computes, in order: functions by their names, "gaussian (across)" for gaussian_across."""
    runs = [(call, len(list(alike))) for call, alike in groupby(map(_call, each.nodes))]
    made = [call if count == 1 else f"{count} x {call}" for call, count in runs]
    if each.sampled:
        return [*made, "sample for " + ", ".join(f"{number:g} %" for number in each.sampled.percentages)]
    chroma = [target for target in write_shader(plan, each).targets if target.name == "blue"]
    if chroma and chroma[0].shape != each.shape:
        made.append("shrunk_chroma")
    return made


def lines_of(explained: dict[str, Any]) -> Iterator[str]:
    """What `explain` says, for people."""
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
    """A name for each value between passes: its kind, and a number of its own."""
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
        return f"{names[image]} ({_format_name(working_format(image))})"
    texture = _format_name(plane_format(plan.source.encoding.depth, 3 if image.kind == "color" else 1))
    return f"the source's {image.kind} ({'2 x ' if image.kind == 'chroma' else ''}{texture})"


def _target(target: RenderTarget, names: dict[ShaderNode, str]) -> str:
    name = {"working": names.get(target.node), "samples": "samples"}.get(target.name)
    return f"{name or f'the result: {target.name}'} ({_format_name(target.format)})"


def _format_name(coding: Format) -> str:
    """As OpenGL calls it.

    >>> _format_name(Format(4, "nu2"))
    'RGBA16'
    """
    channels = {1: "R", 2: "RG", 3: "RGB", 4: "RGBA"}[coding.components]
    return channels + {"f1": "8", "nu2": "16", "f4": "32F"}[coding.dtype]


def _size(shape: Shape) -> list[int]:
    return [shape[1], shape[0]]
