"""Pictures restyled side by side: the same bits for any number of threads, memory and order of events."""

from __future__ import annotations

import random
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from contextlib import closing
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from covering import DAY, of_the_day
from films import RATE
from pictures import same_bits, step, style
from remembering import FILM, REMEMBERING, film
from waiting import LONG

from vidstyle.backend import FrameRequest, joined_future
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import ExponentialSmoother
from vidstyle.cpu import frame_memory
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.frame_order import FrameOrder
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.stabilize.stabilizer import Stabilizer
from vidstyle.stabilize.travel import DriftFollower
from vidstyle.style import Style, load_style, style_names


def started(chosen: Style, threads: int, pictures: list[Picture]) -> list[Future[Picture]]:
    with closing(CpuRenderer(chosen, threads)) as renderer:
        return [renderer.begin(FrameRequest(each, number / RATE)) for number, each in enumerate(pictures)]


def differing(one: list[Picture], other: list[Future[Picture]]) -> list[int]:
    pairs = zip(one, other, strict=True)
    return [number for number, (a, b) in enumerate(pairs) if not same_bits(a, b.result(LONG))]


def limit_memory(monkeypatch: pytest.MonkeyPatch, pictures: float) -> None:
    """Leave memory for this number of pictures."""
    monkeypatch.setattr(frame_memory, "_CODEC_FRAMES", 0)
    monkeypatch.setattr(frame_memory, "frame_bytes", lambda *_: 1000)
    monkeypatch.setattr(frame_memory, "frame_memory", lambda: int(1000 * pictures))


