"""Microphones: on the clock of the frames, lost and reconnected, missing; a tone, and ALSA if present."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import av
import numpy as np
import pytest
from faults import times
from live import BEGIN, Kept, SimulatedClock, generated, session
from media import make_clip
from waiting import LONG, eventually

from vidstyle import cli
from vidstyle.errors import DeviceError, InputError
from vidstyle.live.capture import MicrophoneCapture
from vidstyle.live.targets import TargetGroup, TargetOptions, target_maker
from vidstyle.media.audio import LIVE_SAMPLE_RATE, AudioChunk
from vidstyle.media.capture import microphone as alsa
from vidstyle.media.capture.microphone import Microphone, capture_time
from vidstyle.media.capture.monotonic import MONOTONIC, Clock
from vidstyle.media.capture.sources import FileSource

PIECE = 0.02
"""Seconds."""
IN_STEP = 0.022
"""Seconds by which sound may be elsewhere than it was made: 0.02 s are taken for trembling, and a bit."""


@dataclass
class Whistle:
    """A source of sound that is loud in some spans of time, and away in one.

    Attributes:
        loud, away: the spans, in seconds after the clock's beginning.
        opened: when it was opened, in the same way.
    """

    loud: tuple[tuple[float, float], ...] = ()
    away: tuple[float, float] = (0.0, 0.0)
    name: str = "whistle"
    reconnects: bool = True
    opened: list[float] = field(default_factory=list)

    def open(self, stopping: threading.Event, clock: Clock) -> Whistle:
        self._stopping, self._clock = stopping, clock
        if not self._is_there():
            raise DeviceError(self.name, "no such microphone")
        self.opened.append(clock.now() - BEGIN)
        return self

    def _is_there(self) -> bool:
        return not self.away[0] <= self._clock.now() - BEGIN < self.away[1]

    def __iter__(self) -> Iterator[AudioChunk]:
        begin = self._clock.now()
        while not self._clock.wait(self._stopping, PIECE):
            if not self._is_there():
                raise InputError(self.name, "was lost: no such device")
            moments = begin - BEGIN + np.arange(round(PIECE * LIVE_SAMPLE_RATE)) / LIVE_SAMPLE_RATE
            level = sum((moments >= first) & (moments < last) for first, last in self.loud)
            yield AudioChunk(np.tile(np.float32(0.5) * level, (2, 1)).astype(np.float32), begin)
            begin += PIECE

    def close(self) -> None: ...


def sounds(film: Path) -> tuple[np.ndarray, float]:
    """The sound from the first picture on, gaps as zeros, and how long its longest gap is, in seconds."""
    track = np.zeros(60 * LIVE_SAMPLE_RATE)
    end, gap = 0.0, 0.0
    with av.open(str(film)) as container:
        zero = next(container.decode(video=0)).time
    with av.open(str(film)) as container:
        for frame in container.decode(audio=0):
            assert frame.time is not None and zero is not None
            begin = max(0.0, frame.time - zero)
            gap, end = max(gap, begin - end), begin + frame.samples / frame.sample_rate
            place = round(begin * LIVE_SAMPLE_RATE)
            samples = frame.to_ndarray()[0, :: 1 if frame.format.is_planar else 2]
            track[place : place + frame.samples] = samples / (1 if samples.dtype.kind == "f" else 2**15)
    return track[: round(end * LIVE_SAMPLE_RATE)], gap


ALWAYS = (0.0, float("inf"))


def test_what_is_heard_lies_in_the_film_when_it_was_heard(tmp_path: Path):
    film, kept = tmp_path / "film.mkv", Kept()
    spans = (1.5, 1.7), (2.1, 2.3), (2.7, 2.9)
    maker = target_maker(str(film), TargetOptions())
    with session(generated(), kept, maker, microphone=Whistle(spans), seconds=3.2) as running:
        running.wait()
    track, gap = sounds(film)
    loud = np.flatnonzero(np.abs(track) > 0.2) / LIVE_SAMPLE_RATE
    begins = [loud[0], *loud[1:][np.diff(loud) > 0.15]]
    wanted = [BEGIN + first - kept.captured[0] for first, _ in spans]
    assert begins == pytest.approx(wanted, abs=IN_STEP) and gap < 0.1


def test_a_lost_microphone_is_silent_and_comes_back(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    film, kept = tmp_path / "film.mkv", Kept()
    whistle = Whistle((ALWAYS,), away=(1.0, 2.0))
    maker = target_maker(str(film), TargetOptions())
    with session(generated(), kept, maker, microphone=whistle, seconds=3.0) as running:
        running.wait()
    assert "there is silence until it is back" in caplog.text
    # It is tried after a quarter, then a half, then a whole second.
    assert whistle.opened == pytest.approx([0.0, 2.75], abs=0.2)
    assert f"whistle: back after {whistle.opened[1] - 1.0:.1f} s" in caplog.text
    track, gap = sounds(film)
    quiet = np.flatnonzero(np.abs(track) < 0.05) / LIVE_SAMPLE_RATE
    assert gap < 0.1, "there is no sound at all, in place of silence"
    assert len(quiet) / LIVE_SAMPLE_RATE == pytest.approx(whistle.opened[1] - 1.0, abs=0.1)
    assert np.abs(track[-LIVE_SAMPLE_RATE // 8 : -LIVE_SAMPLE_RATE // 16]).min() > 0.2
    assert max(np.diff(kept.arrived)) < 1 / 30 + 1e-6, "pictures waited for sound"


def test_there_is_silence_all_the_while():
    """Not only once the sound is back: who plays a stream waits for its sound."""
    pieces: list[AudioChunk] = []
    late: list[float] = []
    clock = SimulatedClock()

    def take(piece: AudioChunk) -> None:
        pieces.append(piece)
        late.append(clock.now() - piece.time - piece.samples.shape[1] / LIVE_SAMPLE_RATE)

    whistle = Whistle((ALWAYS,), away=(0.5, float("inf")))
    listening = MicrophoneCapture(whistle, take, clock)  # type: ignore[arg-type]
    listening.start()
    listening.wait()
    eventually(lambda: pieces[-1].time > BEGIN + 2)
    listening.close(LONG)
    ends = [piece.time + piece.samples.shape[1] / LIVE_SAMPLE_RATE for piece in pieces]
    assert [piece.time for piece in pieces[1:]] == pytest.approx(ends[:-1], abs=0.001)
    assert np.abs(pieces[-1].samples).max() == 0 < np.abs(pieces[0].samples).max()
    assert max(late) < 0.001, "silence comes up to the present"


@pytest.mark.parametrize("microphone", [None, Whistle()])
def test_the_sound_of_the_source_gives_way(
    microphone: Whistle | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The sound of the film is audible, the sound of the microphone is not."""
    heard: list[AudioChunk] = []
    monkeypatch.setattr(TargetGroup, "push_audio", lambda self, chunk: heard.append(chunk))
    film = make_clip(tmp_path / "film.mp4", frames=15, size=(64, 48), audio_tracks=1)
    with session(FileSource(str(film)), microphone=microphone) as running:
        running.wait()
    assert any(np.abs(chunk.samples).max() > 0.01 for chunk in heard) is (microphone is None)
    assert heard


