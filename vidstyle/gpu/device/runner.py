"""Runs a plan on the GPU: binds textures and values, draws the passes, fetches the planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.core.measured import Sampling
from vidstyle.core.picture import Picture
from vidstyle.gpu.compile.formats import WORKING
from vidstyle.gpu.compile.nodes import Measure, Node
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import ImageOf, Shader
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import Slots
from vidstyle.gpu.compile.tiles import Job, Window, jobs_of
from vidstyle.gpu.device.percentiles import Percentiles
from vidstyle.gpu.device.programs import Programs
from vidstyle.gpu.device.stabilize import StabilizerTextures
from vidstyle.gpu.device.textures import AssetTextures, TexturePool
from vidstyle.gpu.device.transfer import Download, PlaneTransfer, Upload
from vidstyle.stabilize.motion import Warp

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


@dataclass(frozen=True)
class StabilizerJob:
    """What keeps a film steady, and how the picture before is carried on into the one to be drawn."""

    textures: StabilizerTextures
    carry: Warp | None


class GpuResources:
    """What all plans on one context share. Whoever calls it owns the context."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.programs = Programs(context)
        self.textures = TexturePool(context)
        self.assets = AssetTextures(context)
        self.upload = Upload(context)
        self.download = Download(context)
        self.numbers: dict[tuple[str, int], Percentiles] = {}
        self._nowhere = context.framebuffer([context.renderbuffer((1, 1))])

    def draw_nowhere(self) -> None:
        """Take the framebuffer out of use, so that it can be let go.

        Whatever makes another one puts the one in use back afterwards, which fails if that is gone.
        """
        self._nowhere.use()

    def numbers_of(self, measure: Measure) -> Percentiles:
        """What remembers the numbers of a measured step."""
        if measure.step not in self.numbers:
            coding = WORKING["luma"]
            self.numbers[measure.step] = Percentiles(self.context, coding.low, coding.span)
        return self.numbers[measure.step]

    def forget_numbers(self) -> None:
        """Let go of what measured steps remember: another style comes."""
        while self.numbers:
            self.numbers.popitem()[1].release()

    def release(self) -> None:
        """Let go of everything."""
        self.forget_numbers()
        for each in (self.programs, self.upload, self.download, self.assets, self._nowhere):
            each.release()
        self.textures.clear()


class Runner:
    """A plan with its programs and textures on the GPU. Whoever calls it owns the context."""

    def __init__(self, equipment: GpuResources, plan: Plan, largest: int) -> None:
        self._equipment = equipment
        self.plan = plan
        self._shaders = {each: write_shader(plan, each) for each in plan.passes}
        self._jobs = jobs_of(plan, largest)
        self._slots = Slots(equipment.textures, plan, self._jobs, self._shaders)
        self._programs = {
            each: equipment.programs.get(shader.assembly) for each, shader in self._shaders.items()
        }
        self._framebuffers: dict[tuple[int, ...], Any] = {}
        self._numbers: dict[Measure, moderngl.Texture] = {}

    @property
    def is_tiled(self) -> bool:
        """Whether the page is done in parts."""
        return len(self._jobs) > 1

    def draw(
        self, picture: Picture, blend_weights: BlendWeights, steadying: StabilizerJob | None = None
    ) -> list[Readback]:
        """Start all that is to be done for a picture; nothing here waits for the GPU.

        Args:
            picture: of the plan's layout, or of planes that `steadying` brings to it.
            blend_weights: for each measured step.
            steadying: keeps the film steady; not for a page that is done in parts.
        """
        found = (self._run_job(job, picture, blend_weights, steadying) for job in self._jobs)
        return [fetch for fetch in found if fetch is not None]

    def release(self) -> None:
        """Give textures back and let go of the rest."""
        self._equipment.draw_nowhere()
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        self._framebuffers.clear()
        self._slots.release()

    def _run_job(
        self, job: Job, picture: Picture, blend_weights: BlendWeights, steadying: StabilizerJob | None
    ) -> Readback | None:
        arrays = {
            name: plane[window.top : window.bottom, window.left : window.right]
            for node, window in job.planes.items()
            for name, plane in _arrays_of(node, picture).items()
        }
        sent = self._equipment.upload.send(arrays)
        if steadying is not None:
            shapes = {name: (plane.shape[0], plane.shape[1]) for name, plane in arrays.items()}
            sent = steadying.textures.before(sent, shapes, steadying.carry)
        for each in job.passes:
            self._run_pass(job, each, sent)
            if each.sampled is not None and job.ends_measure:
                self._measure(each.sampled, blend_weights)
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
        if steadying is not None:
            textures = steadying.textures.after(zip(windows, textures, strict=True), steadying.carry)
        transfer = self._equipment.download.begin(
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

    def _texture_of(self, what: ImageOf | Measure | tuple, sent: Mapping[str, moderngl.Texture]) -> Any:
        if isinstance(what, Measure):
            return self._numbers[what]
        if not isinstance(what, ImageOf):
            return self._equipment.assets.get(what)
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
            self._framebuffers[key] = self._equipment.context.framebuffer(textures)
        self._framebuffers[key].use()

    def _measure(self, measure: Measure, blend_weights: BlendWeights) -> None:
        height, width = Sampling.of(*measure.of.shape).shape
        samples = self._slots.samples(measure)
        self._numbers[measure] = self._equipment.numbers_of(measure).follow(
            samples, (width, height), measure.percentages, blend_weights[measure.step]
        )


def _names_of(node: Node) -> Sequence[str]:
    return ("blue", "red") if node.kind == "chroma" else (node.kind,)


def _arrays_of(node: Node, picture: Picture) -> dict[str, np.ndarray]:
    planes = {"luma": (picture.luma,), "chroma": picture.chroma, "color": (picture.color,)}[node.kind]
    assert planes is not None
    return {name: plane for name, plane in zip(_names_of(node), planes, strict=True) if plane is not None}
