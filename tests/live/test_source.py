"""Live sources: names, pipes, files and streams; lost, reconnected, or unavailable."""

from __future__ import annotations

import contextlib
import io
import os
import socket
import subprocess
import sys
import threading
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from live import FakeClock, Kept, live_command, session
from media import make_clip
from waiting import LONG, eventually

from vidstyle import cli
from vidstyle.cli.live import live
from vidstyle.errors import DeviceError, InputError, UsageError
from vidstyle.media.capture import sources
from vidstyle.media.capture.camera import Camera, Screen, choose_mode, mode_rate
from vidstyle.media.capture.input import CapturedFrame, LiveInput, LiveSource, PlaybackClock
from vidstyle.media.capture.monotonic import MONOTONIC
from vidstyle.media.capture.sources import (
    FileSource,
    GeneratedPicture,
    NetworkSource,
    PipeSource,
    SourceOptions,
    resolve_source,
)
from vidstyle.media.v4l2 import CameraMode

Y4M = b"YUV4MPEG2 W64 H48 F30:1 Ip A1:1 C420jpeg\n"
BYTES = 64 * 48 * 3 // 2


class Writer:
    """Writes gray y4m frames into a named pipe, in real time, until it is stopped."""

    def __init__(self, path: Path, level: int) -> None:
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._write, args=(path, level), daemon=True)
        self._thread.start()

    def _write(self, path: Path, level: int) -> None:
        with path.open("wb", buffering=0) as pipe:
            pipe.write(Y4M)
            while not self._over.wait(1 / 30):
                pipe.write(b"FRAME\n" + bytes([level]) * (64 * 48) + bytes([128]) * (BYTES - 64 * 48))

    def end(self) -> None:
        self._over.set()
        self._thread.join(LONG)


def luma(kept: Kept) -> int:
    assert kept.newest is not None
    return bytes(kept.newest.planes[0])[0]


WORDS = [
    ("test", GeneratedPicture),
    ("screen", Screen),
    ("screen::1", Screen),
    ("-", PipeSource),
    ("rtsp://127.0.0.1/x", NetworkSource),
    ("clip.mp4", FileSource),
    ("folder/clip", FileSource),
    ("camera", Camera),
    ("/dev/video3", Camera),
    ("0", Camera),
    ("HD Webcam", Camera),
]


@pytest.mark.parametrize(("word", "kind"), WORDS)
def test_words_for_sources(word: str, kind: type):
    assert isinstance(resolve_source(word, SourceOptions()), kind)


def test_every_kind_of_source_is_tested_and_named_in_the_help() -> None:
    declared = {each for each in vars(sources).values() if str(each).startswith("<class 'vidstyle.")}
    kinds = {each for each in declared if hasattr(each, "open")} - {LiveSource}
    assert kinds == {kind for _, kind in WORDS}
    assert live.help is not None
    named = live.help.replace(",", " ").split()
    assert [word for word, _ in WORDS if (word.isalpha() or word == "-") and word not in named] == []


def test_a_film_plays_at_its_own_pace_and_again(tmp_path: Path):
    clip = make_clip(tmp_path / "clip.mp4", frames=15, size=(64, 48))
    kept = Kept()
    with session(FileSource(str(clip)), kept) as running:
        summary = running.wait()
    assert (summary.frames, summary.dropped) == (15, 0)
    assert np.diff(kept.arrived) == pytest.approx(1 / 30, abs=0.001)
    looped = Kept()
    with session(FileSource(str(clip), loop=True), looped, frames=40) as running:
        running.wait()
    assert len(looped.numbers) == 40


def test_the_pace_goes_on_over_the_seam_of_a_loop():
    pace = PlaybackClock()
    assert [pace.until(number / 10, 7.0) for number in range(5)] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4])
    pace.restart()
    assert pace.until(0.0, 7.0) == pytest.approx(0.5)
    assert pace.until(1000.0, 7.0) == pytest.approx(0.6), "a leap of the stamps is no reason to wait"
    assert pace.until(1000.1, 9.0) == 0, "it is late"