def test_a_tone_is_on_our_clock():
    stopping, clock = threading.Event(), SimulatedClock()
    opened = Microphone("test").open(stopping, clock)
    pieces = []
    for chunk in opened:
        end = chunk.time + chunk.samples.shape[1] / LIVE_SAMPLE_RATE
        assert end == pytest.approx(clock.now()), "it is given out when it ends"
        pieces.append(chunk)
        if len(pieces) == 30:
            stopping.set()
    opened.close()
    begins = [chunk.time for chunk in pieces]
    ends = [chunk.time + chunk.samples.shape[1] / LIVE_SAMPLE_RATE for chunk in pieces]
    assert begins[1:] == pytest.approx(ends[:-1], abs=1e-6), "it has gaps"
    assert begins[0] == pytest.approx(BEGIN) and clock.now() - BEGIN > 0.5


@pytest.mark.parametrize(
    ("stamp", "taken"),
    [(10**9 - 0.5, 0.5), (1000.0 - 0.5, 0.5), (10**9 - 5.0, 0.1), (10**9 + 1.0, 0.1)],
    ids=["clock on the wall", "our clock", "too old", "to come"],
)
def test_stamps_of_known_clocks_are_used(stamp: float, taken: float):
    """Of others, a piece is taken to have ended when it came."""
    assert capture_time(stamp, 0.1, now=1000.0, wall=10**9) == pytest.approx(1000.0 - taken)


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
    monkeypatch.setattr(alsa, "ALSA_FOLDER", tmp_path)


@pytest.mark.skipif(sys.platform != "linux", reason="ALSA is Linux's")
def test_what_can_be_heard_is_listed(two_cards: None, capfd: pytest.CaptureFixture[str]):
    assert alsa.list_alsa_microphones() == [
        ("hw:0,0", "HDA Intel PCH, ALC892 Analog"),
        ("hw:2,0", "C270 HD WEBCAM, USB Audio"),
    ]
    assert cli.main(["live", "--list"]) == 0
    assert "hw:2,0  C270 HD WEBCAM, USB Audio  (microphone)" in capfd.readouterr().out