@pytest.mark.parametrize("name", of_the_day(style_names(), 5))
def test_results_do_not_depend_on_threads_or_memory(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for steady in (0.0, 0.5):
        chosen = replace(load_style(name), steady=steady)
        with CpuRenderer(chosen, 1) as renderer:
            alone = [renderer.run(each, number / RATE) for number, each in enumerate(FILM)]
        for threads in (1, 2, 4, 8, 16):
            assert differing(alone, started(chosen, threads, FILM)) == [], (steady, threads)
        with monkeypatch.context() as short:
            limit_memory(short, 3)
            assert differing(alone, started(chosen, 8, FILM)) == [], steady


def test_a_measurement_out_of_order_would_change_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the other tests could not fail."""
    monkeypatch.setattr(ExponentialSmoother, "follow", lambda self, measure, *_: measure)
    unordered = started(REMEMBERING, 4, FILM)
    monkeypatch.undo()
    assert differing([each.result() for each in started(REMEMBERING, 1, FILM)], unordered) != []


DELAYED = [
    (FrameExecutor, "_run_band"), (FrameOrder, "__exit__"), (FrameOrder, "_wait_for"),
    (Stabilizer, "before"), (Stabilizer, "after"), (DriftFollower, "follow"), (ExponentialSmoother, "follow"),
]  # fmt: skip
"""Methods that other threads may overtake before they begin and after they have ended."""


def delay(monkeypatch: pytest.MonkeyPatch, chance: random.Random) -> None:
    """Let threads lose time at random places."""
    pause = threading.Event().wait

    def delayed(method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            pause(chance.choice((0, 0, 0, 0.001)))
            result = method(*arguments, **named)
            pause(chance.choice((0, 0, 0, 0.001)))
            return result

        return call

    for owner, name in DELAYED:
        monkeypatch.setattr(owner, name, delayed(getattr(owner, name)))


@pytest.mark.parametrize(
    "seeds", [range(60), pytest.param(range(60, 1000), marks=pytest.mark.thorough)], ids=len
)
def test_random_schedules_give_the_same_bits_and_never_wait_forever(
    seeds: range, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures = [*FILM[2:6], *FILM[8:10]]
    with CpuRenderer(REMEMBERING, 1) as renderer:
        alone = [renderer.run(each, number / RATE) for number, each in enumerate(pictures)]
    for seed in seeds:
        chance = random.Random(f"{DAY} {seed}")
        threads = chance.randint(2, 7)
        with monkeypatch.context() as patch:
            limit_memory(patch, chance.randint(1, threads))
            patch.setattr("vidstyle.core.bands.BAND_BYTES", chance.choice((1, 1 << 30)))
            delay(patch, chance)
            assert differing(alone, started(REMEMBERING, threads, pictures)) == [], seed


@pytest.mark.parametrize(
    ("memory", "most", "workers"), [(0.5, 1, 4), (1.9, 1, 4), (2, 2, 2), (3, 3, 2), (99, 4, 1)]
)
def test_no_more_pictures_than_memory_holds(
    memory: float, most: int, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    limit_memory(monkeypatch, memory)
    inside, seen, counts = [0], [], set()
    finish, lock = CpuRenderer._finish, threading.Lock()

    def noted(self: CpuRenderer, frame: Any, given: Any) -> Picture:
        with lock:
            inside[0] += 1
            seen.append(inside[0])
            counts.add(given.count)
        try:
            return finish(self, frame, given)
        finally:
            with lock:
                inside[0] -= 1

    monkeypatch.setattr(CpuRenderer, "_finish", noted)
    for each in started(REMEMBERING, 4, FILM[:8] * 2):
        each.result(LONG)
    assert max(seen) <= most and counts == {workers}


def test_a_film_palette_is_followed_one_picture_at_a_time() -> None:
    chosen = style(step("palette", colors="film-16"))
    with CpuRenderer(chosen, 4) as renderer:
        pending = [renderer.begin(FrameRequest(each, number / RATE)) for number, each in enumerate(FILM)]
        assert renderer._threads.workers(renderer._threads.side_by_side, FILM[0]).count == 4
    assert differing([each.result() for each in started(chosen, 1, FILM)], pending) == []


def test_opencv_has_one_thread_while_pictures_have_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    before = cv2.getNumThreads()
    cv2.setNumThreads(3)
    try:
        with CpuRenderer(REMEMBERING, 2) as one:
            one.run(FILM[0], 0.0)
            assert cv2.getNumThreads() == 3, "a single picture has all threads"
            with CpuRenderer(REMEMBERING, 2) as other:
                for renderer in (one, other, one):
                    renderer.start(FILM[0], 0.04).result(LONG)
                    assert cv2.getNumThreads() == 1
            assert cv2.getNumThreads() == 1, "the other one has still pictures"
        assert cv2.getNumThreads() == 3
    finally:
        cv2.setNumThreads(before)


def test_cancelled_pictures_compute_no_further_band(monkeypatch: pytest.MonkeyPatch) -> None:
    run_band, bands = FrameExecutor._run_band, []
    monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1)
    with CpuRenderer(REMEMBERING, 3) as renderer:
        reached, goes_on = threading.Barrier(4, timeout=LONG), threading.Event()

        def noted(*arguments: Any) -> Any:
            bands.append(1)
            reached.wait()
            assert goes_on.wait(LONG)
            return run_band(*arguments)

        renderer.run(FILM[0])  # kernels are there
        monkeypatch.setattr(FrameExecutor, "_run_band", noted)
        pending = [renderer.begin(FrameRequest(each)) for each in FILM[:4] * 3]
        reached.wait()
        renderer.cancel()
        goes_on.set()
        for each in pending:
            with pytest.raises(CancelledError):
                each.result(LONG)
    assert len(bands) == 3


def test_small_memory_is_reported_once(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame_memory, "memory_option", lambda: 1 << 20)
    monkeypatch.setattr(frame_memory, "frame_memory", lambda: 0)
    for each in started(REMEMBERING, 4, FILM[:4]):
        each.result(LONG)
    [record] = caplog.records
    assert record.getMessage().startswith("--memory: a frame of 60x45 takes about ")


def test_estimated_memory_grows_with_the_picture_and_the_style() -> None:
    """The estimate is at least the size of the planes that a style stores."""
    sizes = {}
    for shape in ((45, 60), (90, 120)):
        with CpuRenderer(REMEMBERING, 2) as renderer:
            renderer.begin(FrameRequest(next(film(shape)), 0.0)).result(LONG)
            [plan] = renderer._film._plans.values()
            arguments = plan.tasks, shape, FILM[0].encoding, True
            sizes[shape] = frame_memory.frame_bytes(*arguments, renderer._threads.workers(2, FILM[0]))
    assert 3 < sizes[90, 120] / sizes[45, 60] < 5
    assert sizes[45, 60] > np.zeros((45, 60, 3), np.float32).nbytes


def test_finished_parts_of_a_picture_do_not_keep_what_joined_them() -> None:
    class Joiner:
        def join(self) -> Picture:
            return FILM[0]

    parts, joiner = [Future[Picture](), Future[Picture]()], Joiner()
    joined, kept = joined_future(parts, joiner.join), weakref.ref(joiner)
    del joiner
    for each in parts:
        each.set_result(FILM[1])
    assert joined.result(LONG) is FILM[0] and kept() is None
