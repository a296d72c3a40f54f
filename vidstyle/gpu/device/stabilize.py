"""The stage that keeps films steady, on the GPU: what was drawn before stays there as textures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.core.picture import Encoding
from vidstyle.gpu.compile.formats import Format, plane_format
from vidstyle.gpu.compile.glsl import Assembly
from vidstyle.gpu.device.programs import Programs
from vidstyle.gpu.device.textures import TexturePool
from vidstyle.stabilize.blend import STILL
from vidstyle.stabilize.motion import Warp
from vidstyle.stabilize.stabilizer import chroma_ends, code_scale, result_gain, steady_encoding

if TYPE_CHECKING:
    import moderngl

WEIGHT = Format(1, "nu2")
MOVED = Format(2, "f4")


@dataclass
class _Kept:
    """What a plane has become, and room for what comes next."""

    format: Format
    now: moderngl.Texture
    other: moderngl.Texture

    def turn(self) -> None:
        """Let what has just been drawn be the present."""
        self.now, self.other = self.other, self.now


class StabilizerTextures:
    """As `vidstyle.stabilize.stabilizer.Steady`, for textures. Whoever calls it owns the context.

    Args:
        source: how the planes are encoded that come in.
        target: how those of the result are encoded.
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
        self._kept: dict[str, _Kept] = {}
        self._taken: list[tuple[moderngl.Texture, Format]] = []
        self._scratch: dict[str, moderngl.Texture] = {}
        self._flows: dict[bool, moderngl.Texture] = {}
        self._framebuffers: dict[tuple[int, ...], Any] = {}

    def before(
        self, sent: Mapping[str, moderngl.Texture], shapes: Mapping[str, tuple[int, int]], carry: Warp | None
    ) -> dict[str, moderngl.Texture]:
        """The planes that the style is to see, of those that were sent: "luma", "blue", "red".

        Args:
            shapes: height and width of each; a texture may be wider.
            carry: how the planes before are carried on; None where nothing is.
        """
        self._send_flow(False, None if carry is None else carry.flow)
        self._send_flow(True, None if carry is None else carry.strong_flow)
        names = [name for name in ("luma", "blue", "red") if name in sent]
        return {name: self._steadied(name, sent[name], shapes[name], carry) for name in names}

    def after(
        self, results: Iterable[tuple[str, moderngl.Texture]], carry: Warp | None
    ) -> list[moderngl.Texture]:
        """The planes to be shown, of those that the style has made, by their names."""
        self._context.memory_barrier()
        return [self._shown(name, texture, carry) for name, texture in results]

    def release(self) -> None:
        """Give the textures back and let go of the rest; framebuffers must be out of use."""
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        for flow in self._flows.values():
            flow.release()
        for texture, coding in self._taken:
            self._textures.give(texture, coding)
        for each in (self._framebuffers, self._flows, self._taken, self._kept, self._scratch):
            each.clear()

    def _steadied(
        self, name: str, plane: moderngl.Texture, shape: tuple[int, int], carry: Warp | None
    ) -> moderngl.Texture:
        old, new = self._source, steady_encoding(self._source)
        ends = (old.luma_levels, new.luma_levels) if name == "luma" else (chroma_ends(old), chroma_ends(new))
        (gain, offset), span = code_scale(*ends)
        kept = self._kept_of(name, shape, plane_format(new.depth))
        moved = self._take_once(f"moved {shape}", shape, MOVED)
        share = 0.0 if carry is None else carry.share
        values = {
            "size": shape[::-1],
            "across_down": (1, 1) if name == "luma" else old.step,
            "scale": (gain * plane_format(old.depth).most, offset),
            "white": float(kept.format.most),
            "share": share,
            "rate": 0.0 if carry is None else 1 / (9 * (carry.limit * span) ** 2),
            "guided": name != "luma",
        }
        if share:
            images = {"plane": plane, "before": kept.now, "flow": self._flows[False]}
            self._run("moved", images, values, [moved])
        weights = self._take_once(f"weights {name}", shape, WEIGHT)
        guide = weights if name == "luma" else self._scratch["weights luma"]
        images = {"plane": plane, "moved": moved}
        self._run(
            "mixed", images | ({} if name == "luma" else {"guide": guide}), values, [kept.other, weights]
        )
        kept.turn()
        return kept.now

    def _shown(self, name: str, plane: moderngl.Texture, carry: Warp | None) -> moderngl.Texture:
        shape = plane.height, plane.width
        coding = plane_format(self._target.depth, plane.components)
        deep = plane_format(16 if self._target.depth else 0, plane.components)
        is_new = f"shown {name}" not in self._kept
        kept = self._kept_of(f"shown {name}", shape, deep)
        codes = self._take_once(f"codes {name}", shape, coding)
        weights = self._scratch.get("weights luma")
        share = 0.0 if carry is None or is_new or weights is None else carry.share_of_result
        values = {
            "size": shape[::-1],
            "across_down": self._target.step if name in ("blue", "red") else (1, 1),
            "gain": result_gain(self._target),
            "white": float(deep.most),
            "most": float(coding.most),
            "share": share,
        }
        images = {"plane": plane, "before": kept.now, "flow": self._flows[True]}
        self._run("shown", images | ({"guide": weights} if weights else {}), values, [kept.other, codes])
        kept.turn()
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

    def _send_flow(self, strong: bool, flow: np.ndarray | None) -> None:
        flow = STILL if flow is None else np.ascontiguousarray(flow, np.float32)
        size = flow.shape[1], flow.shape[0]
        if strong in self._flows and self._flows[strong].size != size:
            self._flows.pop(strong).release()
        if strong not in self._flows:
            self._flows[strong] = self._context.texture(size, 2, dtype="f4")
            self._flows[strong].filter = self._context.NEAREST, self._context.NEAREST
        self._flows[strong].write(flow)

    def _kept_of(self, name: str, shape: tuple[int, int], coding: Format) -> _Kept:
        if name not in self._kept:
            self._kept[name] = _Kept(coding, self._take(shape, coding), self._take(shape, coding))
        return self._kept[name]

    def _take_once(self, name: str, shape: tuple[int, int], coding: Format) -> moderngl.Texture:
        if name not in self._scratch:
            self._scratch[name] = self._take(shape, coding)
        return self._scratch[name]

    def _take(self, shape: tuple[int, int], coding: Format) -> moderngl.Texture:
        self._taken.append((self._textures.take(shape, coding, exact=True), coding))
        return self._taken[-1][0]


@cache
def _assembly(name: str) -> Assembly:
    """A shader of the stage; put together once, not for every picture."""
    assembly = Assembly(330)
    assembly.include(f"steady/{name}.glsl")
    return assembly