@pytest.mark.skipif(sys.platform != "linux", reason="ALSA is Linux's")
def test_a_part_of_its_name_will_do(two_cards: None, monkeypatch: pytest.MonkeyPatch):
    opened = []

    def open_alsa(name: str, rate: int) -> None:
        opened.append(name)
        raise OSError(0, "no such device")

    monkeypatch.setattr(alsa, "open_alsa", open_alsa)
    for name in ("c270", "default"):
        with pytest.raises(DeviceError):
            Microphone(name).open(threading.Event(), MONOTONIC)
    assert opened == ["hw:2,0", "default"]


@pytest.mark.skipif("alsa" not in av.formats_available, reason="no ALSA in this build")
def test_a_microphone_that_is_missing_is_one_line(two_cards: None, capfd: pytest.CaptureFixture[str]):
    arguments = ["live", "test", "--microphone", "hw:77", "--style", "plain", "--to", "null"]
    assert cli.main(arguments) == 6
    said = capfd.readouterr().err.splitlines()
    assert said == [
        "vidstyle: microphone hw:77: no such microphone; available: hw:0,0 (HDA Intel PCH, ALC892 Analog), "
        "hw:2,0 (C270 HD WEBCAM, USB Audio)"
    ]


def test_a_microphone_that_fails_opens_no_target(tmp_path: Path):
    film = tmp_path / "film.mp4"
    whistle = Whistle(away=ALWAYS)
    with (
        pytest.raises(DeviceError, match="no such microphone"),
        session(generated(), target_maker(str(film), TargetOptions()), microphone=whistle) as running,
    ):
        running.wait()
    assert not list(tmp_path.iterdir())


def test_one_that_says_nothing_is_not_waited_for_for_ever():
    clock = SimulatedClock()
    listening = MicrophoneCapture(Whistle(), lambda chunk: None, clock)  # type: ignore[arg-type]  # never started: silent
    with pytest.raises(DeviceError, match="has delivered no sound for 5 s"):
        listening.wait()
    assert clock.now() - BEGIN == 5


def test_no_sound_and_a_microphone(capfd: pytest.CaptureFixture[str]):
    assert cli.main(["live", "test", "--microphone", "test", "--audio", "none", "--to", "null"]) == 2
    assert "remove one of them" in capfd.readouterr().err


def test_the_command_records_a_microphone(tmp_path: Path):
    film = tmp_path / "film.mp4"
    arguments = ["live", "test", "--size", "64x48", "--microphone", "test", "--style", "plain"]
    assert cli.main([*arguments, "--to", str(film), "--duration", "1.2", "--no-keys"]) == 0
    track, gap = sounds(film)
    assert gap < 0.1 and len(track) / LIVE_SAMPLE_RATE == pytest.approx(
        times(film)[-1] - times(film)[0], abs=0.4
    )
    assert np.abs(track).max() > 0.05


HEAR = """
import sys, threading
from vidstyle.media.capture.microphone import Microphone
from vidstyle.media.capture.monotonic import MONOTONIC
opened = Microphone(sys.argv[1]).open(threading.Event(), MONOTONIC)
before = MONOTONIC.now()
chunk = next(iter(opened))
print(before - 2.5 < chunk.time < MONOTONIC.now(), chunk.samples.shape[0])
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
        timeout=LONG,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "True 2\n", "")


@pytest.mark.skipif("alsa" not in av.formats_available, reason="no ALSA in this build")
def test_alsa_is_found_in_an_installation_whose_path_has_spaces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = [line for line in alsa.MEMORY_MAPS_FILE.read_text("utf-8").splitlines() if "libasound" in line]
    library = lines[0][lines[0].index("/") :]
    link = tmp_path / "mein Ördner" / Path(library).name
    link.parent.mkdir()
    link.symlink_to(library)
    (tmp_path / "maps").write_text(lines[0].replace(library, str(link)) + "\n", "utf-8")
    monkeypatch.setattr(alsa, "MEMORY_MAPS_FILE", tmp_path / "maps")
    kept = len(alsa._callbacks)
    alsa.prepare_alsa.cache_clear()
    alsa.prepare_alsa()
    alsa.prepare_alsa.cache_clear()  # what comes next sets up the real one again
    assert len(alsa._callbacks) == kept + 1
