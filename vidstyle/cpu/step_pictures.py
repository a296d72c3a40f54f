"""The output of each step of a style, from one run."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

import numpy as np

from vidstyle.core.bands import BandWorkers, useful_threads
from vidstyle.core.machine.cores import available_cores
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.core.sampling import ExponentialSmoother
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.scheduling.schedule import schedule
from vidstyle.style import Step, Style
from vidstyle.style.lower import GraphBuilder
from vidstyle.style.nodes import LoweredStyle, Node, PercentileRequest, StepKey
from vidstyle.style.resolve import resolve


def step_pictures(style: Style, picture: Picture, pool: Executor) -> dict[StepKey, np.ndarray]:
    """Return the output of each step of a style, at the working size of the step.

    Args:
        picture: the input of the style, a single picture.
        pool: threads for bands of rows.

    Returns:
        By layer and position in it, with recipes as one step: H x W x 3 RGB uint8, values clipped to 0..1.

    Raises:
        StyleError: an asset of the style cannot be read.
    """
    layers: dict[str, Any] = {layer: tuple(_watched(layer, steps)) for layer, steps in style.layers.items()}
    watched = replace(style, **layers)
    graph = GraphBuilder(PictureLayout.of(picture))
    image = graph.run_layers(watched, resolve(watched, *picture.shape))
    nodes = {
        (layer, number): graph.color(graph.saved[_name(layer, number)])
        for layer, steps in style.layers.items()
        for number in range(len(steps))
        if _name(layer, number) in graph.saved
    }
    lowered = LoweredStyle(graph.source, picture.encoding, color=graph.color(image), sizes=graph.sizes)

    def follow(measure: PercentileRequest[Node], measured: np.ndarray) -> np.ndarray:
        return ExponentialSmoother().follow(measured, None, measure.time_constant)

    workers = BandWorkers(pool, useful_threads(picture.shape, available_cores()))
    executor = FrameExecutor(workers, schedule(lowered, list(nodes.values())), picture, follow)
    return {key: _as_bytes(executor.planes(node)) for key, node in nodes.items()}


def _watched(layer: str, steps: tuple[Step, ...]) -> Iterator[Step]:
    """Yield the steps, each followed by a step that saves its result under a name invalid in files."""
    for number, step in enumerate(steps):
        yield step
        yield Step("", save=_name(layer, number))


def _name(layer: str, number: int) -> str:
    return f"{layer} {number}"


def _as_bytes(color: np.ndarray) -> np.ndarray:
    return np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)
