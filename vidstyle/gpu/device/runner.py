"""Runs a plan on the GPU: binds textures and values, draws the passes, fetches the planes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.core.measured import Sampling
from vidstyle.core.picture import Picture
from vidstyle.gpu.compile.formats import WORKING
from vidstyle.gpu.compile.nodes import ShaderMeasure, ShaderNode
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import ImageOf, Shader
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import Slots
from vidstyle.gpu.compile.tiles import Job, Window, jobs_of
from vidstyle.gpu.device.percentiles import Percentiles
from vidstyle.gpu.device.programs import Programs
from vidstyle.gpu.device.stabilizer import StabilizerTextures
from vidstyle.gpu.device.textures import AssetTextures, TexturePool
from vidstyle.gpu.device.transfer import Download, PlaneTransfer, Upload

if TYPE_CHECKING:
    import moderngl

BlendWeights = Mapping[tuple[str, int], float]
"""For each measured step how far its numbers go towards the new measure, 0..1."""


@dataclass(frozen=True)
class Readback:
    """Planes of one tile of the result on their way from the GPU.

    Attributes:
        windows: where each plane lies, in its own samples, by its name.
    """

    transfer: PlaneTransfer
    windows: dict[str, Window]


class GpuResources:
    """What all plans on one context share. Whoever calls it owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.programs = Programs(context)
        self.textures = TexturePool(context)
        self.assets = AssetTextures(context)
        self.upload = Upload(context)
        self.download = Download(context)
        self._percentiles: dict[tuple[str, int], Percentiles] = {}
        self._nowhere = context.framebuffer([context.renderbuffer((1, 1))])

    def draw_nowhere(self) -> None:
        """Take the framebuffer out of use, so that it can be let go.

        Whatever makes another one puts the one in use back afterwards, which fails if that is gone.
        """
        self._nowhere.use()

    def percentiles_of(self, measure: ShaderMeasure) -> Percentiles:
        """What remembers the numbers of a measured step."""
        if measure.step not in self._percentiles:
            coding = WORKING["luma"]
            self._percentiles[measure.step] = Percentiles(self.context, coding.low, coding.span)
        return self._percentiles[measure.step]

    def forget_percentiles(self) -> None:
        """Let go of what measured steps remember: another style comes."""
        while self._percentiles:
            self._percentiles.popitem()[1].release()

    def trim(self, shaders: Iterable[Shader]) -> None:
        """Release textures and programs that have no use once these shaders run."""
        shaders = list(shaders)
        self.programs.trim(shader.assembly for shader in shaders)
        samplers = (what for shader in shaders for what in shader.samplers.values())
        self.assets.trim(what for what in samplers if isinstance(what, tuple))
        self.textures.clear()

    def release(self) -> None:
        """Let go of everything."""
        self.forget_percentiles()
        for each in (self.programs, self.upload, self.download, self.assets, self._nowhere):
            each.release()
        self.textures.clear()


