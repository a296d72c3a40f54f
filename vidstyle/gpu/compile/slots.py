"""Allocates textures for the values of a plan; values that are not needed at the same time share one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import Shader
from vidstyle.gpu.compile.shader_nodes import Format, ShaderNode, working_format
from vidstyle.gpu.compile.tiles import Job
from vidstyle.style.nodes import Shape, T

if TYPE_CHECKING:
    import moderngl


MAX_AREA_RATIO = 2
"""Maximum ratio of the area of a texture to the area of the picture in it."""


class TexturePool:
    """Textures for reuse. The caller owns the context.

    Args:
        make: creates a texture of a height and width.
    """

    def __init__(self, make: Callable[[Shape, Format], moderngl.Texture]) -> None:
        self._make = make
        self._free: list[tuple[Format, moderngl.Texture]] = []

    def take(self, shape: Shape, coding: Format, exact: bool = False) -> moderngl.Texture:
        """Return a texture of at least this height and width: the smallest free one, or a new one.

        Args:
            exact: whether it must not be larger.
        """
        fitting = [free for free in self._free if free[0] == coding and fits(free[1], shape, exact)]
        if not fitting:
            return self._make(shape, coding)
        best = min(fitting, key=lambda free: free[1].width * free[1].height)
        self._free.remove(best)
        return best[1]

    def give(self, texture: moderngl.Texture, coding: Format) -> None:
        """Return a texture to the pool."""
        self._free.append((coding, texture))

    def clear(self) -> None:
        """Release all free textures."""
        for _, texture in self._free:
            texture.release()
        self._free.clear()


class Slots:
    """The textures that a plan writes. The caller owns the context.

    Attributes:
        nodes: the texture of each stored value.
        samples: the texture with the samples of each measure.
    """

    def __init__(self, pool: TexturePool, plan: Plan, jobs: list[Job], shaders: dict[Pass, Shader]) -> None:
        self._pool = pool
        # Textures of a framebuffer have the same size; textures that a compute shader writes may be larger.
        self._exact = plan.form != "compute"
        self._shaders = shaders
        self._taken: list[tuple[moderngl.Texture, Format]] = []
        self.nodes = self._place(plan, jobs)
        self.samples = {
            each.sampled: self._take(target.shape, target.format)
            for each, shader in shaders.items()
            for target in shader.targets
            if each.sampled and target.name == "samples"
        }
        self._results = {
            name: self._take(shape, coding, exact=True)
            for (name, coding), shape in shapes_of_results(jobs, shaders).items()
        }

    def texture(self, each: Pass, number: int) -> moderngl.Texture:
        """Return the texture of a pass's target."""
        target = self._shaders[each].targets[number]
        if target.name == "working":
            return self.nodes[target.node]
        if target.name == "samples":
            assert each.sampled is not None
            return self.samples[each.sampled]
        return self._results[target.name]

    def release(self) -> None:
        """Return all textures to the pool."""
        for texture, coding in self._taken:
            self._pool.give(texture, coding)
        self._taken.clear()

    def _take(self, shape: Shape, coding: Format, exact: bool = False) -> moderngl.Texture:
        texture = self._pool.take(shape, coding, exact or self._exact)
        self._taken.append((texture, coding))
        return texture

    def _place(self, plan: Plan, jobs: list[Job]) -> dict[ShaderNode, moderngl.Texture]:
        """Assign a texture to each stored value; textures are reused when their value is no longer read."""
        needed, found, reused = shapes_of_stored(jobs), dict[ShaderNode, Any](), TexturePool(self._take)
        for number, each in enumerate(plan.passes):
            for node in each.stored:
                found[node] = reused.take(needed[node], working_format(node, plan.form), self._exact)
            for node in ending(plan, number):
                reused.give(found[node], working_format(node, plan.form))
        return found


def shapes_of_stored(jobs: list[Job]) -> dict[ShaderNode, Shape]:
    """Return the size of the texture of each stored value: the size of its largest window."""
    shapes: dict[ShaderNode, Shape] = {}
    for job in jobs:
        for each in job.passes:
            for node in each.stored:
                _grow(shapes, node, job.windows[each].shape)
    return shapes


def shapes_of_results(jobs: list[Job], shaders: dict[Pass, Shader]) -> dict[tuple[str, Format], Shape]:
    """Return the size of the texture of each plane of the result."""
    shapes: dict[tuple[str, Format], Shape] = {}
    for job in jobs:
        for target in (target for each in job.passes for target in shaders[each].targets if target.is_plane):
            _grow(shapes, (target.name, target.format), job.result_window(target.name).shape)
    return shapes


def _grow(shapes: dict[T, Shape], key: T, shape: Shape) -> None:
    """Enlarge a shape to contain a window of this height and width."""
    old = shapes.get(key, (1, 1))
    shapes[key] = max(old[0], shape[0]), max(old[1], shape[1])


def ending(plan: Plan, number: int) -> list[ShaderNode]:
    """Return the stored values that no later pass reads."""
    later = {image for each in plan.passes[number + 1 :] for image in each.images}
    now = plan.passes[number]
    alive = dict.fromkeys(node for each in plan.passes[: number + 1] for node in each.stored)
    return [node for node in alive if node not in later and (node in now.images or node in now.stored)]


def fits(texture: moderngl.Texture, shape: Shape, exact: bool) -> bool:
    """Whether a texture can hold a picture of this height and width."""
    size = texture.height, texture.width
    if exact:
        return size == shape
    enough = size[0] >= shape[0] and size[1] >= shape[1]
    return enough and size[0] * size[1] <= MAX_AREA_RATIO * shape[0] * shape[1]
