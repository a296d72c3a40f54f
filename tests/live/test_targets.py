"""Live targets: files, pipes and streams; slow, broken and missing ones."""

from __future__ import annotations

import io
import json
import os
import subprocess
import threading
from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import pytest
from faults import times, video
from live import BEGIN, POSTER, SMALL, FakeClock, Kept, Receiver, generated, live_command, session
from waiting import LONG, eventually

from vidstyle import cli
from vidstyle.errors import DeviceError, OutputError, UsageError
from vidstyle.live import target_thread, targets
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame
from vidstyle.live.target_thread import ConstantRateTarget, FramePacer
from vidstyle.live.targets import FileSink, NullTarget, TargetOptions, target_maker
from vidstyle.media.audio import AudioChunk
from vidstyle.media.write.writer import WriteOptions


def live(*arguments: str) -> subprocess.Popen[bytes]:
    """Run the program with a small moving picture, in a separate process."""
    command = live_command("test", "--size", "160x90", "--device", "cpu", *arguments)
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def test_a_file_has_every_picture_at_its_time(tmp_path: Path):
    film, again = tmp_path / "film.mp4", tmp_path / "film.gif"
    kept = Kept()
    makers = [target_maker(str(path), TargetOptions()) for path in (film, again)]
    with session(generated(), kept, *makers, style=POSTER, frames=20) as running:
        summary = running.wait()
    files = [one for one in summary.deliveries if one.name != "kept"]
    assert [one.state for one in files] == ["closed", "closed"]
    assert len(video(film)) == files[0].delivered and files[0].delivered + files[0].dropped == 20
    passed = kept.captured[-1] - kept.captured[0]
    if not files[0].dropped:
        assert times(film)[-1] - times(film)[0] == pytest.approx(passed, abs=0.002)
    assert (video(again)[0].width, video(again)[0].height) == SMALL
    assert sorted(path.name for path in tmp_path.iterdir()) == ["film.gif", "film.mp4"]


@pytest.mark.parametrize(("format_name", "demuxer"), [("y4m", "yuv4mpegpipe"), ("nut", "nut")])
def test_standard_output(format_name: str, demuxer: str):
    program = live("--style", "plain", "--to", "-", "--format", format_name, "--frames", "20", "--json")
    out, err = program.communicate(timeout=2 * LONG)
    assert program.returncode == 0, err
    summary = json.loads(err.splitlines()[-1])
    with av.open(io.BytesIO(out)) as container:
        frames = list(container.decode(video=0))
        assert container.format.name == demuxer and container.streams.video[0].average_rate == 30
    delivered, repeated = (summary["targets"][0][key] for key in ("delivered", "repeated"))
    assert len(frames) == delivered + repeated >= 15
    assert (frames[0].width, frames[0].height) == SMALL