class Runner:
    """A plan with its programs and textures on the GPU. Whoever calls it owns the context."""

    def __init__(self, resources: GpuResources, plan: Plan, max_side: int) -> None:
        self._resources = resources
        self.plan = plan
        self._shaders = {each: write_shader(plan, each) for each in plan.passes}
        self._jobs = jobs_of(plan, max_side)
        self._slots = Slots(resources.textures, plan, self._jobs, self._shaders)
        self._programs = {
            each: resources.programs.get(shader.assembly) for each, shader in self._shaders.items()
        }
        resources.trim(self._shaders.values())
        self._framebuffers: dict[tuple[int, ...], Any] = {}
        self._numbers: dict[ShaderMeasure, moderngl.Texture] = {}

    @property
    def is_tiled(self) -> bool:
        """Whether the page is done in parts."""
        return len(self._jobs) > 1

    def start(
        self, picture: Picture, weights: BlendWeights, stabilizer: StabilizerTextures | None = None
    ) -> list[Readback]:
        """Start all that is to be done for a picture; nothing here waits for the GPU.

        Args:
            picture: of the plan's layout, or of planes that `stabilizer` brings to it.
            weights: of the new percentiles of each measured step.
            stabilizer: keeps the film steady; not for a page that is done in parts.
        """
        found = (self._run_job(job, picture, weights, stabilizer) for job in self._jobs)
        return [fetch for fetch in found if fetch is not None]

    def release(self) -> None:
        """Give textures back and let go of the rest."""
        self._resources.draw_nowhere()
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        self._framebuffers.clear()
        self._slots.release()

    def _run_job(
        self, job: Job, picture: Picture, weights: BlendWeights, stabilizer: StabilizerTextures | None
    ) -> Readback | None:
        arrays = {
            name: plane[window.top : window.bottom, window.left : window.right]
            for node, window in job.planes.items()
            for name, plane in _arrays_of(node, picture).items()
        }
        sent = self._resources.upload.send(arrays)
        if stabilizer is not None:
            shapes = {name: (plane.shape[0], plane.shape[1]) for name, plane in arrays.items()}
            sent = stabilizer.before(sent, shapes)
        for each in job.passes:
            self._run_pass(job, each, sent)
            if each.sampled is not None and job.ends_measure:
                self._measure(each.sampled, weights)
        results = [
            (target, self._slots.texture(each, number))
            for each in job.passes
            for number, target in enumerate(self._shaders[each].targets)
            if target.is_plane
        ]
        if not results:
            return None
        windows = {target.name: job.result_window(target.name) for target, _ in results}
        textures = [texture for _, texture in results]
        if stabilizer is not None:
            textures = stabilizer.after(zip(windows, textures, strict=True))
        transfer = self._resources.download.begin(
            [(texture, 3 if name == "color" else 1) for name, texture in zip(windows, textures, strict=True)],
            [window.shape for window in windows.values()],
        )
        return Readback(transfer, windows)

    def _run_pass(self, job: Job, each: Pass, sent: Mapping[str, moderngl.Texture]) -> None:
        shader, program = self._shaders[each], self._programs[each]
        for name, value in shader.uniforms.items():
            program.set(name, value)
        for unit, (name, what) in enumerate(shader.samplers.items()):
            program.set(name, unit)
            self._texture_of(what, sent).use(unit)
            if isinstance(what, ImageOf):
                window = job.window_of(what.node)
                program.set(f"{name}_origin", (window.left, window.top))
                program.set(f"{name}_last", (what.node.shape[1] - 1, what.node.shape[0] - 1))
        corner, size, origin, stride = job.area(each)
        for name, pair in {"origin": origin, "size": size, "corner": corner}.items():
            program.set(name, pair)
        program.set("stride", (stride, stride))
        program.set("page", each.shape[::-1])
        self._bind_targets(each, shader)
        program.run(corner, size, shader.groups)

    def _texture_of(self, what: ImageOf | ShaderMeasure | tuple, sent: Mapping[str, moderngl.Texture]) -> Any:
        if isinstance(what, ShaderMeasure):
            return self._numbers[what]
        if not isinstance(what, ImageOf):
            return self._resources.assets.get(what)
        if what.node.is_plane:
            return sent[_names_of(what.node)[what.part]]
        return self._slots.texture_of_node(what.node)

    def _bind_targets(self, each: Pass, shader: Shader) -> None:
        textures = [self._slots.texture(each, number) for number in range(len(shader.targets))]
        if self.plan.form == "compute":
            for number, texture in enumerate(textures):
                texture.bind_to_image(number, read=False, write=True)
            return
        key = tuple(texture.glo for texture in textures)
        if key not in self._framebuffers:
            self._framebuffers[key] = self._resources.context.framebuffer(textures)
        self._framebuffers[key].use()

    def _measure(self, measure: ShaderMeasure, weights: BlendWeights) -> None:
        height, width = Sampling.of(*measure.of.shape).shape
        samples = self._slots.samples(measure)
        self._numbers[measure] = self._resources.percentiles_of(measure).follow(
            samples, (width, height), measure.percentages, weights[measure.step]
        )


def _names_of(node: ShaderNode) -> Sequence[str]:
    return ("blue", "red") if node.kind == "chroma" else (node.kind,)


def _arrays_of(node: ShaderNode, picture: Picture) -> dict[str, np.ndarray]:
    planes = {"luma": (picture.luma,), "chroma": picture.chroma, "color": (picture.color,)}[node.kind]
    assert planes is not None
    return {name: plane for name, plane in zip(_names_of(node), planes, strict=True) if plane is not None}
