"""Planes that reuse the memory of others: the same bits as with separate memory, and less of it."""

from __future__ import annotations

import math
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from covering import of_the_day
from pictures import VIDEO, codes, same_bits, step, style

from vidstyle.core.bands import ONE_THREAD, BandWorkers
from vidstyle.core.convert import convert
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.frame_memory import PlaneMemory, frame_bytes
from vidstyle.cpu.scheduling.schedule import schedule
from vidstyle.cpu.scheduling.sweeps import Schedule
from vidstyle.cpu.style_job import StyleJob, plan
from vidstyle.style import Step, load_style, style_names
from vidstyle.style.nodes import LoweredStyle, Node, nodes_in_order

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
            assert not tasks.recomputed if most else tasks.recomputed or name != "oil"
            results.append(FrameExecutor(workers, tasks, source, _as_measured).picture(lowered))
    assert same_bits(*results)


def test_a_style_with_large_planes_stores_a_third_of_them() -> None:
    lowered, tasks = planned("oil")
    assert _stored_bytes_per_pixel(tasks) < 14 and tasks.recomputed
    assert _stored_bytes_per_pixel(schedule(lowered, [lowered.luma])) > 32  # type: ignore[list-item]


@pytest.mark.parametrize("again", [[], [step("kuwahara", source="toned")]], ids=["one sweep", "two sweeps"])
def test_luma_is_computed_with_the_rgb_that_gives_its_chroma(
    again: list[Step], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_STORED_BYTES_PER_PIXEL", math.inf)
    toned = step("hue", angle=30), step("brightness", factor=1.2, save="toned")
    strokes = step("strokes"), step("gaussian", save="strokes")
    chosen = style(*toned, *strokes, *again, step("blend", other="strokes"))
    lowered, tasks = plan(StyleJob(chosen, PictureLayout.of(PICTURE), PICTURE.encoding, False).packed())
    [luma] = [node for node in nodes_in_order(lowered.outputs) if _block_name(node) == "brightness"]
    stored = [_block_name(node) for sweep, _ in tasks.sweeps() for node in sweep.stores]
    assert "hue" in stored and ("brightness" in stored) == bool(again)
    results = [
        FrameExecutor(ONE_THREAD, each, PICTURE, _as_measured).picture(lowered)
        for each in (tasks, schedule(lowered, [luma]))
    ]
    assert same_bits(*results)


def _block_name(node: Node) -> str | None:
    return node.block.name if node.block else None


def test_a_plane_from_which_a_node_is_recomputed_does_not_give_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_STORED_BYTES_PER_PIXEL", 0)
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_COMPACT_RATIO", math.inf)
    colored = step("scale", factor=0.7), step("gradient"), step("scale", factor=1 / 0.7), step("saturation")
    again = step("gaussian", source="gray"), step("blend", other="colored"), step("to_gray"), step("gaussian")
    first = step("to_gray"), step("brightness", save="gray")
    chosen = style(*first, *colored, step("gaussian", save="colored"), *again)
    lowered, tasks = plan(StyleJob(chosen, PictureLayout.of(PICTURE), PICTURE.encoding, False).packed())
    assert [node.block.name for node in tasks.recomputed if node.block] == ["gradient", "saturation"]
    monkeypatch.setattr("vidstyle.cpu.scheduling.schedule.MAX_STORED_BYTES_PER_PIXEL", math.inf)
    [gray] = [node for node in schedule(lowered).successors if node.block]
    assert gray.block is not None and gray.block.name == "brightness" and gray not in tasks.successors


@pytest.mark.parametrize("name", ["oil", "neon", "pixel"])
def test_the_estimated_memory_covers_recomputed_pictures(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1 << 18)
    lowered, tasks = planned(name)
    estimated = frame_bytes(tasks, PICTURE.shape, PICTURE.encoding, False, ONE_THREAD)
    FrameExecutor(ONE_THREAD, tasks, PICTURE, _as_measured).picture(lowered)  # loads kernels and tables
    tracemalloc.start()
    FrameExecutor(ONE_THREAD, tasks, PICTURE, _as_measured).picture(lowered)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most <= estimated


def _as_measured(_: object, measured: np.ndarray) -> np.ndarray:
    return measured


@pytest.mark.parametrize(
    ("name", "recomputed"), [("oil", ["blend"]), ("pointillist", ["hue"]), ("blueprint", []), ("riso", [])]
)
def test_a_schedule_is_compact_if_a_frame_takes_less_memory(
    name: str, recomputed: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1 << 21)
    _, tasks = planned(name, codes(VIDEO, 1920, 1080))
    assert [_block_name(node) for node in tasks.recomputed] == recomputed


def test_rgb_that_many_steps_compute_is_stored() -> None:
    _, tasks = planned("riso")
    assert not tasks.recomputed


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
