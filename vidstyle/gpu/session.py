"""Restyles pictures on one context, for as long as that lasts."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vidstyle.core.measured import ExponentialSmoother, small_luma
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import alpha_in_depth
from vidstyle.core.scene_cuts import SceneCutDetector
from vidstyle.errors import DeviceError
from vidstyle.gpu.compile.nodes import Measure, PictureLayout
from vidstyle.gpu.compile.plan import Form, Plan, make_plan
from vidstyle.gpu.device.choose import Device
from vidstyle.gpu.device.context import ContextThread, close_context, open_context
from vidstyle.gpu.device.runner import BlendWeights, GpuResources, Readback, Runner
from vidstyle.gpu.device.stabilizer import GpuStabilizer, plain_layout, steady_layout
from vidstyle.stabilize.stabilizer import Stabilized
from vidstyle.style import Style
from vidstyle.style.resolve import ResolvedStep, has_fixed_marks, resolve

LARGEST = 8192
"""A page with a longer side is done in tiles, even where the device says that it takes more: what drivers
report is no promise that there is memory for it."""
END_SECONDS = 2.0
"""How long to wait for a context to be closed."""


@dataclass(frozen=True)
class FrameRequest:
    """A picture to be restyled; the arguments are those of `CpuRenderer.run`."""

    picture: Picture
    time: float | None
    target: Encoding
    rgb: bool


@dataclass(frozen=True)
class InFlightFrame:
    """What has been started for a request."""

    request: FrameRequest
    plan: Plan
    fetches: list[Readback]
    steadied: Stabilized | None = None


class GpuSession:
    """A context, its thread, and what a style needs there.

    Args:
        style: the style, until another one is asked for.
        device: what to open.
        form: how passes run; None: as the device does best.
        fused: False makes a pass of every call, to compare with.
        largest: a page with a longer side is done in tiles.

    Raises:
        DeviceError: the context cannot be opened.
    """

    def __init__(
        self,
        style: Style,
        device: Device,
        form: Form | None = None,
        fused: bool = True,
        largest: int = LARGEST,
    ) -> None:
        self._style = style
        self._form: Form = form or device.form
        self._fused = fused
        self._largest = min(device.limits.texture_size, largest)
        self._owner = ContextThread("vidstyle-gpu")
        self._runner: Runner | None = None
        self._steps: dict[str, tuple[ResolvedStep, ...]] = {}
        self._smoothers: dict[tuple[str, int], ExponentialSmoother] = {}
        self._cuts = SceneCutDetector()
        self._steadier: GpuStabilizer | None = None
        try:
            self._owner.submit(self._open, device.index).result()
        except DeviceError:
            self._owner.end(END_SECONDS)
            raise

    def start(self, request: FrameRequest) -> Future[InFlightFrame]:
        """Send a picture and start all passes for it, in the thread."""
        return self._owner.submit(self._start, request)

    def fetch(self, drawn: InFlightFrame) -> Future[Picture]:
        """The restyled picture; waits, in the thread, until the GPU is done with it."""
        return self._owner.submit(self._fetch, drawn)

    def change_style(self, style: Style) -> None:
        """Go on in another style; what is compiled and allocated already is used again where it fits."""
        self._owner.submit(self._change_style, style).result()

    def close(self) -> None:
        """Let the context go."""
        self._owner.submit(self._close)
        self._owner.end(END_SECONDS)

    def _open(self, index: int) -> None:
        self._context = open_context(index)
        self._equipment = GpuResources(self._context)

    def _close(self) -> None:
        self._let_runner_go()
        self._equipment.release()
        close_context(self._context)

    def _change_style(self, style: Style) -> None:
        self._style = style
        self._steps = {}
        self._equipment.forget_numbers()
        self._let_runner_go()

    def _start(self, request: FrameRequest) -> InFlightFrame:
        with driver_errors():
            steady = self._style.steady > 0 and request.time is not None
            runner = self._prepared(request, steady)
            measures = [each.sampled for each in runner.plan.passes if each.sampled]
            begins = bool(steady or measures) and self._cuts.is_cut(small_luma(request.picture))
            blend_weights = self._blend_weights(measures, request.time, begins)
            if steady:
                assert self._steadier is not None and request.time is not None
                fetches, steadied = self._steadier.draw(request.picture, request.time, begins, blend_weights)
            else:
                fetches, steadied = runner.draw(request.picture, blend_weights), None
            self._check()
            return InFlightFrame(request, runner.plan, fetches, steadied)

    def _prepared(self, request: FrameRequest, steady: bool) -> Runner:
        """The runner for pictures such as this one, and what keeps their film steady."""
        layout = steady_layout(request.picture) if steady else PictureLayout.of(request.picture)
        old = self._runner.plan if self._runner else None
        if old and (old.source, old.target, old.rgb) == (layout, request.target, request.rgb) and self._steps:
            assert self._runner is not None
            return self._runner
        if old is None or old.source.shape != layout.shape or not self._steps:
            self._steps = resolve(self._style, *layout.shape)
            self._smoothers = {}
        plan = make_plan(
            self._style, self._steps, layout, request.target, request.rgb, self._form, self._fused
        )
        self._let_runner_go()
        self._runner = Runner(self._equipment, plan, self._largest)
        if steady:
            is_fixed = has_fixed_marks(self._steps)
            source = plain_layout(request.picture).encoding
            self._steadier = GpuStabilizer(
                self._equipment, self._runner, self._style.steady, is_fixed, source, request.target
            )
        self._equipment.textures.clear()
        return self._runner

    def _let_runner_go(self) -> None:
        if self._runner is not None:
            self._runner.release()
            self._runner = None
        if self._steadier is not None:
            self._steadier.release()
            self._steadier = None

    def _blend_weights(self, measures: list[Measure], time: float | None, begins: bool) -> BlendWeights:
        if begins:
            self._smoothers = {}
        weights: dict[tuple[str, int], float] = {}
        for each in measures:
            smoother = self._smoothers.setdefault(each.step, ExponentialSmoother())
            weights[each.step] = smoother.blend_weight(time, each.time_constant)
        return weights

    def _fetch(self, drawn: InFlightFrame) -> Picture:
        with driver_errors():
            tiles = [(fetch, fetch.transfer.arrays()) for fetch in drawn.fetches]
            self._check()
        planes: dict[str, np.ndarray] = {}
        for fetch, arrays in tiles:
            for (name, window), array in zip(fetch.windows.items(), arrays, strict=True):
                if len(tiles) == 1:
                    planes[name] = array
                    continue
                shape = _plane_shape(drawn, name)
                whole = planes.setdefault(name, np.empty(shape + array.shape[2:], array.dtype))
                whole[window.top : window.bottom, window.left : window.right] = array
        result = _picture(drawn, planes)
        return result if self._steadier is None else self._steadier.after(result, drawn.steadied)

    def _check(self) -> None:
        error = self._context.error
        if error != "GL_NO_ERROR":
            raise DeviceError("the GPU", f"reports {error}", "use --device cpu")


@contextmanager
def driver_errors() -> Iterator[None]:
    """Within the block, what moderngl raises for the driver becomes a DeviceError."""
    moderngl: Any = importlib.import_module("moderngl")
    try:
        yield
    except moderngl.Error as error:
        reason = str(error).strip().partition("\n")[0]
        raise DeviceError("the GPU", f"fails ({reason})", "use --device cpu") from None


def _plane_shape(drawn: InFlightFrame, name: str) -> tuple[int, int]:
    shape = drawn.request.picture.shape
    return drawn.request.target.chroma_shape(*shape) if name in ("blue", "red") else shape


def _picture(drawn: InFlightFrame, planes: dict[str, np.ndarray]) -> Picture:
    """The result, with what the passes have left untouched."""
    source, target = drawn.request.picture, drawn.request.target
    alpha = alpha_in_depth(source, target.depth)
    if drawn.request.rgb:
        return Picture(replace(target, full_range=True, step=(1, 1)), color=planes["color"], alpha=alpha)
    luma = planes.get("luma", source.luma)
    chroma = source.chroma
    if drawn.plan.chroma == "made":
        chroma = planes["blue"], planes["red"]
    elif drawn.plan.chroma == "gray":
        neutral = np.full(target.chroma_shape(*source.shape), target.chroma_levels[0], target.dtype)
        chroma = neutral, neutral.copy()
    return Picture(target, luma=luma, chroma=chroma, alpha=alpha)
