"""Planes that reuse the memory of others: the same bits as with separate memory, and less of it."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from covering import of_the_day
from pictures import VIDEO, codes, same_bits

from vidstyle.core.bands import ONE_THREAD, BandWorkers
from vidstyle.core.convert import convert
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.frame_memory import PlaneMemory
from vidstyle.cpu.scheduling.schedule import schedule
from vidstyle.cpu.scheduling.sweeps import READS_PLANES, Schedule
from vidstyle.cpu.style_job import StyleJob, plan
from vidstyle.style import load_style, style_names
from vidstyle.style.nodes import LoweredStyle

PICTURE = codes(VIDEO, 320, 180)
RGB_PICTURE = convert(PICTURE, PICTURE.encoding, rgb=True)


@pytest.fixture(autouse=True)
def small_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bands of few rows, so that planes of a small picture can follow others."""
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1 << 12)


def planned(name: str, source: Picture = PICTURE) -> tuple[LoweredStyle, Schedule]:
    job = StyleJob(load_style(name), PictureLayout.of(source), PICTURE.encoding, False)
    return plan(job.packed())


@pytest.mark.parametrize("name", of_the_day(style_names(), 6))
def test_results_are_the_same_bits(name: str) -> None:
    lowered, tasks = planned(name)
    results = [
        FrameExecutor(ONE_THREAD, each, PICTURE, _as_measured).picture(lowered)
        for each in (tasks, replace(tasks, successors={}))
    ]
    assert same_bits(*results)


@pytest.mark.parametrize("name", ["oil", *of_the_day([each for each in style_names() if each != "oil"], 5)])
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("source", [PICTURE, RGB_PICTURE], ids=["yuv", "rgb"])
def test_a_compact_schedule_makes_the_same_bits(
    name: str, threads: int, source: Picture, monkeypatch: pytest.MonkeyPatch
) -> None:
    lowered, _ = planned(name, source)
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_COMPACT_RATIO", math.inf)
    results = []
    with ThreadPoolExecutor(threads) as pool:
        workers = BandWorkers(pool, threads)
        for most in (0, math.inf):
            monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_STORED_BYTES_PER_PIXEL", most)
            tasks = schedule(lowered)
            assert bool(tasks.recomputed) == (most == 0) or name != "oil"
            results.append(FrameExecutor(workers, tasks, source, _as_measured).picture(lowered))
    assert same_bits(*results)


def test_a_style_with_large_planes_stores_a_third_of_them() -> None:
    lowered, tasks = planned("oil")
    assert _stored_bytes_per_pixel(tasks) < 14 and tasks.recomputed
    assert _stored_bytes_per_pixel(schedule(lowered, [lowered.luma])) > 32  # type: ignore[list-item]


def test_rows_of_a_plane_that_is_read_whole_by_a_recomputed_node_stay() -> None:
    for name in style_names():
        _, tasks = planned(name)
        for sweep, _ in tasks.successors.values():
            read = [tasks.recomputed[step.node] for step in sweep.steps if step.node in tasks.recomputed]
            images = {
                image
                for each in read
                for step in each.steps
                if step.node.op in READS_PLANES and not step.is_loaded
                for image in step.node.inputs.values()
            }
            assert images.isdisjoint(node for node, (other, _) in tasks.successors.items() if other is sweep)


def _as_measured(_: object, measured: np.ndarray) -> np.ndarray:
    return measured


def _stored_bytes_per_pixel(tasks: Schedule) -> float:
    return tasks.stored_bytes / math.prod(PICTURE.shape)


def test_a_plane_follows_another_below_which_nothing_is_read() -> None:
    _, tasks = planned("riso")
    [(before, (sweep, after)), *_] = [
        each for each in tasks.successors.items() if each[0].shape == PICTURE.shape
    ]
    memory = PlaneMemory(ONE_THREAD, tasks.successors)
    made = dict[object, np.ndarray]()
    for task, _ in tasks.tasks:
        made |= memory.planes(task) if hasattr(task, "stores") else {}
    one, other = made[before], made[after]
    assert np.shares_memory(one, other)
    lead = (one.ctypes.data - other.ctypes.data) // one.strides[0]
    rows = memory._lead(sweep)
    assert lead == rows > sweep.radius and rows % 16 == 0
    assert one.ctypes.data % 64 == other.ctypes.data % 64 == 0
    separate = PlaneMemory(BandWorkers(ONE_THREAD.pool, 2), tasks.successors)
    planes = [
        each for task, _ in tasks.tasks if hasattr(task, "stores") for each in separate.planes(task).items()
    ]
    assert not np.shares_memory(dict(planes)[before], dict(planes)[after])


@pytest.mark.parametrize("name", of_the_day(style_names(), 6))
def test_only_planes_that_nothing_reads_later_give_way(name: str) -> None:
    lowered, tasks = planned(name)
    kept = [*tasks.successors]
    assert schedule(lowered, kept).successors.keys().isdisjoint(kept)
    for before, (sweep, after) in tasks.successors.items():
        [releases] = [each for task, each in tasks.tasks if task is sweep]
        assert before in releases and after in sweep.stores
