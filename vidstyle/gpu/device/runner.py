"""Runs a plan on the GPU: binds textures and uniforms, starts the passes, reads back the planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.block import moment_of
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import Sampling
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan
from vidstyle.gpu.compile.shader import DRIFT, ImageOf, SamplerInput, Shader
from vidstyle.gpu.compile.shader_nodes import Format, ShaderNode, ShaderPercentileRequest
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.compile.slots import Slots
from vidstyle.gpu.compile.tiles import Job, Window, jobs_of
from vidstyle.gpu.device.gpu_resources import GpuResources
from vidstyle.gpu.device.stabilizer import GpuStabilizer
from vidstyle.gpu.device.transfer import PlaneTransfer
from vidstyle.style.nodes import PercentileRequest

if TYPE_CHECKING:
    import moderngl

DRIFT_FORMAT = Format(2, "f4")
NO_DRIFT_CELLS = np.zeros((1, 1, 2), np.float32)
BlendWeights = Mapping[tuple[str, int], float]
"""The weight of new percentiles, 0..1, by layer and number of the measured step."""


@dataclass(frozen=True)
class Readback:
    """Planes of one tile of the result in transfer from the GPU.

    Attributes:
        windows: position of each plane by name, in samples of the plane.
    """

    transfer: PlaneTransfer
    windows: dict[str, Window]


class Runner:
    """A plan with its programs and textures on the GPU. The caller owns the context."""

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
        self._measured: dict[ShaderPercentileRequest, moderngl.Texture] = {}
        self._drift: moderngl.Texture | None = None
        self._request: FrameRequest

    @property
    def is_tiled(self) -> bool:
        """Whether the page is processed in tiles."""
        return len(self._jobs) > 1

    def start(
        self,
        request: FrameRequest,
        picture: Picture,
        weights: BlendWeights,
        stabilizer: GpuStabilizer | None = None,
        drift: np.ndarray | None = None,
    ) -> list[Readback]:
        """Start all passes of a picture without waiting for the GPU, except for percentiles that it shares.

        Args:
            request: the request, of which the time and the shared percentiles are used.
            picture: a picture of the plan's layout, or planes that `stabilizer` converts to it.
            weights: weights of the new percentiles of each measured step.
            stabilizer: temporal stabilization; not supported for pages in tiles.
            drift: how far marks have moved; None for none.
        """
        self._request = request
        if any(DRIFT in each.samplers for each in self._shaders.values()):
            self._upload_drift(NO_DRIFT_CELLS if drift is None else drift)
        found = (self._run_job(job, picture, weights, stabilizer) for job in self._jobs)
        return [fetch for fetch in found if fetch is not None]

    def release(self) -> None:
        """Return the textures to the pool."""
        self._slots.release()
        if self._drift is not None:
            self._resources.textures.give(self._drift, DRIFT_FORMAT)

    def _upload_drift(self, drift: np.ndarray) -> None:
        shape, textures = (drift.shape[0], drift.shape[1]), self._resources.textures
        if self._drift is None or (self._drift.height, self._drift.width) != shape:
            if self._drift is not None:
                textures.give(self._drift, DRIFT_FORMAT)
            self._drift = textures.take(shape, DRIFT_FORMAT, exact=True)
        self._drift.write(np.ascontiguousarray(drift))

    def _run_job(
        self, job: Job, picture: Picture, weights: BlendWeights, stabilizer: GpuStabilizer | None
    ) -> Readback | None:
        planes = self._planes_of(job, picture)
        uploaded = self._resources.upload.send(planes)
        if stabilizer is not None:
            shapes = {name: (plane.shape[0], plane.shape[1]) for name, plane in planes.items()}
            uploaded = stabilizer.before(uploaded, shapes)
        for each in job.passes:
            self._run_pass(job, each, uploaded, weights)
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
        parts = [window.shape for window in windows.values()]
        return Readback(self._resources.download.begin(textures, parts), windows)

    def _planes_of(self, job: Job, picture: Picture) -> dict[str, np.ndarray]:
        """Return the part of each plane of the source that a job reads, by name."""
        return {
            name: plane[window.top : window.bottom, window.left : window.right]
            for node, window in job.planes.items()
            for name, plane in plane_arrays(node, picture).items()
        }

    def _run_pass(
        self, job: Job, each: Pass, uploaded: Mapping[str, moderngl.Texture], weights: BlendWeights
    ) -> None:
        shader, program = self._shaders[each], self._programs[each]
        for name, value in shader.uniforms.items():
            program.set(name, value)
        for unit, (name, what) in enumerate(shader.samplers.items()):
            program.set(name, unit)
            self._texture_of(what, uploaded).use(unit)
            if isinstance(what, ImageOf):
                window = job.window_of(what.node)
                program.set(f"{name}_origin", (window.left, window.top))
                program.set(f"{name}_last", (what.node.shape[1] - 1, what.node.shape[0] - 1))
        corner, size, origin, stride = job.area(each)
        for name, pair in {"origin": origin, "size": size, "corner": corner}.items():
            program.set(name, pair)
        program.set("stride", (stride, stride))
        program.set("page", each.shape[::-1])
        program.set("moment", moment_of(self._request.time))
        self._bind_targets(each, shader)
        program.run(corner, size, shader.text.groups)
        if each.sampled is not None and job.ends_measure:
            self._measure(each.sampled, weights)

    def _texture_of(self, what: SamplerInput, uploaded: Mapping[str, moderngl.Texture]) -> Any:
        if isinstance(what, PercentileRequest):
            return self._measured[what]
        if what == DRIFT:
            return self._drift
        if not isinstance(what, ImageOf):
            return self._resources.assets.get(what)
        if what.node.is_plane:
            return uploaded[_plane_names(what.node)[what.part]]
        return self._slots.nodes[what.node]

    def _bind_targets(self, each: Pass, shader: Shader) -> None:
        textures = [self._slots.texture(each, number) for number in range(len(shader.targets))]
        if self.plan.form != "compute":
            self._resources.draw_into(textures)
            return
        for number, texture in enumerate(textures):
            texture.bind_to_image(number, read=False, write=True)

    def _measure(self, measure: ShaderPercentileRequest, weights: BlendWeights) -> None:
        height, width = Sampling.of(*measure.of.shape).shape
        samples = self._slots.samples[measure]
        percentiles, request = self._resources.percentiles_of(measure), self._request
        self._measured[measure] = percentiles.measure(
            samples, (width, height), measure.percentages, weights[measure.step]
        )
        if request.measured or request.tones:
            percentiles.replace(request.tones_of(measure.step, percentiles.numbers))


def _plane_names(node: ShaderNode) -> Sequence[str]:
    if node.mask:
        return (f"mask {node.mask}",)
    return ("blue", "red") if node.kind == "chroma" else (node.kind,)


def plane_arrays(node: ShaderNode, picture: Picture) -> dict[str, np.ndarray]:
    """Return the arrays of a node that is a plane of the source, by name."""
    if node.mask:
        return {_plane_names(node)[0]: picture.masks[node.mask]}
    planes = {"luma": (picture.luma,), "chroma": picture.chroma, "color": (picture.color,)}[node.kind]
    assert planes is not None
    return {name: plane for name, plane in zip(_plane_names(node), planes, strict=True) if plane is not None}