def test_a_source_is_lost_and_comes_back(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    fifo = tmp_path / "camera"
    os.mkfifo(fifo)
    kept = Kept()
    with session(resolve_source(str(fifo), SourceOptions()), kept, clock=MONOTONIC) as running:
        first = Writer(fifo, 60)
        eventually(lambda: len(kept.numbers) > 5)
        assert luma(kept) == 60
        first.end()
        eventually(lambda: running.controls.status().source_state == "waiting")
        count = len(kept.numbers)
        second = Writer(fifo, 200)
        eventually(lambda: len(kept.numbers) > count + 5 and luma(kept) == 200)
        assert running.controls.status().source_state == "running"
        second.end()
        running.end()
    assert "the last frame is repeated" in caplog.text and "back after" in caplog.text
    assert kept.newest is not None and (kept.newest.width, kept.newest.height) == (64, 48)


SERVER = """
import sys, time, av
port, size = int(sys.argv[1]), int(sys.argv[2])
with av.open(f"tcp://127.0.0.1:{port}?listen=1", "w", "mpegts") as out:
    stream = out.add_stream("mpeg2video", rate=25)
    stream.width, stream.height, stream.pix_fmt, stream.gop_size = size, size * 3 // 4, "yuv420p", 5
    for number in range(10**6):
        frame = av.VideoFrame(stream.width, stream.height, "yuv420p")
        frame.pts = number
        for plane in frame.planes:
            plane.update(bytes([100 + number % 50]) * plane.buffer_size)
        out.mux(stream.encode(frame))
        time.sleep(1 / 25)
"""


def serve(port: int, size: int) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", SERVER, str(port), str(size)], stderr=subprocess.DEVNULL)


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def is_taken(port: int) -> bool:
    """Return whether a process listens on this port."""
    with socket.socket() as tried, contextlib.suppress(OSError):
        tried.bind(("127.0.0.1", port))
        return False
    return True


def test_a_stream_whose_server_is_killed_and_restarted(caplog: pytest.LogCaptureFixture):
    kept, port = Kept(), free_port()
    server = serve(port, 128)
    try:
        eventually(lambda: is_taken(port))
        with session(NetworkSource(f"tcp://127.0.0.1:{port}"), kept, clock=MONOTONIC) as running:
            eventually(lambda: len(kept.numbers) > 5)
            server.kill()
            server.wait()
            eventually(lambda: running.controls.status().source_state == "waiting")
            count = len(kept.numbers)
            # Another size: what goes out keeps the first one.
            server = serve(port, 64)
            eventually(lambda: len(kept.numbers) > count + 5)
            assert kept.newest is not None and (kept.newest.width, kept.newest.height) == (128, 96)
            running.end()
    finally:
        server.kill()
        server.wait()
    assert "back after" in caplog.text


def test_raw_video_on_standard_input(tmp_path: Path):
    raw = "--input-format", "raw", "--input-size", "64x48", "--input-fps", "100"
    command = live_command("-", *raw, "--style", "plain", "--to", "-", "--format", "y4m")
    frames = b"".join(bytes([50 + number]) * BYTES for number in range(40))
    run = subprocess.run(command, input=frames, capture_output=True, timeout=2 * LONG)
    assert run.returncode == 0, run.stderr
    with av.open(io.BytesIO(run.stdout)) as container:
        levels = [bytes(frame.planes[0])[0] for frame in container.decode(video=0)]
    assert levels == sorted(levels) and levels[0] >= 50 and levels[-1] > 60


def test_y4m_on_standard_input_and_its_end():
    command = live_command("-", "--style", "plain", "--to", "null", "--json")
    frames = Y4M + (b"FRAME\n" + bytes(BYTES)) * 20
    run = subprocess.run(command, input=frames, capture_output=True, timeout=2 * LONG)
    assert run.returncode == 0, run.stderr
    assert b'"source": "-"' in run.stdout


@pytest.mark.parametrize(
    ("code", "words", "arguments"),
    [
        (6, "no such camera; ", ["nothing-like-that"]),
        (6, "no such camera; ", ["/dev/video99"]),
        (6, "is not a camera; ", ["/dev/null"]),
        (3, "no such file", ["missing.mp4"]),
        (3, "cannot be opened: Connection refused", ["tcp://127.0.0.1:1"]),
        (3, "does not support quux", ["quux://127.0.0.1:1"]),
        (2, "has no header with its size", ["-", "--input-format", "raw"]),
        (2, "'9' is not a size", ["test", "--size", "9"]),
        (6, "there is no such screen", ["screen:nowhere:7"]),
    ],
)
def test_what_cannot_be_had_is_one_line(
    code: int, words: str, arguments: list[str], capfd: pytest.CaptureFixture[str]
):
    assert cli.main(["live", *arguments, "--style", "plain", "--to", "null"]) == code
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1 and words in said[0], said


MODES = [
    CameraMode("yuyv422", 640, 480, (Fraction(30), Fraction(15))),
    CameraMode("yuyv422", 1280, 720, (Fraction(10),)),
    CameraMode("mjpeg", 1280, 720, (Fraction(30), Fraction(60))),
    CameraMode("mjpeg", 1920, 1080, (Fraction(30000, 1001),)),
]


@pytest.mark.parametrize(
    ("size", "rate", "chosen"),
    [
        (None, 30, 2),
        (None, 10, 1),
        ((1280, 720), 10, 1),
        ((640, 480), 30, 0),
        ((1920, 1080), 30, 3),
        ((640, 360), 30, 0),
        ((640, 480), 60, 2),
        ((900, 600), 10, 1),
        ((4000, 3000), 30, 3),
    ],
)
def test_the_mode_that_reaches_size_and_rate(size: tuple[int, int] | None, rate: int, chosen: int):
    assert choose_mode(MODES, size, Fraction(rate)) == MODES[chosen]


def test_the_slowest_rate_that_is_enough():
    assert mode_rate(MODES[2], Fraction(25)) == 30
    assert mode_rate(MODES[3], Fraction(30)) == Fraction(30000, 1001)
    assert mode_rate(MODES[1], Fraction(30)) == 10
    assert choose_mode([], None, Fraction(30)) is None


def test_secrets_in_an_address_are_kept():
    source = resolve_source("rtsp://me:secret@127.0.0.1:1/camera?token=1", SourceOptions())
    assert source.name == "rtsp://127.0.0.1:1/camera"
    with pytest.raises(InputError, match="rtsp://127.0.0.1:1/camera cannot be opened") as raised:
        source.open(threading.Event(), MONOTONIC)
    assert "secret" not in str(raised.value) and "token" not in str(raised.value)


def test_errors_name_the_source():
    stopping = threading.Event()
    with pytest.raises(DeviceError, match="no such camera"):
        Camera("/dev/video99").open(stopping, MONOTONIC)
    with pytest.raises(InputError, match="nope.mp4: no such file"):
        FileSource("nope.mp4").open(stopping, MONOTONIC)
    with pytest.raises(UsageError, match="--input-size"):
        PipeSource("-", SourceOptions(format="raw")).open(stopping, MONOTONIC)


def test_times_of_a_driver_are_used_while_they_are_plausible(tmp_path: Path) -> None:
    """Old ones, later ones than the clock's, and times of another clock are replaced by the arrival."""
    times = [Fraction(each) for each in ("997", "999.5", "999.9", "1000.5")]
    clip = make_clip(tmp_path / "clip.mkv", frames=4, size=(64, 48), times=times, codec="ffv1")
    clock = FakeClock()
    for stamped, expected in ((True, [1000, 999.5, 999.9, 1000]), (False, [1000] * 4)):
        frames = LiveInput(av.open(str(clip)), "camera", threading.Event(), clock, stamped=stamped)
        captured = [each.time for each in frames if isinstance(each, CapturedFrame)]
        frames.close()
        assert captured == pytest.approx(expected, abs=0.002)
