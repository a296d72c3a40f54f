"""What the plans on one context share: programs, textures, transfers and percentiles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from vidstyle.gpu.compile.shader import Shader
from vidstyle.gpu.compile.shader_nodes import WORKING_FORMATS, ShaderPercentileRequest
from vidstyle.gpu.compile.slots import TexturePool
from vidstyle.gpu.device.percentiles import GpuPercentiles
from vidstyle.gpu.device.programs import Programs
from vidstyle.gpu.device.textures import AssetTextures, new_texture
from vidstyle.gpu.device.transfer import Download, Upload

if TYPE_CHECKING:
    import moderngl


class GpuResources:
    """Resources that the plans on one context share. The caller owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.programs = Programs(context)
        self.textures = TexturePool(partial(new_texture, context))
        self.assets = AssetTextures(context)
        self.upload = Upload(context)
        self.download = Download(context)
        self._percentiles: dict[tuple[str, int], GpuPercentiles] = {}
        self._unused_percentiles: list[GpuPercentiles] = []
        self._framebuffers: dict[tuple[int, ...], moderngl.Framebuffer] = {}
        self._unused = context.framebuffer([context.renderbuffer((1, 1))])

    def draw_into(self, textures: Sequence[moderngl.Texture]) -> None:
        """Make the following fragment shaders draw into these textures of the pool."""
        key = tuple(texture.glo for texture in textures)
        if key not in self._framebuffers:
            self._framebuffers[key] = self.context.framebuffer(textures)
        self._framebuffers[key].use()

    def percentiles_of(self, measure: ShaderPercentileRequest) -> GpuPercentiles:
        """Return the percentiles of a measured step."""
        if measure.step not in self._percentiles:
            coding, unused = WORKING_FORMATS["luma"], self._unused_percentiles
            new = unused.pop() if unused else GpuPercentiles(self.context, coding.low, coding.span)
            self._percentiles[measure.step] = new
        return self._percentiles[measure.step]

    def forget_percentiles(self) -> None:
        """Forget all percentiles before the structure of the steps changes; keep their programs."""
        for each in self._percentiles.values():
            each.restart()
            self._unused_percentiles.append(each)
        self._percentiles = {}

    def trim(self, shaders: Iterable[Shader]) -> None:
        """Release textures, framebuffers and programs that these shaders do not use."""
        shaders = list(shaders)
        self.programs.trim(shader.assembly for shader in shaders)
        samplers = (what for shader in shaders for what in shader.samplers.values())
        self.assets.trim(what for what in samplers if isinstance(what, tuple))
        # When moderngl creates a framebuffer it rebinds the current one, which fails if that was released.
        self._unused.use()
        while self._framebuffers:
            self._framebuffers.popitem()[1].release()
        self.textures.clear()
