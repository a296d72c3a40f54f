"""Microphones: on the clock of the frames, lost and reconnected, missing; a tone, and ALSA if present."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np
import pytest
from live import Kept, eventually, generated, session

from vidstyle import cli
from vidstyle.errors import DeviceError, InputError
from vidstyle.live.capture import MicrophoneCapture
from vidstyle.live.control import Controls, LiveOptions
from vidstyle.live.session import LiveSession
from vidstyle.live.targets import TargetGroup, TargetOptions, target_maker
from vidstyle.media.audio import RATE, AudioChunk
from vidstyle.media.capture import microphone
from vidstyle.media.capture import microphone as alsa
from vidstyle.media.capture.microphone import Microphone
from vidstyle.style import load_style

PIECE = 0.02
"""Seconds."""
IN_STEP = 0.022
"""Seconds by which sound may be elsewhere than it was made: 0.02 s are taken for trembling, and a bit."""


@dataclass
class Whistle:
    """A source of sound that is loud within some spans of time, and breaks off when it is told to."""

    loud: tuple[tuple[float, float], ...] = ()
    name: str = "whistle"
    reconnects: bool = True
    there: bool = True
    opened: int = 0

    def open(self, stopping: threading.Event) -> Whistle:
        if not self.there:
            raise DeviceError(self.name, "no such microphone")
        self.opened += 1
        self._stopping = stopping
        return self

    def __iter__(self) -> Iterator[AudioChunk]:
        begin = time.monotonic()
        while not self._stopping.wait(PIECE):
            if not self.there:
                raise InputError(self.name, "was lost: no such device")
            while begin + PIECE < time.monotonic():
                moments = begin + np.arange(round(PIECE * RATE)) / RATE
                level = sum((moments >= first) & (moments < last) for first, last in self.loud)
                yield AudioChunk(np.tile(np.float32(0.5) * level, (2, 1)).astype(np.float32), begin)
                begin += PIECE

    def close(self) -> None: ...


def sounds(film: Path) -> tuple[np.ndarray, float]:
    """The sound from the first picture on, gaps as zeros, and how long its longest gap is, in seconds."""
    track = np.zeros(60 * RATE)
    end, gap = 0.0, 0.0
    with av.open(str(film)) as container:
        zero = next(container.decode(video=0)).time
    with av.open(str(film)) as container:
        for frame in container.decode(audio=0):
            assert frame.time is not None and zero is not None
            begin = max(0.0, frame.time - zero)
            gap, end = max(gap, begin - end), begin + frame.samples / frame.sample_rate
            place = round(begin * RATE)
            samples = frame.to_ndarray()[0, :: 1 if frame.format.is_planar else 2]
            track[place : place + frame.samples] = samples / (1 if samples.dtype.kind == "f" else 2**15)
    return track[: round(end * RATE)], gap


def test_what_is_heard_lies_in_the_film_when_it_was_heard(tmp_path: Path):
    film, kept = tmp_path / "film.mkv", Kept()
    now = time.monotonic()
    spans = tuple((now + second, now + second + 0.2) for second in (1.5, 2.1, 2.7))
    with session(
        generated(), kept, target_maker(str(film), TargetOptions()), microphone=Whistle(spans)
    ) as running:
        eventually(lambda: kept.captured and kept.captured[-1] > spans[-1][1] + 0.3)
        running.end()
    track, gap = sounds(film)
    loud = np.flatnonzero(np.abs(track) > 0.2) / RATE
    begins = [loud[0], *loud[1:][np.diff(loud) > 0.15]]
    wanted = [first - kept.captured[0] for first, _ in spans]
    assert begins == pytest.approx(wanted, abs=IN_STEP) and gap < 0.1


def test_a_lost_microphone_is_silent_and_comes_back(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    film, kept = tmp_path / "film.mkv", Kept()
    whistle = Whistle(((0.0, float("inf")),))
    with session(generated(), kept, target_maker(str(film), TargetOptions()), microphone=whistle) as running:
        eventually(lambda: len(kept.numbers) > 10)
        whistle.there = False
        eventually(lambda: "there is silence until it is back" in caplog.text)
        count = len(kept.numbers)
        eventually(lambda: len(kept.numbers) > count + 30)
        whistle.there = True
        eventually(lambda: "whistle: back after" in caplog.text)
        count = len(kept.numbers)
        eventually(lambda: len(kept.numbers) > count + 15)
        running.end()
    assert whistle.opened == 2
    track, gap = sounds(film)
    quiet = np.flatnonzero(np.abs(track) < 0.05) / RATE
    assert gap < 0.1, "there is no sound at all, in place of silence"
    assert 0.8 < len(quiet) / RATE < 6 and np.abs(track[-RATE // 4 : -RATE // 8]).min() > 0.2
    assert max(np.diff(kept.arrived)) < 1, "pictures waited for sound"


def test_there_is_silence_all_the_while():
    """Not only once the sound is back: who plays a stream waits for its sound."""
    pieces: list[AudioChunk] = []
    whistle = Whistle(((0.0, float("inf")),))
    listening = MicrophoneCapture(whistle, pieces.append)  # type: ignore[arg-type]
    listening.start()
    listening.wait()
    whistle.there = False
    lost = time.monotonic()
    eventually(lambda: pieces[-1].time > lost + 1.2)
    listening.close(2.0)
    ends = [piece.time + piece.samples.shape[1] / RATE for piece in pieces]
    assert [piece.time for piece in pieces[1:]] == pytest.approx(ends[:-1], abs=0.001)
    assert np.abs(pieces[-1].samples).max() == 0 < np.abs(pieces[0].samples).max()


@pytest.mark.parametrize("microphone", [None, Microphone("test")])
def test_the_sound_of_the_source_gives_way(microphone: Microphone | None, monkeypatch: pytest.MonkeyPatch):
    heard, piece = [], AudioChunk(np.zeros((2, 10), np.float32), 0.0)
    monkeypatch.setattr(TargetGroup, "push_audio", lambda self, chunk: heard.append(chunk))
    options = LiveOptions(device="cpu", microphone=microphone)
    live = LiveSession(generated(), Controls(load_style("plain")), [], options)
    live._push_source_audio(piece)
    live._processor.close(2.0)
    assert heard == ([] if microphone else [piece])


def test_a_tone_is_on_our_clock():
    stopping = threading.Event()
    opened = Microphone("test").open(stopping)
    before = time.monotonic()
    pieces = []
    for chunk in opened:
        assert chunk.time + chunk.samples.shape[1] / RATE <= time.monotonic() + 0.001, (
            "it was given too early"
        )
        pieces.append(chunk)
        if len(pieces) == 30:
            stopping.set()
    opened.close()
    begins = [chunk.time for chunk in pieces]
    ends = [chunk.time + chunk.samples.shape[1] / RATE for chunk in pieces]
    assert begins[1:] == pytest.approx(ends[:-1], abs=1e-6), "it has gaps"
    assert abs(begins[0] - before) < 0.2 and time.monotonic() - before > 0.5


@pytest.mark.parametrize(
    ("clock", "age", "taken"),
    [(time.time, 0.5, 0.5), (time.monotonic, 0.5, 0.5), (time.time, 5.0, 0.1), (time.time, -1.0, 0.1)],
    ids=["clock on the wall", "our clock", "too old", "to come"],
)
def test_stamps_of_known_clocks_are_used(clock, age: float, taken: float):
    """Of others, a piece is taken to have ended when it came."""
    opened = Microphone("test").open(threading.Event())
    opened._zero = None
    now = time.monotonic()
    assert opened._taken(clock() - age, 0.1, now) == pytest.approx(now - taken, abs=0.02)
    opened.close()


CARDS = """ 0 [PCH            ]: HDA-Intel - HDA Intel PCH
                      HDA Intel PCH at 0xdf240000 irq 130
 2 [C270           ]: USB-Audio - C270 HD WEBCAM
                      Logitech C270 HD WEBCAM at usb-0000:00:14.0-3, high speed