def test_raw_pictures_in_another_format():
    program = live(
        "--style", "plain", "--to", "-", "--format", "raw", "--pix-fmt", "nv12", "--frames", "10", "--json"
    )
    out, err = program.communicate(timeout=2 * LONG)
    assert program.returncode == 0, err
    assert len(out) % (160 * 90 * 3 // 2) == 0 and len(out) > 0


def test_a_reader_that_goes_ends_it_with_one_line():
    program = live("--style", "plain", "--to", "-")
    assert program.stdout is not None and program.stderr is not None
    program.stdout.read(50_000)
    program.stdout.close()
    assert program.wait(LONG) == 5
    assert program.stderr.read() == b"vidstyle: standard output was closed by its reader\n"
    program.stderr.close()


def test_a_reader_that_stands_still_holds_up_nobody(tmp_path: Path):
    """With a full pipe, the other target continues, the newest picture waits, and the session ends soon."""
    reading, writing = os.pipe()
    film = tmp_path / "film.mkv"
    targets = "--to", "-", "--format", "y4m", "--to", str(film)
    command = live_command("test", "--style", "plain", *targets, "--frames", "40", "--json")
    program = subprocess.Popen(command, stdout=writing, stderr=subprocess.PIPE)
    _, err = program.communicate(timeout=2 * LONG)
    assert program.returncode == 0, err
    pipe, file = json.loads(err.splitlines()[-1])["targets"]
    assert pipe["dropped"] > 20 and file["delivered"] > 30
    os.close(reading)
    os.close(writing)


def test_a_signal_closes_the_file(tmp_path: Path):
    film = tmp_path / "film.mp4"
    program = live("--style", "plain", "--to", str(film))
    partial = tmp_path / "film.partial.mp4"
    eventually(lambda: partial.exists() and partial.stat().st_size > 4096)
    program.terminate()
    _, err = program.communicate(timeout=2 * LONG)
    assert program.returncode == 143, err
    assert len(video(film)) > 3 and not list(tmp_path.glob("*.partial.*"))


@pytest.mark.parametrize(
    ("limit", "words"), [(LONG, ""), (0.01, "was not finished within 0.01 s")], ids=["finished", "failed"]
)
def test_a_file_is_finished_or_has_failed(tmp_path: Path, monkeypatch, limit: float, words: str):
    """As on a busy machine, where the last frames take longer than a stream may."""
    finish, go = FileSink.close, threading.Event()

    def close(self: FileSink) -> None:
        go.wait(LONG if words else 0.2)
        finish(self)

    monkeypatch.setattr(FileSink, "close", close)
    monkeypatch.setattr(targets, "FINISH_SECONDS", limit)
    monkeypatch.setattr(target_thread, "CLOSE_SECONDS", 0.01)
    film = tmp_path / "film.mp4"
    with session(generated(), target_maker(str(film), TargetOptions()), frames=5) as running:
        with pytest.raises(OutputError, match=words) if words else nullcontext():
            running.wait()
        assert film.exists() == (not words)
        go.set()


def test_a_stream_is_sent_again_when_its_reader_is_back(caplog: pytest.LogCaptureFixture):
    first = Receiver()
    url = f"tcp://127.0.0.1:{first.port}"
    kept = Kept()
    with session(generated(), kept, target_maker(url, TargetOptions())) as running:
        eventually(lambda: len(first.content) > 20_000)
        first.hang_up()
        eventually(lambda: (url, "reconnecting") in running.controls.status().targets)
        count = len(kept.numbers)
        eventually(lambda: len(kept.numbers) > count + 3)
        second = Receiver(first.port)
        eventually(lambda: len(second.content) > 20_000)
        assert (url, "running") in running.controls.status().targets
        running.end()
    second.hang_up()
    assert second.frames() > 5
    assert "reconnecting" in caplog.text and f"{url}: reconnected" in caplog.text


def test_a_playlist_with_its_pieces(tmp_path: Path):
    playlist = tmp_path / "live.m3u8"
    with session(generated(), target_maker(str(playlist), TargetOptions()), frames=75) as running:
        running.wait()
    assert "#EXTINF" in playlist.read_text() and list(tmp_path.glob("live*.ts"))
    with av.open(str(playlist)) as container:
        assert sum(1 for _ in container.decode(video=0)) > 50


@pytest.mark.parametrize("name", ["live.m3u8", "live0.ts", "live12.ts"])
def test_a_playlist_and_its_pieces_replace_files_only_when_asked(tmp_path: Path, name: str):
    (tmp_path / name).write_text("mine")
    (tmp_path / "liveliest.ts").write_text("mine")
    playlist = str(tmp_path / "live.m3u8")
    with pytest.raises(UsageError, match=rf"{name} already exists; add -y"):
        target_maker(playlist, TargetOptions())
    assert (tmp_path / name).read_text() == "mine"
    target_maker(playlist, TargetOptions(file=WriteOptions(overwrite=True)))


def test_nothing_new_is_shown_again():
    """A source at 5 a second, a stream at 30: five of six are repeated."""

    class Sink:
        numbers: list[int] = []
        needs_every = True

        def write(self, frame: LiveFrame, number: int) -> None:
            self.numbers.append(number)

        def push_audio(self, chunk: AudioChunk) -> None: ...

        def close(self) -> None: ...

    sink = Sink()

    def make(context):
        return ConstantRateTarget("steady", lambda: sink, replace(context, rate=Fraction(30)))

    with session(generated(5), make, frames=6) as running:
        summary = running.wait()
    assert (summary.frames, summary.dropped, summary.repeated) == (6, 0, 25)
    assert sink.numbers == list(range(31))


def test_the_last_frame_is_written_even_if_it_came_too_early():
    """A source at 60 a second, a stream at 30: of five frames, the third and the last come too early."""
    written: list[tuple[int, int]] = []

    class Sink:
        needs_every = True

        def write(self, frame: LiveFrame, number: int) -> None:
            written.append((frame.number, number))

        def push_audio(self, chunk: AudioChunk) -> None: ...

        def close(self) -> None: ...

    def make(context):
        return ConstantRateTarget("steady", Sink, replace(context, rate=Fraction(30)))

    with session(generated(60), make, frames=5) as running:
        delivery = running.wait().deliveries[0]
    assert written == [(0, 0), (1, 1), (3, 2), (4, 3)]
    assert (delivery.delivered, delivery.repeated, delivery.dropped) == (4, 0, 1)


def test_a_repetition_that_comes_late_leaves_no_slot_out():
    pacer, now = FramePacer(Fraction(30)), 7.0
    slots = [pacer.slot(now)]
    for _ in range(20):
        wait = pacer.timeout(now)
        assert wait is not None
        now += wait + 0.002
        slots.append(pacer.slot(now))
    assert slots == list(range(21))


def test_trembling_is_no_reason_to_drop_or_repeat():
    pacer = FramePacer(Fraction(30))
    moments = [(number + (0.4 if number % 2 else -0.4)) / 30 for number in range(1, 60)]
    assert [pacer.slot(moment + 100) for moment in (0, *moments)] == list(range(60))
    assert pacer.timeout(100 + 59.4 / 30) == pytest.approx(1.35 / 30)


@pytest.mark.parametrize(("rate", "expected"), [(60, 0.5), (15, 1.0)])
def test_another_rate_than_the_source_has(rate: int, expected: float):
    pacer = FramePacer(Fraction(30))
    placed = [pacer.slot(number / rate) for number in range(120)]
    taken = [number for number in placed if number is not None]
    assert len(taken) / 120 == pytest.approx(expected, abs=0.05)
    assert taken == sorted(set(taken)) and taken[-1] == pytest.approx(119 / rate * 30, abs=2)


def test_a_reader_that_stood_still_is_not_flooded():
    pacer = FramePacer(Fraction(30))
    assert [pacer.slot(1.0), pacer.slot(9.0), pacer.slot(9.04)] == [0, 1, 2]


def test_the_meter_counts_by_tenths_of_a_millisecond():
    meter = LatencyMeter(FakeClock())
    assert meter.latency() == meter.recent_latency() == (0, 0)
    for number in range(1, 201):
        meter.record(BEGIN - number / 1000)
    median, worst = meter.latency()
    assert median == pytest.approx(100, abs=0.2) and worst == pytest.approx(198, abs=0.2)
    assert meter.recent_latency() == pytest.approx((101, 199))


@pytest.mark.parametrize(
    ("error", "words", "text", "options"),
    [
        (UsageError, "use y4m, nut, raw", "-", TargetOptions(format="mp4")),
        (UsageError, "not a supported kind of stream", "gopher://127.0.0.1", TargetOptions()),
        (UsageError, "unknown extension", "film.xyz", TargetOptions()),
        (DeviceError, "sudo modprobe v4l2loopback video_nr=77", "/dev/video77", TargetOptions()),
    ],
)
def test_targets_that_cannot_be_are_refused_before_anything_is_opened(
    error: type[Exception], words: str, text: str, options: TargetOptions
):
    with pytest.raises(error, match=words):
        target_maker(text, options)


def test_a_film_that_exists_is_kept_unless_it_may_go(tmp_path: Path):
    film = tmp_path / "film.mp4"
    film.write_bytes(b"dear")
    with pytest.raises(UsageError, match="already exists; add -y"):
        target_maker(str(film), TargetOptions())
    assert film.read_bytes() == b"dear"
    maker = target_maker(str(film), TargetOptions(file=WriteOptions(overwrite=True)))
    with session(generated(), maker, frames=5) as running:
        running.wait()
    assert len(video(film)) > 1


@pytest.mark.parametrize(
    ("error", "words", "text", "options"),
    [
        (OutputError, "cannot be opened", "tcp://127.0.0.1:1", TargetOptions()),
        (UsageError, "there is no video encoder", "tcp://127.0.0.1:1", TargetOptions(codec="quux")),
        (
            UsageError,
            "film.mkv",
            "film.mkv",
            TargetOptions(file=WriteOptions(codec="prores", pix_fmt="rgb24")),
        ),
    ],
)
def test_targets_that_do_not_open_end_the_session(
    error: type[Exception], words: str, text: str, options: TargetOptions, tmp_path: Path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    kept = Kept()
    with (
        pytest.raises(error, match=words),
        session(generated(), kept, target_maker(text, options)) as running,
    ):
        running.wait()
    assert kept.numbers == [] and kept.closed == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["film.mp4", "live.m3u8", "picture.png", "%05d.png", "film.gif"])
def test_a_file_in_a_folder_that_is_missing_is_refused_at_once(tmp_path: Path, capfd, name: str):
    arguments = ["live", "no source", "--to", "null", "--to", str(tmp_path / "no" / name)]
    assert cli.main(arguments) == 5
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1 and "its folder does not exist; add --parents to create it" in said[0]
    assert not list(tmp_path.iterdir())


def test_a_playlist_whose_folder_is_taken_away_is_no_success(tmp_path: Path):
    folder = tmp_path / "pieces"
    folder.mkdir()
    maker = target_maker(str(folder / "live.m3u8"), TargetOptions())
    folder.rmdir()
    with pytest.raises(OutputError, match="was lost"), session(generated(), maker, frames=5) as running:
        running.wait()


def test_a_stream_that_is_lost_before_its_first_frame_is_no_success():
    class Sink:
        needs_every = False

        def write(self, frame: LiveFrame, number: int) -> None:
            raise OutputError("far away", "was lost")

        def close(self) -> None: ...

    def make(context):
        return ConstantRateTarget("far away", Sink, context, reconnects=True)

    with pytest.raises(OutputError, match="was lost"), session(generated(), make, frames=5) as running:
        running.wait()


def test_statistics(capfd: pytest.CaptureFixture[str]):
    arguments = ["live", "test", "--size", "160x90", "--style", "plain", "--to", "null", "--frames", "10"]
    assert cli.main([*arguments, "--stats", "--json", "--device", "cpu"]) == 0
    said = capfd.readouterr()
    lines = said.err.splitlines()
    assert lines[0].startswith("vidstyle: 10 frames in ") and "median" in lines[1] and "null: " in lines[3]
    told = json.loads(said.out)
    assert told["frames"] == 10 and told["targets"][0]["delivered"] == 10
    assert 0 < told["latency_ms"]["median"] <= told["latency_ms"]["p99"]
    assert NullTarget(LatencyMeter()).state == "running"


def test_the_list_of_cameras(capfd: pytest.CaptureFixture[str]):
    assert cli.main(["live", "--list", "--json"]) == 0
    assert isinstance(json.loads(capfd.readouterr().out), list)
