"""Stabilization on the GPU, where planes of earlier pictures stay as textures."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.core.bands import shared_pool
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.gpu.compile.formats import Format, plane_format
from vidstyle.gpu.compile.glsl import Assembly
from vidstyle.gpu.device.programs import Programs
from vidstyle.gpu.device.textures import TexturePool
from vidstyle.stabilize.blend import STILL
from vidstyle.stabilize.motion import MotionEstimator, Warp
from vidstyle.stabilize.stabilizer import (
    Stabilized,
    Stabilizer,
    chroma_ends,
    code_scale,
    result_gain,
    stabilized_encoding,
    with_planes,
)

if TYPE_CHECKING:
    import moderngl

    from vidstyle.gpu.device.runner import BlendWeights, GpuResources, Readback, Runner

WEIGHT = Format(1, "nu2")
WARPED = Format(2, "f4")

log = logging.getLogger("vidstyle")


class GpuStabilizer:
    """Keeps one film steady, on the GPU or, where a page is done in tiles, on the CPU.

    Whoever calls it owns the context.

    Args:
        steady: 0 to 1, as in a style.
        is_fixed: whether the style makes marks that lie still on the page.
        is_tiled: whether the page is done in tiles.
        source: how the planes are encoded that come in; for RGB, what `with_planes` makes of it.
        target: how those of the result are.
    """

    def __init__(
        self,
        resources: GpuResources,
        steady: float,
        is_fixed: bool,
        is_tiled: bool,
        source: Encoding,
        target: Encoding,
    ) -> None:
        self._motion = MotionEstimator(steady, is_fixed)
        self._stage = Stabilizer(steady, is_fixed, shared_pool()) if is_tiled else None
        self._textures = StabilizerTextures(
            resources.context, resources.programs, resources.textures, source, target
        )
        if is_tiled:
            log.info("pictures larger than one texture: the CPU keeps the film steady, which takes longer")

    def change_strength(self, steady: float, is_fixed: bool) -> None:
        """Use other values from the next picture on."""
        (self._stage or self._motion).change_strength(steady, is_fixed)

    def start(
        self, runner: Runner, picture: Picture, time: float, scene_cut: bool, weights: BlendWeights
    ) -> tuple[list[Readback], Stabilized | None]:
        """Start all that is to be done for a picture; what comes second is for `after`."""
        if self._stage is not None:
            stabilized = self._stage.before(picture, time, scene_cut)
            return runner.start(stabilized.picture, weights), stabilized
        self._textures.warp = self._motion.estimate(picture, time, scene_cut)
        return runner.start(with_planes(picture), weights, self._textures), None

    def after(self, result: Picture, stabilized: Stabilized | None) -> Picture:
        """The picture to be shown."""
        return result if self._stage is None or stabilized is None else self._stage.after(result, stabilized)

    def release(self) -> None:
        """Release the textures; framebuffers must be out of use."""
        self._textures.release()


@dataclass
class _DoubleBuffer:
    """The newest texture of a plane, and the one to be drawn next."""

    format: Format
    front: moderngl.Texture
    back: moderngl.Texture

    def swap(self) -> None:
        self.front, self.back = self.back, self.front


class StabilizerTextures:
    """As `Stabilizer`, for planes in textures. Whoever calls it owns the context.

    Args:
        source: how the planes are encoded that come in.
        target: how those of the result are encoded.

    Attributes:
        warp: how the planes before are warped into the next ones; None where a scene begins.
    """

    def __init__(
        self,
        context: moderngl.Context,
        programs: Programs,
        textures: TexturePool,
        source: Encoding,
        target: Encoding,
    ) -> None:
        self._context, self._programs, self._textures = context, programs, textures
        self._source, self._target = source, target
        self.warp: Warp | None = None
        self._buffers: dict[str, _DoubleBuffer] = {}
        self._taken: list[tuple[moderngl.Texture, Format]] = []
        self._scratch: dict[str, moderngl.Texture] = {}
        self._flows: dict[bool, moderngl.Texture] = {}
        self._framebuffers: dict[tuple[int, ...], Any] = {}

    def before(
        self, uploaded: Mapping[str, moderngl.Texture], shapes: Mapping[str, tuple[int, int]]
    ) -> dict[str, moderngl.Texture]:
        """The planes that the style sees, of those that were uploaded: "luma", "blue", "red".

        Args:
            shapes: height and width of each; a texture may be wider.
        """
        self._upload_flow(False, self.warp.flow if self.warp else None)
        self._upload_flow(True, self.warp.strong_flow if self.warp else None)
        names = [name for name in ("luma", "blue", "red") if name in uploaded]
        return {name: self._stabilized(name, uploaded[name], shapes[name]) for name in names}

    def after(self, results: Iterable[tuple[str, moderngl.Texture]]) -> list[moderngl.Texture]:
        """The planes to be shown, of those that the style has made, by their names."""
        self._context.memory_barrier()
        return [self._result(name, texture) for name, texture in results]

    def release(self) -> None:
        """Return the textures and release the rest; framebuffers must be out of use."""
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        for flow in self._flows.values():
            flow.release()
        for texture, coding in self._taken:
            self._textures.give(texture, coding)
        for each in (self._framebuffers, self._flows, self._taken, self._buffers, self._scratch):
            each.clear()

    def _stabilized(self, name: str, plane: moderngl.Texture, shape: tuple[int, int]) -> moderngl.Texture:
        warp = self.warp
        old, new = self._source, stabilized_encoding(self._source)
        ends = (old.luma_levels, new.luma_levels) if name == "luma" else (chroma_ends(old), chroma_ends(new))
        (gain, offset), span = code_scale(*ends)
        buffer = self._buffer_of(name, shape, plane_format(new.depth))
        warped = self._take_once(f"warped {shape}", shape, WARPED)
        weight = 0.0 if warp is None else warp.weight
        values = {
            "size": shape[::-1],
            "luma_step": (1, 1) if name == "luma" else old.step,
            "scale": (gain * plane_format(old.depth).most, offset),
            "white": float(buffer.format.most),
            "blend_weight": weight,
            "rate": 0.0 if warp is None else 1 / (9 * (warp.limit * span) ** 2),
            "guided": name != "luma",
        }
        if weight:
            images = {"plane": plane, "before": buffer.front, "flow": self._flows[False]}
            self._run("warped", images, values, [warped])
        weights = self._take_once(f"weights {name}", shape, WEIGHT)
        guide = weights if name == "luma" else self._scratch["weights luma"]
        images = {"plane": plane, "warped": warped}
        self._run(
            "blended", images | ({} if name == "luma" else {"guide": guide}), values, [buffer.back, weights]
        )
        buffer.swap()
        return buffer.front

    def _result(self, name: str, plane: moderngl.Texture) -> moderngl.Texture:
        shape = plane.height, plane.width
        coding = plane_format(self._target.depth, plane.components)
        deep = plane_format(16 if self._target.depth else 0, plane.components)
        is_new = f"result {name}" not in self._buffers
        buffer = self._buffer_of(f"result {name}", shape, deep)
        codes = self._take_once(f"codes {name}", shape, coding)
        weights = self._scratch.get("weights luma")
        weight = self.warp.result_weight if self.warp and weights and not is_new else 0.0
        values = {
            "size": shape[::-1],
            "luma_step": self._target.step if name in ("blue", "red") else (1, 1),
            "gain": result_gain(self._target),
            "white": float(deep.most),
            "most": float(coding.most),
            "blend_weight": weight,
        }
        images = {"plane": plane, "before": buffer.front, "flow": self._flows[True]}
        self._run("result", images | ({"guide": weights} if weights else {}), values, [buffer.back, codes])
        buffer.swap()
        return codes

    def _run(
        self,
        name: str,
        images: Mapping[str, moderngl.Texture],
        values: Mapping[str, Any],
        targets: list[moderngl.Texture],
    ) -> None:
        program = self._programs.get(_assembly(name))
        for unit, (image, texture) in enumerate(images.items()):
            program.set(image, unit)
            texture.use(unit)
        for word, value in values.items():
            program.set(word, value)
        key = tuple(texture.glo for texture in targets)
        if key not in self._framebuffers:
            self._framebuffers[key] = self._context.framebuffer(targets)
        self._framebuffers[key].use()
        program.run((0, 0), targets[0].size, (1, 1))

    def _upload_flow(self, strong: bool, flow: np.ndarray | None) -> None:
        flow = STILL if flow is None else np.ascontiguousarray(flow, np.float32)
        size = flow.shape[1], flow.shape[0]
        if strong in self._flows and self._flows[strong].size != size:
            self._flows.pop(strong).release()
        if strong not in self._flows:
            self._flows[strong] = self._context.texture(size, 2, dtype="f4")
            self._flows[strong].filter = self._context.NEAREST, self._context.NEAREST
        self._flows[strong].write(flow)

    def _buffer_of(self, name: str, shape: tuple[int, int], coding: Format) -> _DoubleBuffer:
        if name not in self._buffers:
            self._buffers[name] = _DoubleBuffer(coding, self._take(shape, coding), self._take(shape, coding))
        return self._buffers[name]

    def _take_once(self, name: str, shape: tuple[int, int], coding: Format) -> moderngl.Texture:
        if name not in self._scratch:
            self._scratch[name] = self._take(shape, coding)
        return self._scratch[name]

    def _take(self, shape: tuple[int, int], coding: Format) -> moderngl.Texture:
        self._taken.append((self._textures.take(shape, coding, exact=True), coding))
        return self._taken[-1][0]


def planes_layout(picture: Picture) -> PictureLayout:
    """The layout of what `with_planes` makes of such a picture."""
    layout = PictureLayout.of(picture)
    if layout.planes != "color":
        return layout
    return PictureLayout(layout.encoding.as_float(), layout.shape, "chroma")


def stabilized_layout(picture: Picture) -> PictureLayout:
    """The layout of what a style sees of such a picture in a stabilized film."""
    layout = planes_layout(picture)
    return replace(layout, encoding=stabilized_encoding(layout.encoding))


@cache
def _assembly(name: str) -> Assembly:
    """A shader of shaders/stabilize/, assembled once."""
    assembly = Assembly(330)
    assembly.include(f"stabilize/{name}.glsl")
    return assembly
