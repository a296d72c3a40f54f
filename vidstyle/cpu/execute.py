"""Executes a schedule for one picture, in bands of rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vidstyle.block import Drift, FrameTime, Limits, LumaWeights, Margin, PageRegion, ResultRows
from vidstyle.core.bands import BandWorkers, in_bands
from vidstyle.core.codes import Chroma, chroma_radius
from vidstyle.core.color.deferred_color import Mixed
from vidstyle.core.convert import PictureAssembler
from vidstyle.core.kernels import is_dry_run
from vidstyle.core.picture import MASK_ENCODING, Picture
from vidstyle.core.planes import (
    color_rows,
    decode_rows,
    luma_from_rgb,
    luma_rows,
    stored_chroma_rows,
    stored_planes,
    upsample_chroma,
    yuv_from_rgb,
)
from vidstyle.core.resample import Resampling
from vidstyle.core.sampling import percentiles, sample_plane, sampled_values
from vidstyle.cpu.frame_memory import PlaneMemory
from vidstyle.cpu.pixel_operations import TAKES_DEFERRED, Value, at_every_pixel, per_pixel, planes_of
from vidstyle.cpu.scheduling.sweeps import BandStep, Key, Schedule, Sweep
from vidstyle.style.nodes import LoweredStyle, Node, PercentileRequest, encoding_of


class FilmState(NamedTuple):
    """What blocks get of the film in addition to the picture: `FrameTime` and `Drift`."""

    moment: int = 0
    drift: np.ndarray | None = None


STILL = FilmState()


class FrameExecutor:
    """Runs the tasks of a schedule for one picture.

    Args:
        workers: threads for the bands.
        source: the picture; its planes are only read.
        follow: takes the measurements of a step and returns the smoothed numbers.
        shown: what blocks get of the film.
    """

    def __init__(
        self,
        workers: BandWorkers,
        schedule: Schedule,
        source: Picture,
        follow: Callable[[PercentileRequest[Node], np.ndarray], np.ndarray],
        shown: FilmState = STILL,
    ) -> None:
        self._workers, self._source, self._output = workers, source, schedule.output
        self._shown, self._memory = shown, PlaneMemory(workers, schedule.successors)
        self._recomputed = schedule.recomputed
        self._stored: dict[Node, Value] = {}
        self._numbers: dict[PercentileRequest[Node], np.ndarray] = {}
        for task, releases in schedule.tasks:
            if isinstance(task, PercentileRequest):
                self._numbers[task] = follow(task, self._measure(task))
            else:
                self._run_sweep(task)
            for node in releases:
                self._stored.pop(node, None)

    def _measure(self, task: PercentileRequest[Node]) -> np.ndarray:
        sample = self._sample(task.of)
        if is_dry_run():  # the sample holds any values; with zeros, steps that stretch contrast do so
            return np.zeros(len(task.percentages))
        # Highlights of HDR count as diffuse white, so that the other tones are stretched as in SDR.
        return np.minimum(percentiles(sample, task.percentages), 1)

    def picture(self, lowered: LoweredStyle) -> Picture:
        """Return the result in the target's encoding, or as packed RGB.

        Unmodified planes of the source are passed through. Values are clipped to the range of the samples.
        """
        source, output, chroma = self._source, self._output, lowered.chroma
        assembler = PictureAssembler(source, lowered.target, lowered.color is not None)
        if lowered.luma_untouched:
            assert source.luma is not None
            assembler.reuse_luma(source.luma)
        if chroma is not None and chroma.grid is not None:
            assembler.reuse_chroma(self._subsampled_chroma(chroma), chroma.grid)
        made = {node.kind: (node, 0) for node in output.results}
        above, below = (0, 0) if made.keys() <= {"luma"} else chroma_radius(assembler.target)

        def run(top: int, bottom: int) -> None:
            first = max(top - above, 0)
            values = self._run_band(output, first, min(bottom + below, source.shape[0]))
            if "color" in made:
                color = values[made["color"]]
                color = color.whole() if isinstance(color, Mixed) else color
                assembler.put_color(top, bottom, top - first, color)
            if "chroma" in made:
                assembler.put_chroma(top, bottom, top - first, *planes_of(values[made["chroma"]]))
            if "luma" in made:
                assembler.put_luma(top, values[made["luma"]][top - first : bottom - first])

        if made:
            in_bands(self._workers, source.shape, output.radius, run, output.channels)
        return assembler.picture()

    def planes(self, node: Node) -> Value:
        """Return all rows of a node that the schedule keeps."""
        return self._load(node, 0, node.shape[0])

    def _subsampled_chroma(self, node: Node) -> Chroma:
        """Return chroma on a grid: the source's planes, or resampled planes as float32."""
        chroma: Chroma | None = self._source.chroma if node.op == "plane" else self._stored[node]
        assert chroma is not None
        return chroma

    def _run_sweep(self, sweep: Sweep) -> None:
        self._stored |= self._memory.planes(sweep)
        node = sweep.results[0]
        if node.op == "network":
            self._run_network(node)
            return

        def run(top: int, bottom: int) -> None:
            self._run_band(sweep, top, bottom)

        in_bands(self._workers, sweep.stores[0].shape, sweep.radius, run, sweep.channels)

    def _run_network(self, node: Node) -> None:
        if not is_dry_run():
            color = node.inputs["color"]
            node.values["run"].run(self._load(color, 0, color.shape[0]), self._stored[node])

    def _run_band(self, sweep: Sweep, top: int, bottom: int) -> dict[Key, Value]:
        """Compute the rows top..bottom of all steps; return at least the sweep's results."""
        values: dict[Key, Value] = {}
        for step in sweep.steps:
            node, margin = step.node, step.margin
            first, last = max(top - margin, 0), min(bottom + margin, node.shape[0])
            if step.is_loaded:
                values[node, margin] = self._load(node, first, last)
                if step.narrower:
                    _narrow(values, step, top, bottom)
                continue
            if node.op not in TAKES_DEFERRED or step.twin is not None:
                for _, key in step.inputs:
                    values[key] = at_every_pixel(values[key])
            inputs = {name: values[key] for name, key in step.inputs}
            stored = {each: _rows(self._stored[each], top, bottom) for each in step.stores}
            if step.twin is not None:
                luma, *chroma = yuv_from_rgb(inputs["color"], encoding_of(node.matrix))
                for half in (node, step.twin):
                    values[half, margin] = luma if half.kind == "luma" else tuple(chroma)
            else:
                out = None if margin else stored.get(node)
                values[node, margin] = self._compute(node, inputs, first, last, out)
            if step.narrower:
                _narrow(values, step, top, bottom)
            for each, rows in stored.items():
                values[each, 0] = _copy_rows(values[each, 0], rows)
            for key in step.releases:
                del values[key]
        return values

    def _compute(
        self, node: Node, inputs: dict[str, Value], top: int, bottom: int, out: Value | None
    ) -> Value:
        """Compute the rows top..bottom of a node, in `out` if it is given and the operation supports it."""
        if node.block is not None:
            return self._run_block(node, inputs, top, bottom, out)
        if node.op == "filter_bank":
            return _run_bank(node, inputs, top, bottom, out)
        if node.op == "resample":
            return self._resample(node, top, bottom, out)
        if node.op == "upsample":
            chroma = node.inputs["chroma"]
            assert chroma.grid is not None
            shape = bottom - top, node.shape[1]
            return upsample_chroma(self._subsampled_chroma(chroma), chroma.grid, top, shape)
        return per_pixel(node, (bottom - top, node.shape[1]), inputs, out)

    def _run_block(
        self, node: Node, inputs: dict[str, Value], top: int, bottom: int, out: np.ndarray | None
    ) -> Value:
        block = node.block
        assert block is not None
        margin = _margin(node, top, bottom)
        if out is None and ResultRows in block.injected.values():
            out = np.empty((bottom - top, *inputs["image"].shape[1:]), np.float32)
        pictures = {name: inputs.get(name) for name in block.saved_refs}
        others = {
            name: out if kind is ResultRows else self._inject(kind, node, top, margin)
            for name, kind in block.injected.items()
        }
        result: Value = block.function(inputs["image"], **node.values, **pictures, **others)
        return result[margin[0] : margin[0] + bottom - top] if node.radius and result is not out else result

    def _inject(self, kind: object, node: Node, top: int, margin: tuple[int, int]) -> Any:
        """Return an argument that the renderer supplies, from row `top` on; `kind`: of `INJECTED_TYPES`."""
        if kind is PageRegion:
            return PageRegion(top - margin[0], *node.shape, margin)
        if kind is Margin:
            return margin
        if kind is LumaWeights:
            return encoding_of(node.matrix).weights
        if kind is Limits:
            return node.limits
        if kind is FrameTime:
            return self._shown.moment
        return self._shown.drift if kind is Drift else self._numbers.get(node.measure)  # type: ignore[arg-type]

    def _load(self, node: Node, top: int, bottom: int) -> Value:
        if node.op == "mask":
            return decode_rows(self._source.masks[node.values["name"]][top:bottom], node.kind, MASK_ENCODING)
        if node.op == "plane":
            if node.kind == "chroma":
                return stored_chroma_rows(self._source, top, bottom)
            return (color_rows if node.kind == "color" else luma_rows)(self._source, top, bottom)
        if node in self._recomputed:
            return at_every_pixel(self._run_band(self._recomputed[node], top, bottom)[node, 0])
        return _rows(self._stored[node], top, bottom)

    def _resample(self, node: Node, top: int, bottom: int, out: Value | None) -> Value:
        """Resample an image of another size for these rows of a node."""
        image, source = node.inputs["image"], self._source
        resampling = Resampling(image.shape, node.shape, **node.values)
        first, last = resampling.rows_read(top, bottom)
        codes = stored_planes(source, image.kind) if image.op == "plane" else ()
        if codes:  # decoded afterwards, as resampling usually reduces a source
            planes = (resampling.rows(plane[first:last], first, top, bottom) for plane in codes)
            values = tuple(decode_rows(plane, image.kind, source.encoding) for plane in planes)
            return values if image.kind == "chroma" else values[0]

        def resampled(plane: np.ndarray, out: np.ndarray | None) -> np.ndarray:
            rows = resampling.rows(plane, first, top, bottom, out)
            return np.clip(rows, *node.limits, out=rows) if node.limits else rows

        value = self._load(image, first, last)
        if isinstance(value, tuple):
            return tuple(map(resampled, value, out or (None, None)))
        return resampled(value, out)

    def _sample(self, node: Node) -> np.ndarray:
        """Return a small copy of luma or RGB whose planes are stored, converted if necessary."""
        if node.op == "plane":
            return sampled_values(self._source)
        if node.op == "mask":
            return sample_plane(self._source.masks[node.values["name"]]) * np.float32(1 / 255)
        if node.op == "luma_from_rgb" and node not in self._stored:
            return luma_from_rgb(self._sample(node.inputs["color"]), encoding_of(node.matrix))
        return sample_plane(self._stored[node])


