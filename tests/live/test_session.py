"""Sessions from end to end: frames arrive, the newest wins, styles change, and memory is constant."""

from __future__ import annotations

import itertools
import logging
import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from faults import video
from live import POSTER, SMALL, Kept, SimulatedClock, before_opening, generated, refuse, session
from media import make_clip, rgb_from_frame
from waiting import LONG, eventually

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.errors import OutputError
from vidstyle.live.control import Status
from vidstyle.live.target import TargetContext
from vidstyle.media.capture.monotonic import MONOTONIC
from vidstyle.media.capture.sources import SourceOptions, resolve_source


def slow_down(monkeypatch: pytest.MonkeyPatch, seconds: Callable[[Picture], float]) -> SimulatedClock:
    """Let every style but plain take this long for a picture, by the clock that is returned."""
    original, clock = CpuRenderer.restyle, SimulatedClock()

    def restyle(self: CpuRenderer, request: FrameRequest) -> Picture:
        if not self.style.is_plain:
            clock.wait(threading.Event(), seconds(request.picture))
        return original(self, request)

    monkeypatch.setattr(CpuRenderer, "restyle", restyle)
    return clock


def gray_levels(kept: Kept) -> int:
    """How many tones the luma of the newest picture has."""
    assert kept.newest is not None
    plane = kept.newest.planes[0]
    rows = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)[:, : plane.width]
    return len(np.unique(rows))


def test_frames_arrive_in_order_and_are_counted():
    kept = Kept()
    with session(generated(), kept, frames=30) as running:
        summary = running.wait()
    assert summary.frames == 30 and kept.numbers == list(range(30)) and kept.closed == 1
    assert kept.captured == sorted(set(kept.captured))
    assert all(taken <= there for taken, there in zip(kept.captured, kept.arrived, strict=True))
    # 30 pictures at 30 per second take a second, however fast the style is.
    assert kept.arrived[-1] - kept.arrived[0] == pytest.approx(29 / 30)
    assert summary.size == SMALL and summary.rate == 30


def test_the_last_frame_arrives_though_the_source_ends_before_targets_are_open(tmp_path: Path):
    clip = make_clip(tmp_path / "clip.mp4", frames=5, size=SMALL)
    kept, entered = Kept(), threading.Event()

    def open_late(context: TargetContext) -> Kept:
        entered.wait()
        eventually(lambda: running.controls.status().source_state == "ended")
        kept.context = context
        return kept

    with session(resolve_source(str(clip), SourceOptions()), open_late, clock=MONOTONIC) as running:
        entered.set()
        summary = running.wait()
    assert kept.numbers == [0] and summary.dropped == 0
    assert kept.newest is not None
    last = video(clip)[-1]
    assert kept.newest.to_ndarray(format="gray") == pytest.approx(last.to_ndarray(format="gray"), abs=1)


@pytest.mark.parametrize(
    ("transfer", "notice"),
    [("hlg", "the source is HDR (HLG)"), ("", "the source has 10 bits per sample; they become 8")],
)
def test_a_deep_source_is_mapped_with_a_notice(tmp_path, caplog, transfer, notice):
    matrix = "bt2020" if transfer else "bt709"
    film = {"codec": "libx265", "pix_fmt": "yuv420p10le", "matrix": matrix, "transfer": transfer}
    clip = make_clip(tmp_path / "clip.mp4", frames=5, size=SMALL, **film)
    kept = Kept()
    with session(resolve_source(str(clip), SourceOptions()), kept, clock=MONOTONIC) as running:
        running.wait()
    assert caplog.text.count(notice) == 1
    assert kept.newest is not None and kept.newest.format.name == "yuv420p"


def test_what_goes_out_is_plain_video():
    kept = Kept()
    with session(generated(), kept, style=POSTER, frames=3, size=(81, -2)) as running:
        running.wait()
    assert kept.newest is not None
    assert (kept.newest.format.name, kept.newest.width, kept.newest.height) == ("yuv420p", 81, 46)
    assert kept.newest.color_range == 1 and kept.newest.colorspace in (5, 6)
    assert np.ptp(rgb_from_frame(kept.newest)) > 100


def test_another_shape_gets_bars_and_is_not_stretched():
    kept = Kept()
    with session(generated(), kept, frames=3, size=(160, 160)) as running:
        assert running.wait().size == (160, 160)
    assert kept.newest is not None
    luma = kept.newest.to_ndarray(format="gray").astype(int)
    assert luma[:30].max() < 20 and luma[-30:].max() < 20 and np.ptp(luma[40:120]) > 100


