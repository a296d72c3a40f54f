"""Planes that reuse the memory of others: the same bits as with separate memory, and less of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from covering import of_the_day
from pictures import VIDEO, codes, same_bits

from vidstyle.core.bands import ONE_THREAD, BandWorkers
from vidstyle.core.picture import PictureLayout
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.frame_memory import PlaneMemory
from vidstyle.cpu.schedule import Schedule, schedule
from vidstyle.cpu.style_job import StyleJob, plan
from vidstyle.style import load_style, style_names
from vidstyle.style.nodes import LoweredStyle

PICTURE = codes(VIDEO, 320, 180)


@pytest.fixture(autouse=True)
def small_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bands of few rows, so that planes of a small picture can follow others."""
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1 << 12)


def planned(name: str) -> tuple[LoweredStyle, Schedule]:
    job = StyleJob(load_style(name), PictureLayout.of(PICTURE), PICTURE.encoding, False)
    return plan(job.packed())


@pytest.mark.parametrize("name", of_the_day(style_names(), 6))
def test_results_are_the_same_bits(name: str) -> None:
    lowered, tasks = planned(name)
    results = [
        FrameExecutor(ONE_THREAD, each, PICTURE, lambda _, measured: measured).picture(lowered)
        for each in (tasks, replace(tasks, successors={}))
    ]
    assert same_bits(*results)


def test_a_plane_follows_another_below_which_nothing_is_read() -> None:
    _, tasks = planned("oil")
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
