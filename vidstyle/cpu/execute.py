"""Executes a schedule for one picture, in bands of rows on all cores."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import lru_cache
from typing import Any

import numpy as np

from vidstyle.block import LumaWeights, Measured, PageRegion, SavedRef
from vidstyle.core.bands import in_bands
from vidstyle.core.kernels import mix_channels
from vidstyle.core.measured import sampled, sampled_picture
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.planes import (
    Chroma,
    color_rows,
    luma_rows,
    rgb_from_yuv,
    upsampled_chroma,
    yuv_from_rgb,
)
from vidstyle.core.resample import resample
from vidstyle.cpu.schedule import Key, Schedule, Sweep
from vidstyle.style.nodes import Measure, Node

Value = Any
"""float32: luma, N x W; RGB, N x W x 3; or blue and red difference, two of N x W."""


class FrameExecutor:
    """Runs the tasks of a schedule for one picture.

    Args:
        pool: threads for the bands.
        source: the picture; its planes are only read.
        follow: takes what was measured for a step and returns the smoothed numbers.
    """

    def __init__(
        self,
        pool: Executor,
        schedule: Schedule,
        source: Picture,
        follow: Callable[[Measure, np.ndarray], np.ndarray],
    ) -> None:
        self._pool, self._source = pool, source
        self._output = schedule.output
        self._stored: dict[Node, Value] = {}
        self._numbers: dict[Measure, np.ndarray] = {}
        for task, releases in schedule.tasks:
            if isinstance(task, Measure):
                measured = np.percentile(self._sampled(task.of), task.percentages)
                self._numbers[task] = follow(task, measured)
            elif isinstance(task, Sweep):
                self._run_sweep(task)
            else:
                self._stored[task] = self._resampled(task)
            for node in releases:
                self._stored.pop(node, None)

    @property
    def output_nodes(self) -> tuple[Node, ...]:
        """The nodes of the result that are computed at every pixel."""
        return self._output.results

    @property
    def radius(self) -> int:
        """Rows that the output reads around each band."""
        return self._output.radius

    def output_rows(self, top: int, bottom: int) -> dict[Node, Value]:
        """The nodes of the result in these rows."""
        values = self._run_band(self._output, top, bottom)
        return {node: values[node, 0] for node in self.output_nodes}

    def subsampled_chroma(self, node: Node) -> Chroma:
        """Chroma on a grid: the source's planes, or resampled ones as float32."""
        chroma: Chroma | None = self._source.chroma if node.op == "plane" else self._stored[node]
        assert chroma is not None
        return chroma

    def _run_sweep(self, sweep: Sweep) -> None:
        self._stored |= {node: _empty_planes(node) for node in sweep.stores}

        def run(top: int, bottom: int) -> None:
            self._run_band(sweep, top, bottom)

        in_bands(self._pool, sweep.stores[0].shape, sweep.radius, run)

    def _run_band(self, sweep: Sweep, top: int, bottom: int) -> dict[Key, Value]:
        """Compute the rows top..bottom; returns the sweep's results, at least."""
        values: dict[Key, Value] = {}
        for step in sweep.steps:
            node, margin = step.node, step.margin
            first, last = max(top - margin, 0), min(bottom + margin, node.shape[0])
            if step.is_loaded:
                values[node, margin] = self._load(node, first, last)
                continue
            inputs = {name: values[key] for name, key in step.inputs}
            if step.twin is not None:
                luma, *chroma = yuv_from_rgb(inputs["color"], _encoding(node.matrix))
                for half in (node, step.twin):
                    values[half, margin] = luma if half.kind == "luma" else tuple(chroma)
            else:
                values[node, margin] = self._computed(node, inputs, first, last)
            for computed in (node, step.twin):
                if margin == 0 and computed is not None and computed in sweep.stores:
                    _copy_rows(values[computed, 0], self._stored[computed], first, last)
            for key in step.releases:
                del values[key]
        return values

    def _computed(self, node: Node, inputs: dict[str, Value], top: int, bottom: int) -> Value:
        if node.block is not None:
            return self._run_block(node, inputs, top, bottom)
        if node.op == "filter_bank":
            above, below = _margin(node, top, bottom)
            luma = node.values["run"].run(inputs["luma"], (above, below))
            return luma[above : above + bottom - top]
        if node.op == "upsample":
            chroma = node.inputs["chroma"]
            assert chroma.grid is not None
            shape = bottom - top, node.shape[1]
            return upsampled_chroma(self.subsampled_chroma(chroma), chroma.grid, top, shape)
        return _PIXEL_OPERATIONS[node.op](node, (bottom - top, node.shape[1]), **inputs)

    def _run_block(self, node: Node, inputs: dict[str, Value], top: int, bottom: int) -> np.ndarray:
        block = node.block
        assert block is not None
        above, below = _margin(node, top, bottom)
        injected: dict[object, Any] = {
            PageRegion: PageRegion(top - above, *node.shape, (above, below)),
            LumaWeights: _encoding(node.matrix).weights,
            Measured: self._numbers.get(node.measure),  # type: ignore[arg-type]
        }
        pictures = {
            name: inputs.get(name)
            for name, parameter in block.parameters.items()
            if isinstance(parameter.control, SavedRef)
        }
        others = {name: injected[kind] for name, kind in block.injected.items()}
        result: np.ndarray = block.function(inputs["image"], **node.values, **pictures, **others)
        return result[above : above + bottom - top]

    def _load(self, node: Node, top: int, bottom: int) -> Value:
        if node.op == "plane":
            return (color_rows if node.kind == "color" else luma_rows)(self._source, top, bottom)
        planes = self._stored[node]
        if isinstance(planes, tuple):
            return planes[0][top:bottom], planes[1][top:bottom]
        return planes[top:bottom]

    def _resampled(self, node: Node) -> Value:
        image, method = node.inputs["image"], node.values["method"]
        if image.grid is not None:
            neutral, span = image.grid.chroma_levels
            chroma = self.subsampled_chroma(image)
            value: Value = tuple((plane.astype(np.float32) - neutral) / span for plane in chroma)
        else:
            value = self._load(image, 0, image.shape[0])
        if isinstance(value, tuple):
            return tuple(resample(plane, node.shape, method) for plane in value)
        return resample(value, node.shape, method)

    def _sampled(self, node: Node) -> np.ndarray:
        """A small copy of luma or RGB that is at hand as planes, but for a conversion."""
        if node.op == "plane":
            small = sampled_picture(self._source)
            return (color_rows if node.kind == "color" else luma_rows)(small, 0, small.shape[0])
        if node.op == "luma_from_rgb" and node not in self._stored:
            return _luma_from_rgb(node, (0, 0), self._sampled(node.inputs["color"]))
        return sampled(self._stored[node])


