"""Pictures restyled in other processes: the same bits, also if a process fails, and no process is left."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
from concurrent.futures import CancelledError
from contextlib import closing, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import av
import numpy as np
import pytest
from covering import of_the_day
from films import RATE
from pictures import picture_with_writing, same_bits
from remembering import FILM, REMEMBERING
from waiting import LONG, eventually

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.cpu import remote_style, style_processes
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.cpu.shared_pictures import SharedPictures
from vidstyle.cpu.style_job import StyleJob, blank_picture
from vidstyle.cpu.style_process import StyleProcess
from vidstyle.cpu.style_processes import MIN_EDIT_THREADS, StyleProcesses, can_share_pictures
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.regions.writing.lifting import lift_writing
from vidstyle.style import Style, load_style, style_names

pytestmark = pytest.mark.skipif(not can_share_pictures(), reason="needs anonymous shared memory")

THREADS = 8


@pytest.fixture
def used(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Start the processes with the first picture, and note the process of each picture that one restyles."""
    monkeypatch.setattr(CpuRenderer, "frames_in_flight", 0)
    monkeypatch.setattr(remote_style, "useful_processes", lambda _: 2)
    found: list[int] = []
    restyle = StyleProcess.restyle

    def noted(self: StyleProcess, *arguments: Any) -> Picture:
        result = restyle(self, *arguments)
        found.append(self.number)
        return result

    monkeypatch.setattr(StyleProcess, "restyle", noted)
    return found


def alone(style: Style) -> list[Picture]:
    with CpuRenderer(style, 1) as renderer:
        return [renderer.run(each, number / RATE) for number, each in enumerate(FILM)]


def wait_for_processes() -> StyleProcesses:
    shared = style_processes._shared
    assert shared is not None
    eventually(lambda: all(each.has_news for each in shared._starting))
    return shared


def side_by_side(style: Style) -> list[Picture]:
    """Restyle the film; all pictures but the first while processes are ready."""
    with closing(CpuRenderer(style, THREADS)) as renderer:
        started = []
        for number, each in enumerate(FILM):
            started.append(renderer.begin(FrameRequest(each, number / RATE)))
            if number == 0:
                started[0].result(LONG)
            if number == 0 and style_processes._shared is not None:
                wait_for_processes()
        return [each.result(LONG) for each in started]


def differing(one: list[Picture], other: list[Picture]) -> list[int]:
    return [number for number, pair in enumerate(zip(one, other, strict=True)) if not same_bits(*pair)]


@pytest.mark.parametrize("name", of_the_day(style_names(), 3))
def test_processes_give_the_same_bits(name: str, used: list[int]) -> None:
    for steady in (0.0, 0.5):
        style = replace(load_style(name), steady=steady)
        used.clear()
        assert differing(alone(style), side_by_side(style)) == [], steady
        # Styles without steps, and styles with colours of the film, run in this process.
        assert used or style.is_plain or "film" in str(style.steps)
    assert style_processes._shared is None