def test_the_newest_wins_when_the_style_is_slow(monkeypatch: pytest.MonkeyPatch):
    clock, kept = slow_down(monkeypatch, lambda picture: 0.12), Kept()
    with session(generated(), kept, style=POSTER, clock=clock, frames=12, budget=False) as running:
        summary = running.wait()
    # 3.6 pictures come while one is restyled.
    assert summary.dropped == pytest.approx(12 * 2.6, abs=1)
    # The newest has waited for one thirtieth of a second at most when its turn comes.
    delays = [there - taken for taken, there in zip(kept.captured[1:], kept.arrived[1:], strict=True)]
    assert 0.12 <= min(delays) and max(delays) <= 0.12 + 1 / 30 + 1e-9


def test_the_budget_gives_up_size_and_takes_it_back(monkeypatch: pytest.MonkeyPatch):
    slow, kept = threading.Event(), Kept()
    slow.set()
    clock = slow_down(
        monkeypatch, lambda picture: 0.4 * picture.shape[0] ** 2 / SMALL[1] ** 2 if slow.is_set() else 0
    )
    with session(generated(10), kept, style=POSTER, clock=clock) as running:
        eventually(lambda: "smaller picture" in running.controls.status().degraded)
        assert kept.newest is not None and (kept.newest.width, kept.newest.height) == SMALL
        running.controls.keep_size(True)
        eventually(lambda: running.controls.status().degraded == "", running.controls.status)
        running.controls.keep_size(False)
        eventually(lambda: "smaller picture" in running.controls.status().degraded)
        slow.clear()
        eventually(lambda: running.controls.status().degraded == "", running.controls.status)
        eventually(lambda: "back to full detail" in running.controls.status().message)
        assert running.end().degraded == ""


def test_the_style_changes_between_two_frames(monkeypatch: pytest.MonkeyPatch):
    go = threading.Event()
    before_opening("poster", lambda: go.wait(LONG), monkeypatch)
    kept = Kept()
    with session(generated(), kept, style=POSTER) as running:
        eventually(lambda: len(kept.numbers) > 3)
        few, count = gray_levels(kept), len(kept.numbers)
        running.controls.choose("poster")
        # The old style continues while the new one is prepared.
        eventually(lambda: len(kept.numbers) > count + 3)
        assert running.controls.status().style == "few"
        go.set()
        eventually(lambda: running.controls.status().style == "poster")
        eventually(lambda: gray_levels(kept) != few)
        running.end()
    assert kept.numbers == list(range(len(kept.numbers)))


def test_a_frame_that_outlasts_the_session_leaves_no_thread(monkeypatch: pytest.MonkeyPatch):
    """As on one busy core: `session` waits for the end of all threads."""
    go, original = threading.Event(), CpuRenderer.restyle
    entered = threading.Event()

    def restyle(self: CpuRenderer, request: FrameRequest) -> Picture:
        entered.set()
        go.wait(LONG)
        return original(self, request)

    monkeypatch.setattr(CpuRenderer, "restyle", restyle)
    monkeypatch.setattr("vidstyle.live.session.END_SECONDS", 0.01)
    with session(generated(), Kept(), style=POSTER, clock=MONOTONIC) as running:
        entered.wait(LONG)
        running.end()
        go.set()


def test_values_are_set_while_it_runs():
    kept = Kept()
    steps = [{"block": "luma_posterize", "levels": 16, "softness": 0}]
    with session(generated(), kept, style=POSTER | {"background": steps}) as running:
        eventually(lambda: len(kept.numbers) > 3)
        many = gray_levels(kept)
        running.controls.set_values({"luma_posterize.levels": 2})
        eventually(lambda: gray_levels(kept) < many / 2)
        running.end()


def test_a_style_is_told_when_it_changes_and_values_are_not(caplog: pytest.LogCaptureFixture):
    kept = Kept()
    with caplog.at_level(logging.INFO, "vidstyle"), session(generated(), kept, style=POSTER) as running:
        for levels in range(4, 9):
            count = len(kept.numbers)
            running.controls.set_values({"luma_posterize.levels": levels})
            eventually(lambda count=count: len(kept.numbers) > count + 2)
        running.controls.choose("poster")
        eventually(lambda: running.controls.status().message == "style poster")
        running.end()
    told = [record.getMessage() for record in caplog.records]
    assert [message for message in told if message.startswith("style")] == ["style poster"]