def _run_bank(node: Node, inputs: dict[str, Value], top: int, bottom: int, out: np.ndarray | None) -> Value:
    above, below = _margin(node, top, bottom)
    run, wanted = node.values["run"], slice(above, above + bottom - top)
    if node.kind == "chroma":
        planes = run.run_chroma(inputs["luma"], inputs["chroma"], (above, below), top - above)
        return tuple(plane[wanted] for plane in planes)
    result = run.run(inputs["luma"], (above, below), top - above, out)
    return result if result is out else result[wanted]


def _margin(node: Node, top: int, bottom: int) -> tuple[int, int]:
    """Return the number of rows that the inputs of a node have above and below its requested rows."""
    return min(node.radius, top), min(node.radius, node.shape[0] - bottom)


def _narrow(values: dict[Key, Value], step: BandStep, top: int, bottom: int) -> None:
    """Add the rows of a step's result for its narrower margins."""
    first = max(top - step.margin, 0)
    for node, margin in step.narrower:
        wide: Value = at_every_pixel(values[node, step.margin])
        values[node, step.margin] = wide
        end = min(bottom + margin, node.shape[0])
        values[node, margin] = _rows(wide, max(top - margin, 0) - first, end - first)


def _rows(value: Value, top: int, bottom: int) -> Value:
    if isinstance(value, tuple):
        return value[0][top:bottom], value[1][top:bottom]
    return value[top:bottom]


def _copy_rows(value: Value, rows: Value) -> Value:
    """Copy a value to the requested rows if it was computed elsewhere, and return these rows."""
    value = at_every_pixel(value, rows)
    pairs = zip(value, rows, strict=True) if isinstance(value, tuple) else [(value, rows)]
    for computed, wanted in pairs:
        if computed is not wanted:
            wanted[:] = computed
    return rows
