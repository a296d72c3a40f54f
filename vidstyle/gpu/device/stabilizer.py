"""Temporal stabilization on the GPU, with planes of the previous frame in textures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.compile.glsl import Assembly
from vidstyle.gpu.compile.shader_nodes import Format, plane_format
from vidstyle.gpu.device.gpu_resources import GpuResources
from vidstyle.stabilize.motion import MotionEstimator, Warp
from vidstyle.stabilize.segment import SEGMENT_SIZE
from vidstyle.stabilize.stabilizer import (
    code_scale,
    plane_step,
    result_gain,
    stabilized_encoding,
)
from vidstyle.stabilize.travel import DriftFollower
from vidstyle.stabilize.warp import in_segments
from vidstyle.style.nodes import Shape

if TYPE_CHECKING:
    import moderngl

WEIGHT_FORMAT = Format(1, "nu2")
WARPED_FORMAT = Format(2, "f4")


class GpuStabilizer:
    """Does the same as `Stabilizer` for planes in textures. The caller owns the context.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style draws marks fixed to the page.
        source: encoding of the input planes.
        target: encoding of the planes of the result.
        follows: whether the style draws marks that move with the film.

    Attributes:
        drift: how far they have moved in the last picture; None for none.
    """

    def __init__(
        self,
        resources: GpuResources,
        steady: float,
        is_fixed: bool,
        source: Encoding,
        target: Encoding,
        follows: bool = False,
    ) -> None:
        self._resources = resources
        self._motion = MotionEstimator(steady, is_fixed, follows)
        self._marks = DriftFollower() if follows else None
        self.drift: np.ndarray | None = None
        self._source, self._target = source, target
        self._warp: Warp | None = None
        self._taken: dict[str, tuple[moderngl.Texture, Format]] = {}
        self._newest: dict[str, int] = {}

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        self._motion.change_strength(steady, is_fixed)

    def estimate(self, picture: Picture, time: float, scene_cut: bool) -> None:
        """Estimate the warp of the previous planes into the planes of this picture."""
        pair = self._motion.follow(picture, time, scene_cut)
        self._warp = pair.warp() if pair else None
        self.drift = self._marks.follow(picture, self._warp) if self._marks else None

    def before(
        self, uploaded: Mapping[str, moderngl.Texture], shapes: Mapping[str, Shape]
    ) -> dict[str, moderngl.Texture]:
        """Stabilize the uploaded planes "luma", "blue" and "red" for the style; return them with all others.

        Args:
            shapes: height and width of each plane; a texture may be wider.
        """
        names = [name for name in ("luma", "blue", "red") if name in uploaded]
        return {**uploaded, **{name: self._stabilize(name, uploaded[name], shapes[name]) for name in names}}

    def after(self, results: Iterable[tuple[str, moderngl.Texture]]) -> list[moderngl.Texture]:
        """Stabilize the named planes of the style's result."""
        self._resources.context.memory_barrier()
        return [self._stabilize_result(name, texture) for name, texture in results]

    def release(self) -> None:
        """Return the textures to the pool."""
        for texture, coding in self._taken.values():
            self._resources.textures.give(texture, coding)
        self._taken.clear()

    def _stabilize(self, name: str, plane: moderngl.Texture, shape: Shape) -> moderngl.Texture:
        warp, old, new = self._warp, self._source, stabilized_encoding(self._source)
        (gain, offset), span = code_scale(name, old, new)
        coding = plane_format(new.depth)
        newest, next_one = self._newest_and_next(name, shape, coding)
        warped = self._take(f"warped {shape}", shape, WARPED_FORMAT)
        values = {
            "size": shape[::-1],
            "segment": SEGMENT_SIZE,
            "luma_step": plane_step(name, old),
            "scale": (gain * plane_format(old.depth).most, offset),
            "white": float(coding.most),
            "blend_weight": warp.weight if warp else 0.0,
            "rate": 1 / (9 * (warp.limit * span) ** 2) if warp else 0.0,
            "guided": name != "luma",
        }
        if warp and warp.weight:
            flow = in_segments(warp.flow, shape[1], plane_step(name, old))
            images = {"plane": plane, "before": newest, "flow": self._grid("slight flow", flow)}
            self._run("warped", images, values, [warped])
        weights = self._take(f"weights {name}", shape, WEIGHT_FORMAT)
        images = {"plane": plane, "warped": warped}
        if name != "luma":
            images["guide"] = self._taken["weights luma"][0]
        self._run("blended", images, values, [next_one, weights])
        return next_one

    def _stabilize_result(self, name: str, plane: moderngl.Texture) -> moderngl.Texture:
        shape, target, warp = (plane.height, plane.width), self._target, self._warp
        coding = plane_format(target.depth, plane.components)
        deep = plane_format(16 if target.depth else 0, plane.components)
        is_new, step = f"result {name}" not in self._newest, plane_step(name, target)
        newest, next_one = self._newest_and_next(f"result {name}", shape, deep)
        codes = self._take(f"codes {name}", shape, coding)
        images = {
            "plane": plane,
            "before": newest,
            "flow": self._grid(
                "result flow", in_segments(warp.result_flow if warp else None, shape[1], step)
            ),
            "segment_weights": self._grid(
                "segment weights", in_segments(warp.result_guide if warp else None, shape[1])
            ),
        }
        weights, _ = self._taken.get("weights luma", (None, None))
        if weights:
            images["guide"] = weights
        values = {
            "size": shape[::-1],
            "segment": SEGMENT_SIZE,
            "luma_step": step,
            "gain": result_gain(target),
            "white": float(deep.most),
            "most": float(coding.most),
            "blend_weight": warp.result_weight if warp and weights and not is_new else 0.0,
        }
        self._run("result", images, values, [next_one, codes])
        return codes

    def _run(
        self,
        name: str,
        images: Mapping[str, moderngl.Texture],
        values: Mapping[str, Any],
        targets: list[moderngl.Texture],
    ) -> None:
        program = self._resources.programs.get(_assembly(name))
        for unit, (image, texture) in enumerate(images.items()):
            program.set(image, unit)
            texture.use(unit)
        for word, value in values.items():
            program.set(word, value)
        self._resources.draw_into(targets)
        program.run((0, 0), targets[0].size, (1, 1))

    def _grid(self, name: str, grid: np.ndarray) -> moderngl.Texture:
        """Return a texture with a grid of segments, h x w x 2, or h x w x 1 for two equal components."""
        texture = self._take(f"{name} {grid.shape}", (grid.shape[0], grid.shape[1]), WARPED_FORMAT)
        texture.write(np.ascontiguousarray(np.broadcast_to(grid, (*grid.shape[:2], 2))))
        return texture

    def _newest_and_next(
        self, name: str, shape: Shape, coding: Format
    ) -> tuple[moderngl.Texture, moderngl.Texture]:
        """Return the newest texture of a plane, and the texture to draw next, which becomes the newest."""
        old = self._newest.get(name, 0)
        self._newest[name] = 1 - old
        return self._take(f"{name} {old}", shape, coding), self._take(f"{name} {1 - old}", shape, coding)

    def _take(self, name: str, shape: Shape, coding: Format) -> moderngl.Texture:
        """Return the texture of this name, taken from the pool at first use."""
        if name not in self._taken:
            self._taken[name] = self._resources.textures.take(shape, coding, exact=True), coding
        return self._taken[name][0]


@cache
def _assembly(name: str) -> Assembly:
    """Return a shader of shaders/stabilize/, assembled once."""
    assembly = Assembly("fragment")
    assembly.include(f"stabilize/{name}.glsl")
    return assembly