def test_a_process_that_ends_within_a_picture_changes_nothing(
    used: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The percentiles of that picture are followed once."""
    ask = StyleProcess.restyle
    killed: list[int] = []

    def restyle(self: StyleProcess, job: bytes, picture: Picture, moment: int, follow: Any) -> Picture:
        def follow_and_end(*measure: Any) -> np.ndarray:
            if len(killed) < 2:
                killed.append(self.number)
                os.kill(self.number, signal.SIGKILL)
            return follow(*measure)  # type: ignore[no-any-return]

        return ask(self, job, picture, moment, follow_and_end)

    monkeypatch.setattr(StyleProcess, "restyle", restyle)
    assert differing(alone(REMEMBERING), side_by_side(REMEMBERING)) == []
    assert len(killed) == 2


def test_pictures_are_restyled_here_if_kernels_are_not_stored(
    used: list[int], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Processes compile nothing."""
    alone(REMEMBERING)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert differing(alone(REMEMBERING), side_by_side(REMEMBERING)) == []
    assert used == []


def test_a_failure_is_reported_once_in_plain_words(
    used: list[int], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(self: StyleProcess, *_: Any) -> Picture:
        raise EOFError

    monkeypatch.setattr(StyleProcess, "restyle", fail)
    with caplog.at_level(logging.INFO, "vidstyle"):
        side_by_side(REMEMBERING)
    [text, *others] = [each for each in caplog.records if "process" in each.message]
    assert text.message == "a process for frames failed (it has ended); threads restyle its frames"
    assert all(vars(each)["once"] and each.message == text.message for each in [text, *others])


@pytest.mark.parametrize("count", [MIN_EDIT_THREADS, THREADS])
def test_processes_take_writing_off(count: int, used: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    """With few threads, they do nothing else."""
    style, page, changed = replace(load_style("ink"), steady=0.5), picture_with_writing(), list[int]()
    film = [Picture.from_array(np.roll(page, 3 * number, axis=1)) for number in range(4)]
    make = StyleProcess.make

    def noted(self: StyleProcess, *arguments: Any) -> Any:
        result = make(self, *arguments)
        changed.append(self.number)
        return result

    def restyled(threads: int) -> list[Picture]:
        with FocusRenderer(style, lambda each, _: CpuRenderer(each, threads), KnownFaces()) as renderer:
            pending = []
            for number, each in enumerate(film):
                pending.append(renderer.begin(FrameRequest(each, number / RATE)))
                if number == 0 and threads > 1:
                    pending[0].result()
                    wait_for_processes()
            return [each.result() for each in pending]

    monkeypatch.setattr(StyleProcess, "make", noted)
    assert differing(restyled(1), restyled(count)) == []
    assert changed and bool(used) == (count == THREADS)


def test_only_changed_planes_come_back_from_a_process() -> None:
    """A process whose change fails is not used again."""
    written = picture_with_writing()
    frame = av.VideoFrame.from_ndarray(written, "rgb24").reformat(format="yuv420p")
    picture, lift = picture_from_frame(frame), partial(lift_writing, amount=1.0)
    with closing(StyleProcesses(1, 0, b"", lift)) as processes:
        eventually(lambda: processes._starting[0].has_news)
        made = processes.make(lift, picture)
        assert made is not None
        (changed, found), (here, wanted) = made, lift(picture)
        assert same_bits(changed, here) and not same_bits(changed, picture)
        assert [each.window for each in found] == [each.window for each in wanted] != []
        assert [processes.make(each, picture) for each in (partial(lift_writing), lift)] == [None] * 2


@pytest.mark.parametrize("planes", ["gray", "chroma", "color"])
def test_processes_are_prepared_with_a_picture_of_the_layout(
    planes: Literal["gray", "chroma", "color"],
) -> None:
    layout = PictureLayout(Encoding(), (35, 51), planes)
    job = StyleJob(load_style("ink"), layout, Encoding(), False)
    assert PictureLayout.of(blank_picture(job.packed())) == layout


def test_cancel_ends_pictures_and_processes(used: list[int]) -> None:
    with closing(CpuRenderer(REMEMBERING, THREADS)) as renderer:
        renderer.begin(FrameRequest(FILM[0], 0.0)).result(LONG)
        shared = wait_for_processes()
        pids = pids_of(shared)
        os.kill(pids[0], signal.SIGSTOP)  # it answers no more
        os.kill(pids[1], signal.SIGSTOP)
        started = [renderer.begin(FrameRequest(each, number / RATE)) for number, each in enumerate(FILM[:4])]
        renderer.cancel()
        for each in started:
            with suppress(CancelledError):
                each.result(LONG)
    assert len(pids) == 2
    eventually(lambda: not any(map(is_running, pids)))


def test_processes_end_with_a_program_that_is_killed() -> None:
    code = (
        "from vidstyle.cpu.style_processes import StyleProcesses\n"
        "shared = StyleProcesses(1, 0, b'')\n[process] = shared._starting\nprocess.wait_until_ready()\n"
        "print(process.number, flush=True)\ninput()"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as program:
        assert program.stdout is not None
        pid = int(program.stdout.readline())
        assert is_running(pid)
        program.kill()
    eventually(lambda: not is_running(pid))


def pids_of(shared: StyleProcesses) -> list[int]:
    assert shared._parent is not None
    pid = shared._parent.pid
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
    return [pid, *map(int, children)]


def is_running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_stored_pictures_are_the_same_and_grow() -> None:
    chance = np.random.default_rng(5)
    pictures = SharedPictures(os.memfd_create("test"))
    try:
        for height in (3, 40, 9):
            luma = chance.integers(0, 255, (height, 31), np.uint8)[:, 4:25]
            blue, red = chance.integers(0, 999, (2, height, 11), np.uint16)
            masks = {"backdrop": chance.integers(0, 255, (height, 21, 3), np.uint8)}
            picture = Picture(Encoding(), luma, (blue, red), alpha=luma[:, ::-1], masks=masks)
            stored, end = pictures.store(picture)
            second, _ = pictures.store(Picture(Encoding(), luma.T), end)
            loaded = pictures.load(stored)
            assert same_bits(loaded, picture)
            assert same_bits(pictures.load(second), Picture(Encoding(), luma.T))
            assert loaded.luma is not None and loaded.chroma is not None
            assert (loaded.masks["backdrop"] == masks["backdrop"]).all()
            # Kernels are compiled for one or the other.
            assert not loaded.luma.flags.c_contiguous
            assert loaded.chroma[0].flags.c_contiguous
    finally:
        os.close(pictures.descriptor)
