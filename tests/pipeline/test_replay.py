"""The replay of a film on virtual cores (`tools/scaling.py`)."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from media import make_clip
from pictures import VIDEO, codes

from tools.replay.film import Machine, predict_seconds
from tools.replay.film_job import FilmJob, FilmTimes, measure_film
from tools.replay.machine import slowdown
from tools.replay.record import Event, Recording, _marks, _movable, _timed, recording
from tools.replay.virtual_cores import MAX_SLICE_SECONDS, Give, Operation, Semaphore, Take, Work, run
from tools.scaling import find_bound, min_cores
from vidstyle.core.machine.cores import use_threads
from vidstyle.pipeline.render import render

FRAMES = 40
IDEAL = Machine()


def film(finished: list[tuple[str, float]], reading: float = 0, writing: float = 0) -> Recording:
    """The recording of a film whose frames are alike."""
    return Recording([reading] * FRAMES, [writing] * FRAMES, [[]] * FRAMES, [list(finished)] * FRAMES)


@pytest.mark.parametrize(("cores", "seconds"), [(1, 4), (2, 2), (3, 4 / 3), (4, 1), (9, 1)])
def test_work_is_shared_among_cores(cores: int, seconds: float) -> None:
    threads = [iter([Work(0.5), Work(0.5)]) for _ in range(4)]
    assert run(list(threads), cores) == pytest.approx(seconds, abs=2 * MAX_SLICE_SECONDS)


def test_a_permit_has_one_thread_at_a_time() -> None:
    lock = Semaphore(1)
    threads: list[list[Operation]] = [[Take(lock), Work(1), Give(lock), Work(1)] for _ in range(3)]
    assert run([iter(each) for each in threads], 8) == pytest.approx(4, abs=0.01)


def test_threads_that_wait_for_each_other_are_reported() -> None:
    one, other = Semaphore(), Semaphore()
    with pytest.raises(RuntimeError, match="2 threads wait"):
        run([iter([Take(one), Give(other)]), iter([Take(other), Give(one)])], 1)


@pytest.mark.parametrize("cores", [1, 2, 4, 8])
def test_frames_without_a_common_part_take_all_cores(cores: int) -> None:
    predicted = predict_seconds(film([("native", 0.1)]), cores)
    assert predicted == pytest.approx(FRAMES * 0.1 / cores, rel=0.01)


@pytest.mark.parametrize(
    "finished",
    [[("python", 0.02), ("native", 0.08)], [("native", 0.08), ("enter", 0), ("native", 0.02), ("leave", 0)]],
)
def test_what_one_frame_does_at_a_time_limits_the_rate(finished: list[tuple[str, float]]) -> None:
    assert predict_seconds(film(finished), 64) == pytest.approx(FRAMES * 0.02 + 0.08, rel=0.02)


def test_decoding_is_done_by_one_thread_and_encoding_by_several() -> None:
    assert predict_seconds(film([], reading=0.1), 8) == pytest.approx(FRAMES * 0.1, rel=0.01)
    assert predict_seconds(film([], writing=0.1), 8) == pytest.approx(FRAMES * 0.1 / 8, rel=0.15)


def test_the_fewest_cores_for_a_rate() -> None:
    assert [min_cores(film([("native", 0.1)]), rate, IDEAL) for rate in (5, 35)] == ["1", "4"]
    assert min_cores(film([("python", 0.1)]), 11, IDEAL).startswith("over")


def test_the_part_that_limits_a_film_is_named() -> None:
    locked = [("python", 0.02), ("native", 0.08)]
    ordered = [("native", 0.08), ("enter", 0), ("native", 0.02), ("leave", 0)]
    free = [("native", 0.001)]
    parts = film(locked), film(ordered), film(free, reading=0.1), film(free, writing=0.2)
    names = ["Python's lock", "the order of frames", "reading", "writing"]
    assert [find_bound(each, 16, IDEAL).split(" (")[0] for each in parts] == names


def test_tasks_take_longer_while_other_cores_are_in_use() -> None:
    made, machine = film([("native", 0.1)]), Machine(slowdown=1.5)
    assert predict_seconds(made, 1, machine) == pytest.approx(FRAMES * 0.1, rel=0.01)
    assert predict_seconds(made, 2, machine) == pytest.approx(FRAMES * 0.1 * 1.5 / 2, rel=0.01)
    times = {seconds: FilmTimes(FRAMES, seconds, seconds, (), 0, 0) for seconds in (2.0, 3.0)}
    assert slowdown([times[3.0], times[2.0]], [times[3.0]]) == pytest.approx(1.5)
    assert slowdown([times[3.0]], [times[2.0]]) == 1


def test_a_waiting_thread_gets_the_lock_late_and_a_running_one_first() -> None:
    lock = Semaphore(1, wake_up_seconds=0.5)
    late = [Take(lock), Work(1), Give(lock)]
    assert run([iter([*late]), iter([*late])], 2) == pytest.approx(2.5)
    # The first thread takes the lock again before the second one wakes up.
    assert run([iter([*late, Work(0.1), *late]), iter([*late])], 2) == pytest.approx(3.6, abs=0.01)


def test_processes_need_no_lock_for_the_style() -> None:
    made = film([("style", 0.01), ("python", 0.07), ("moved", 0)])
    with_lock, without = (predict_seconds(made, 16, Machine(has_processes=each)) for each in (False, True))
    assert with_lock == pytest.approx(FRAMES * 0.07, rel=0.02)
    edits = film([("edit", 0.01), ("python", 0.07), ("moved", 0)])
    assert predict_seconds(edits, 4) < FRAMES * 0.07 == pytest.approx(predict_seconds(made, 4), rel=0.05)
    # Twelve processes take four rounds; the other pictures wait for the lock.
    assert 3 * 0.08 <= without <= 4 * 0.08 + 0.07


def test_opening_and_closing_a_film_cancel() -> None:
    """A film that takes 2 s to open and close, and 0.1 s a frame on one of two cores."""
    films = (FilmTimes(n, 2 + n / 10, 2 + n / 10, (2 + n / 10, 0), 7 + 3 * n, 1 + n) for n in (96, 24))
    frames = next(films) - next(films)
    assert (frames.frames, frames.voluntary, frames.involuntary) == (72, 3 * 72, 72)
    assert frames.seconds == pytest.approx(7.2) and frames.busy == pytest.approx((7.2, 0))
    assert frames.others == pytest.approx(0)
    made = film([("native", 0.1)])
    assert predict_seconds(made, 2, frames=10) == pytest.approx(10 * 0.1 / 2, rel=0.01)


def test_a_film_shorter_than_asked_for_counts_its_own_frames(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "clip.mp4", frames=16)
    job = FilmJob(str(clip), "plain", 24, sorted(os.sched_getaffinity(0))[:1])
    assert measure_film(job).frames == 12


def test_copies_that_only_time_planes_are_not_work(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = 0.0

    def spend(more: float) -> None:
        nonlocal seconds
        seconds += more

    class Plane:
        def copy(self) -> None:
            spend(1)

    def restyle(*_: object) -> tuple[None]:
        spend(5)
        return (None,)

    def stage() -> None:
        with _marks.into(events):
            _movable(restyle, "style")(None, None, codes(VIDEO, 16, 16))

    plane, events, stages = Plane(), list[Event](), list[float]()
    monkeypatch.setattr("tools.replay.record.planes_of", lambda _: [plane])
    monkeypatch.setattr("tools.replay.record.time.thread_time", lambda: seconds)
    _timed(stage, stages.append)()
    assert [each for each in events if each[1]] == [("style", 2), ("python", 5)]
    assert stages == [5]


def test_a_film_is_recorded(tmp_path: Path) -> None:
    clip = make_clip(tmp_path / "clip.mp4", frames=6)
    with use_threads(1), recording() as made:
        render(clip, tmp_path / "first.mp4", "ink", device="cpu")
        made.clear()
        render(clip, tmp_path / "out.mp4", "ink", device="cpu")
    assert [len(each) for each in (made.reading, made.writing, made.begun, made.finished)] == [6] * 4
    assert made.stages.keys() == {"read", "style", "write"}
    assert len(made.ending) == 1
    kinds = [kind for kind, _ in made.finished[-1]]
    assert set(kinds) == {"python", "native", "enter", "leave", "edit", "style", "moved"}
    assert kinds.index("edit") < kinds.index("moved") < kinds.index("style")
    assert 0 < made.python_seconds < made.seconds
    assert predict_seconds(made, 1) == pytest.approx(made.seconds, rel=0.01)
    assert made.seconds / 4 < predict_seconds(made, 4) < made.seconds