def test_bypass_and_back():
    kept = Kept()
    with session(generated(), kept, style={"format": 1, "lines": [{"block": "sobel"}]}) as running:
        eventually(lambda: len(kept.numbers) > 3)
        running.controls.bypass()
        is_colorful = lambda: np.ptp(rgb_from_frame(kept.newest), axis=2).max() > 100  # noqa: E731
        eventually(is_colorful)
        assert running.controls.status().bypass
        running.controls.bypass(False)
        eventually(lambda: not is_colorful())
        running.end()


def test_a_style_that_cannot_be_had_leaves_the_old_one_running(monkeypatch: pytest.MonkeyPatch):
    before_opening("poster", refuse, monkeypatch)
    kept = Kept()
    with session(generated(), kept, style=POSTER) as running:
        eventually(lambda: kept.numbers)
        running.controls.choose("poster")
        eventually(lambda: running.controls.status().message == "gpu:7 is gone; few continues")
        count = len(kept.numbers)
        eventually(lambda: len(kept.numbers) > count + 3)
        assert running.controls.status().style == "few"
        running.end()


def test_snapshots_and_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from faults import video

    monkeypatch.chdir(tmp_path)
    kept = Kept()
    with session(generated(), kept) as running:
        eventually(lambda: kept.numbers)
        running.controls.snapshot()
        running.controls.record(True)
        eventually(lambda: running.controls.status().recording)
        count = len(kept.numbers)
        eventually(lambda: len(kept.numbers) > count + 15)
        running.controls.record(False)
        eventually(lambda: "frames" in running.controls.status().message)
        running.end()
    film, picture = sorted(tmp_path.iterdir(), key=lambda path: path.suffix)  # a second may lie between
    assert (film.suffix, picture.suffix) == (".mp4", ".png")
    assert len(video(film)) >= 10 and (video(picture)[0].width, video(picture)[0].height) == SMALL


def test_quit_and_time_end_it():
    with session(generated(), Kept()) as running:
        running.controls.quit()
        running.wait()
    with session(generated(), Kept(), seconds=0.5) as running:
        assert 0.5 <= running.wait().elapsed <= 0.6 + 1e-9, "the end is looked for ten times a second"


def test_the_status_tells_how_it_is():
    kept = Kept()
    with session(generated(), kept, style=POSTER) as running:
        assert running.controls.status().style == "few"
        eventually(lambda: running.controls.status().rate > 5 and running.controls.status().frames > 1)
        status: Status = running.controls.status()
        assert (status.source, status.source_state, status.size) == ("test", "running", SMALL)
        assert status.targets == (("kept", "running"),)
        running.end()
    assert running.controls.status().source_state == "ended"


def test_a_failed_target_ends_the_session_only_if_it_is_the_last():
    class Failing(Kept):
        error: Exception | None = None

        def offer(self, frame):
            super().offer(frame)
            self.error = OutputError("disk", "is full") if len(self.numbers) > 3 else None

    failing, kept = Failing(), Kept()
    with (
        pytest.raises(OutputError, match="disk is full"),
        session(generated(), failing, kept, frames=20) as running,
    ):
        running.wait()
    assert len(kept.numbers) == 20
    alone = Failing()
    with pytest.raises(OutputError), session(generated(), alone, frames=20) as running:
        running.wait()
    assert len(alone.numbers) < 20


def test_memory_stays_as_it_is():
    """Some hundred frames at a rate that no clock holds back, some of them dropped."""
    statm = Path("/proc/self/statm")
    if not statm.exists():
        pytest.skip("memory is counted from /proc")
    samples = []
    kept = Kept()
    with session(generated(500, (640, 360)), kept, style=POSTER, clock=MONOTONIC, budget=False) as running:
        for _ in range(8):
            count = len(kept.numbers)
            eventually(lambda count=count: len(kept.numbers) > count + 40)
            samples.append(int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20)
        summary = running.end()
    assert summary.frames > 320
    # A picture is 0.35 MB: were each kept, there would be 14 MB more each time.
    growth = [after - before for before, after in itertools.pairwise(samples[2:])]
    assert np.median(growth) < 2, samples