"""
DEVICES = """00-00: ALC892 Analog : ALC892 Analog : playback 1 : capture 1
00-03: HDMI 0 : HDMI 0 : playback 1
02-00: USB Audio : USB Audio : capture 1
"""


@pytest.fixture
def two_cards(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cards").write_text(CARDS)
    (tmp_path / "pcm").write_text(DEVICES)
    monkeypatch.setattr(alsa, "SOUND", tmp_path)


@pytest.mark.skipif(sys.platform != "linux", reason="ALSA is Linux's")
def test_what_can_be_heard_is_listed(two_cards: None, capfd: pytest.CaptureFixture[str]):
    assert alsa.alsa_microphones() == [
        ("hw:0,0", "HDA Intel PCH, ALC892 Analog"),
        ("hw:2,0", "C270 HD WEBCAM, USB Audio"),
    ]
    assert microphone._full_name("c270") == "hw:2,0" and microphone._full_name("default") == "default"
    assert cli.main(["live", "--list"]) == 0
    assert "hw:2,0  C270 HD WEBCAM, USB Audio  (microphone)" in capfd.readouterr().out


@pytest.mark.skipif("alsa" not in av.formats_available, reason="no ALSA in this build")
def test_a_microphone_that_is_missing_is_one_line(two_cards: None, capfd: pytest.CaptureFixture[str]):
    arguments = ["live", "test", "--microphone", "hw:77", "--style", "plain", "--to", "null"]
    assert cli.main(arguments) == 6
    said = capfd.readouterr().err.splitlines()
    assert said == [
        "vidstyle: microphone hw:77: no such microphone; there is hw:0,0 (HDA Intel PCH, ALC892 Analog), "
        "hw:2,0 (C270 HD WEBCAM, USB Audio)"
    ]


def test_a_microphone_that_fails_opens_no_target(tmp_path: Path):
    film = tmp_path / "film.mp4"
    whistle = Whistle(there=False)
    with (
        pytest.raises(DeviceError, match="no such microphone"),
        session(generated(), target_maker(str(film), TargetOptions()), microphone=whistle) as running,
    ):
        running.wait()
    assert not list(tmp_path.iterdir())


def test_one_that_says_nothing_is_not_waited_for_for_ever(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("vidstyle.live.capture.FIRST_CHUNK_SECONDS", 0.1)
    listening = MicrophoneCapture(Whistle(), lambda chunk: None)  # type: ignore[arg-type]  # never started: silent
    with pytest.raises(DeviceError, match="gave no sound in 0.1 s"):
        listening.wait()


def test_no_sound_and_a_microphone(capfd: pytest.CaptureFixture[str]):
    assert cli.main(["live", "test", "--microphone", "test", "--audio", "none", "--to", "null"]) == 2
    assert "leave one of them out" in capfd.readouterr().err


def test_the_command_records_a_microphone(tmp_path: Path):
    film = tmp_path / "film.mp4"
    arguments = ["live", "test", "--size", "64x48", "--microphone", "test", "--style", "plain"]
    assert cli.main([*arguments, "--to", str(film), "--duration", "1.2", "--no-keys"]) == 0
    track, gap = sounds(film)
    assert gap < 0.1 and len(track) / RATE == pytest.approx(1.2, abs=0.4)
    assert np.abs(track).max() > 0.05


HEAR = """
import sys, threading, time
from vidstyle.media.capture.microphone import Microphone
from vidstyle.style import load_style
opened = Microphone(sys.argv[1]).open(threading.Event())
chunk = next(iter(opened))
print(abs(time.monotonic() - chunk.time) < 2.5, chunk.samples.shape[0])
opened.close()
"""


@pytest.mark.skipif("alsa" not in av.formats_available, reason="no ALSA in this build")
def test_the_real_alsa(tmp_path: Path):
    """Its own library and its own settings, with a device that needs no hardware."""
    settings = tmp_path / "asound.conf"
    settings.write_text("pcm.nothing { type null }\n")
    run = subprocess.run(
        [sys.executable, "-c", HEAR, "nothing"],
        env={**os.environ, "ALSA_CONFIG_PATH": str(settings)},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "True 2\n", "")
