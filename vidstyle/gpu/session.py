"""Restyles pictures on one OpenGL context until it is lost."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.core.bands import shared_workers
from vidstyle.core.color.film_colors import FilmPalettes
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.core.planes import alpha_in_depth
from vidstyle.core.sampling import ExponentialSmoother
from vidstyle.core.scene_cuts import SceneCutDetector, SceneCuts
from vidstyle.errors import DeviceError, log
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import Plan, make_plan
from vidstyle.gpu.compile.shader_nodes import ShaderPercentileRequest
from vidstyle.gpu.compile.tiles import MAX_SIDE
from vidstyle.gpu.device.context import ContextThread, close_context, open_context
from vidstyle.gpu.device.devices import Device
from vidstyle.gpu.device.gpu_resources import GpuResources
from vidstyle.gpu.device.runner import BlendWeights, Readback, Runner
from vidstyle.gpu.device.stabilizer import GpuStabilizer
from vidstyle.stabilize.stabilizer import Stabilizer, planes_encoding, stabilized_layout, with_planes
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import Style
from vidstyle.style.lower import Steps
from vidstyle.style.resolve import film_tables, has_fixed_marks, has_moving_marks, measurement_key, resolve

END_SECONDS = 2.0
"""Maximum time to wait for closing a context."""


@dataclass(frozen=True)
class InFlightFrame:
    """The work that has been started for a request.

    Attributes:
        finish: work on the CPU that the result still needs, or None.
    """

    request: FrameRequest
    plan: Plan
    readbacks: list[Readback]
    finish: Callable[[Picture], Picture] | None = None


class GpuSession:
    """A context, its thread, and the resources for the style of the last request.

    Another style reuses compiled programs and textures that fit. If only values differ, no program is
    compiled, and percentiles and stabilization continue.

    Args:
        device: the device to open.
        form: form of the passes; None for the best form of the device.
        fused: False to make every call a separate pass, for comparison.
        max_side: pages with a longer side are processed in tiles.
        cuts: scene cuts of the film; None: they are detected.

    Raises:
        DeviceError: the context cannot be opened.
    """

    def __init__(
        self,
        device: Device,
        form: Form | None = None,
        fused: bool = True,
        max_side: int = MAX_SIDE,
        cuts: SceneCuts | None = None,
    ) -> None:
        self._form: Form = form or device.form
        self._fused = fused
        self._max_side = min(device.texture_size, max_side)
        self._thread = ContextThread("vidstyle-gpu")
        self._style: Style | None = None
        self._steps: Steps = {}
        self._runner: Runner | None = None
        self._smoothers: dict[tuple[str, int], ExponentialSmoother] = {}
        self._cuts = cuts or SceneCutDetector()
        self._film_palettes = FilmPalettes()
        self._stabilizer: GpuStabilizer | Stabilizer | None = None
        try:
            self._thread.submit(self._open, device.index).result()
        except DeviceError:
            self._thread.end(END_SECONDS)
            raise

    def start(self, style: Style, request: FrameRequest) -> Future[InFlightFrame]:
        """Upload a picture and start all passes for it, in the context's thread."""
        return self._thread.submit(self._start, style, request)

    def fetch(self, frame: InFlightFrame) -> Future[Picture]:
        """Return the restyled picture; the context's thread waits until the GPU has finished it."""
        return self._thread.submit(self._fetch, frame)

    def close(self) -> None:
        """Close the context."""
        self._thread.submit(lambda: close_context(self._context))
        self._thread.end(END_SECONDS)

    def _open(self, index: int) -> None:
        self._context = open_context(index)
        self._resources = GpuResources(self._context)

    def _start(self, style: Style, request: FrameRequest) -> InFlightFrame:
        request = flatten_still(request, style.steady)
        with request.measuring(), driver_errors():
            runner, shown, finish = self._prepare(style, request), request.picture, None
            stabilizer, measures = self._stabilizer, runner.plan.measures
            remembers = bool(stabilizer or measures or self._film_palettes)
            scene_cut = remembers and self._cuts.begins_scene(shown, request.time)
            request = request.edited()
            picture = request.picture
            self._film_palettes.follow(picture, request.time, scene_cut)
            weights = self._blend_weights(measures, request.time, scene_cut)
            if isinstance(stabilizer, Stabilizer):
                assert request.time is not None
                pair = stabilizer.follow(shown, request.time, scene_cut)
                warp = pair.warp() if pair else None
                stabilized = stabilizer.before(picture, warp, shared_workers())
                drift = stabilizer.marks.follow(picture, warp) if stabilizer.marks else None
                readbacks = runner.start(request, stabilized.picture, weights, drift=drift)
                finish = partial(stabilizer.after, stabilized=stabilized, workers=shared_workers())
            elif stabilizer is not None:
                assert request.time is not None
                stabilizer.estimate(shown, request.time, scene_cut)
                readbacks = runner.start(request, with_planes(picture), weights, stabilizer, stabilizer.drift)
            else:
                readbacks = runner.start(request, picture, weights)
            self._check()
            return InFlightFrame(request, runner.plan, readbacks, finish)

    def _prepare(self, style: Style, request: FrameRequest) -> Runner:
        """Return the runner for a request: the previous runner, or a new one."""
        is_steady = style.steady > 0 and request.time is not None
        layout = stabilized_layout(request.picture) if is_steady else PictureLayout.of(request.picture)
        old = self._runner.plan if self._runner else None
        same_size = old is not None and old.source.shape == layout.shape
        same_layout = old is not None and old.fits(layout, request.encoding, request.rgb)
        if self._runner and same_layout and style is self._style:
            return self._runner
        steps = self._steps
        if not (same_size and style is self._style):
            steps = resolve(style, *layout.shape)
        same_structure = measurement_key(steps) == measurement_key(self._steps)
        plan = make_plan(style, steps, layout, request.encoding, request.rgb, self._form, self._fused)
        if self._runner is not None:
            self._runner.release()
            self._runner = None
        if not (same_size and same_structure):
            self._smoothers, self._film_palettes = {}, FilmPalettes()
        if not same_structure:
            self._resources.forget_percentiles()
        if not (same_layout and same_structure and is_steady):
            if isinstance(self._stabilizer, GpuStabilizer):
                self._stabilizer.release()
            self._stabilizer = None
        self._runner = Runner(self._resources, plan, self._max_side)
        if is_steady:
            self._stabilize(style.steady, request, self._runner.is_tiled, steps)
        self._film_palettes.use(film_tables(steps))
        self._style, self._steps = style, steps
        return self._runner

    def _stabilize(self, steady: float, request: FrameRequest, is_tiled: bool, steps: Steps) -> None:
        is_fixed, follows = has_fixed_marks(steps), has_moving_marks(steps)
        if self._stabilizer is not None:
            self._stabilizer.change_strength(steady, is_fixed)
        elif is_tiled:
            log.info("pictures larger than one texture: stabilization runs on the CPU, which is slower")
            self._stabilizer = Stabilizer(steady, is_fixed, follows)
        else:
            source = planes_encoding(request.picture)
            target = request.encoding
            self._stabilizer = GpuStabilizer(self._resources, steady, is_fixed, source, target, follows)

    def _blend_weights(
        self, measures: list[ShaderPercentileRequest], time: float | None, scene_cut: bool
    ) -> BlendWeights:
        if scene_cut:
            self._smoothers = {}
        weights: dict[tuple[str, int], float] = {}
        for each in measures:
            smoother = self._smoothers.setdefault(each.step, ExponentialSmoother())
            weights[each.step] = smoother.blend_weight(time, each.time_constant)
        return weights

    def _fetch(self, frame: InFlightFrame) -> Picture:
        with driver_errors():
            tiles = [(each.windows.items(), each.transfer.arrays()) for each in frame.readbacks]
            self._check()
        page, target = frame.request.picture.shape, frame.request.encoding
        planes: dict[str, np.ndarray] = {}
        for windows, arrays in tiles:
            for (name, window), array in zip(windows, arrays, strict=True):
                if len(tiles) == 1:
                    planes[name] = array
                    continue
                shape = target.chroma_shape(*page) if name in ("blue", "red") else page
                plane = planes.setdefault(name, np.empty(shape + array.shape[2:], array.dtype))
                plane[window.top : window.bottom, window.left : window.right] = array
        result = _picture(frame, planes)
        return frame.finish(result) if frame.finish else result

    def _check(self) -> None:
        error = self._context.error
        if error != "GL_NO_ERROR":
            raise DeviceError("the GPU", f"reports {error}", "use --device cpu")


@contextmanager
def driver_errors() -> Iterator[None]:
    """Convert errors of the driver within the block to `DeviceError`."""
    moderngl: Any = importlib.import_module("moderngl")
    try:
        yield
    except moderngl.Error as error:
        reason = str(error).strip().partition("\n")[0]
        raise DeviceError("the GPU", f"fails ({reason})", "use --device cpu") from None


def _picture(frame: InFlightFrame, planes: dict[str, np.ndarray]) -> Picture:
    """Return the result, including planes that the passes have not changed."""
    source, target = frame.request.picture, frame.request.encoding
    alpha = alpha_in_depth(source, target.depth)
    if frame.request.rgb:
        return Picture(
            replace(target, full_range=True, subsampling=(1, 1)), color=planes["color"], alpha=alpha
        )
    luma = planes.get("luma", source.luma)
    chroma = source.chroma
    if frame.plan.chroma == "made":
        chroma = planes["blue"], planes["red"]
    elif frame.plan.chroma == "gray":
        neutral = np.full(target.chroma_shape(*source.shape), target.chroma_levels[0], target.dtype)
        chroma = neutral, neutral.copy()
    return Picture(target, luma=luma, chroma=chroma, alpha=alpha)