def _margin(node: Node, top: int, bottom: int) -> tuple[int, int]:
    """How many rows the inputs of a node have above and below the rows that are wanted of it."""
    return min(node.radius, top), min(node.radius, node.shape[0] - bottom)


def _empty_planes(node: Node) -> Value:
    if node.kind == "chroma":
        return np.empty(node.shape, np.float32), np.empty(node.shape, np.float32)
    return np.empty((*node.shape, 3) if node.kind == "color" else node.shape, np.float32)


def _copy_rows(value: Value, planes: Value, top: int, bottom: int) -> None:
    pairs = zip(value, planes, strict=True) if isinstance(value, tuple) else [(value, planes)]
    for rows, plane in pairs:
        plane[top:bottom] = rows


@lru_cache
def _encoding(matrix: str) -> Encoding:
    return Encoding(matrix)


def _luma_from_rgb(node: Node, shape: tuple[int, int], color: np.ndarray) -> np.ndarray:
    return yuv_from_rgb(color, _encoding(node.matrix))[0]


def _chroma_from_rgb(node: Node, shape: tuple[int, int], color: np.ndarray) -> Chroma:
    return yuv_from_rgb(color, _encoding(node.matrix))[1:]


def _rgb_from_yuv(node: Node, shape: tuple[int, int], luma: np.ndarray, chroma: Chroma) -> np.ndarray:
    return rgb_from_yuv(luma, chroma, _encoding(node.matrix))


def _rgb_from_gray(node: Node, shape: tuple[int, int], luma: np.ndarray) -> np.ndarray:
    return np.repeat(luma[..., None], 3, axis=2)


def _constant_luma(node: Node, shape: tuple[int, int]) -> np.ndarray:
    return np.full(shape, node.values["level"], np.float32)


def _constant_chroma(node: Node, shape: tuple[int, int]) -> Chroma:
    blue, red = (np.full(shape, level, np.float32) for level in node.values["tint"])
    return blue, red


def _on_paper(node: Node, shape: tuple[int, int], color: np.ndarray) -> np.ndarray:
    return mix_channels(color, np.diag([*node.values["paper"], 0.0])[:3])


def _inked_luma(node: Node, shape: tuple[int, int], under: np.ndarray, lines: np.ndarray) -> np.ndarray:
    return _mixed(node.values["ink"], under, lines)


def _inked_chroma(node: Node, shape: tuple[int, int], under: Chroma, lines: np.ndarray) -> Chroma:
    blue, red = (_mixed(ink, plane, lines) for ink, plane in zip(node.values["ink"], under, strict=True))
    return blue, red


def _mixed(ink: float, under: np.ndarray, lines: np.ndarray) -> np.ndarray:
    out = under - np.float32(ink)
    out *= lines
    out += np.float32(ink)
    return out


_PIXEL_OPERATIONS: dict[str, Callable[..., Value]] = {
    "luma_from_rgb": _luma_from_rgb,
    "chroma_from_rgb": _chroma_from_rgb,
    "rgb_from_yuv": _rgb_from_yuv,
    "rgb_from_gray": _rgb_from_gray,
    "constant_luma": _constant_luma,
    "constant_chroma": _constant_chroma,
    "on_paper": _on_paper,
    "inked_luma": _inked_luma,
    "inked_chroma": _inked_chroma,
}
