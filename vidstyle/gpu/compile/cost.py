"""What a plan moves through memory: counted from the plan alone, without a GPU.

Every picture that a pass reads counts once however often it looks at a pixel, because the caches serve what
is read again; every target counts once. So these are the least bytes: a real card moves no fewer, and time on
it is at least these bytes over its bandwidth. Not counted are the histograms of measured steps, about a
megabyte for each picture of any size, and the overlap of tiles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from vidstyle.core.measured import Sampling
from vidstyle.gpu.compile.formats import Format, plane_format, working_format
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader_nodes import ShaderNode
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import Slots
from vidstyle.gpu.compile.targets import RenderTarget
from vidstyle.gpu.compile.tiles import jobs_of
from vidstyle.gpu.device.textures import TexturePool
from vidstyle.style.nodes import Shape


@dataclass(frozen=True)
class Traffic:
    """Bytes for each pixel of the source's page."""

    read: float
    written: float

    @property
    def total(self) -> float:
        """Both ways."""
        return self.read + self.written

    def __add__(self, other: Traffic) -> Traffic:
        return Traffic(self.read + other.read, self.written + other.written)


@dataclass(frozen=True)
class HeldTexture:
    """A texture: its height and width, and what it holds."""

    height: int
    width: int
    format: Format

    @property
    def bytes(self) -> int:
        """What it takes."""
        return self.height * self.width * self.format.bytes


def pass_traffic(plan: Plan, each: Pass) -> Traffic:
    """What one pass reads and writes. One that samples reads only the pixels of its grid."""
    places = _area(Sampling.of(*each.shape).shape if each.sampled else each.shape)
    most = places if each.sampled else None
    read = sum(_image_bytes(plan, image, most) for image in each.images)
    written = sum(_area(target.shape) * target.format.bytes for target in write_shader(plan, each).targets)
    pixels = _area(plan.source.shape)
    return Traffic(read / pixels, written / pixels)


def plan_traffic(plan: Plan) -> Traffic:
    """What all passes together read and write."""
    return sum((pass_traffic(plan, each) for each in plan.passes), Traffic(0, 0))


def upload_bytes(plan: Plan) -> float:
    """Bytes sent to the GPU for each pixel of the source's page, without the padding of rows."""
    return sum(_image_bytes(plan, plane) for plane in plan.planes) / _area(plan.source.shape)


def download_bytes(plan: Plan) -> float:
    """Bytes that come back for each pixel of the source's page."""
    # Of four components in a texture of RGB three come back.
    sizes = (
        _area(target.shape) * target.format.bytes * (3 if target.name == "color" else 4) // 4
        for target in result_targets(plan)
    )
    return sum(sizes) / _area(plan.source.shape)


def result_targets(plan: Plan) -> list[RenderTarget]:
    """The planes of the result that the passes make."""
    targets = (target for each in plan.passes for target in write_shader(plan, each).targets)
    return [target for target in targets if target.is_plane]


def held_textures(plan: Plan, max_side: int) -> list[HeldTexture]:
    """The textures that the passes write, each for several values in turn where that can be.

    Args:
        max_side: pixels that a texture's side may have.
    """
    pool = _Rooms()
    shaders = {each: write_shader(plan, each) for each in plan.passes}
    Slots(cast(TexturePool, pool), plan, jobs_of(plan, max_side), shaders)
    return pool.taken


class _Rooms:
    """Stands where a pool of textures does, and only writes down what is taken."""

    def __init__(self) -> None:
        self.taken: list[HeldTexture] = []

    def take(self, shape: Shape, coding: Format, exact: bool = False) -> HeldTexture:
        self.taken.append(HeldTexture(*shape, coding))
        return self.taken[-1]


def _image_bytes(plan: Plan, image: ShaderNode, most: int | None = None) -> int:
    """Bytes of a picture, or of as many of its pixels as are looked at."""
    area = _area(image.shape)
    return _texel_bytes(plan, image) * (area if most is None else min(area, most))


def _texel_bytes(plan: Plan, image: ShaderNode) -> int:
    if not image.is_plane:
        return working_format(image).bytes
    sample = plane_format(plan.source.encoding.depth).bytes
    return sample * {"luma": 1, "chroma": 2, "color": 3}[image.kind]


def _area(shape: Shape) -> int:
    return shape[0] * shape[1]
