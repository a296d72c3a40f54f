"""Sound trials of `camera_check.py`, on the loopback card of ALSA (snd-aloop).

The second device of the card records the sound that is played on the first.
"""

from __future__ import annotations

import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from tools.drivers.live_program import FlashWriter, run_live, run_to_end, size_options
from vidstyle.media.capture.microphone import prepare_alsa

DRIVER = Path("/sys/bus/platform/drivers/snd_aloop")
CARD = "Loopback"
SOUND_RATE = 48000
CHUNK_COUNT = 480
"""Samples of a chunk: 10 ms."""
CLICK_SECONDS = 0.1
"""Duration of a click."""
QUEUED_SECONDS = 0.5
"""Length of the playback queue, for slow machines."""
MIN_CLICK_LEVEL = 10000
"""Minimum 16-bit sample of a click."""
MAX_OFFSET_SECONDS = 0.08
"""Maximum offset between sound and picture, about the threshold of lip sync."""


class Microphones:
    """Trials of microphones; each returns a line about its result, and fails by an assertion."""

    def __init__(self, virtual: str) -> None:
        cards = Path("/proc/asound/cards").read_text().splitlines() if Path("/proc/asound").is_dir() else []
        prepare_alsa()
        numbers = [line.split()[0] for line in cards if f"[{CARD}" in line]
        self._virtual = virtual
        self._card = numbers[0] if numbers else ""

    def all(self) -> tuple[Callable[[], str], ...]:
        """Return all trials in order."""
        return (self.missing, self.busy, self.in_step, self.unplugged)

    @property
    def _heard(self) -> str:
        assert self._card, "there is no card to play to and to hear"
        return f"hw:{self._card},1"

    def missing(self) -> str:
        """A missing microphone is a one-line error."""
        run = run_to_end("test", "--microphone", "hw:77", "--to", "null")
        assert run.returncode == 6 and self._heard in run.stderr and len(run.stderr.splitlines()) == 1, (
            run.stderr
        )
        return run.stderr.strip()

    def busy(self) -> str:
        """A microphone in use by another program is a one-line error."""
        with av.open(f"{self._heard},0", format="alsa"), av.open(f"{self._heard},1", format="alsa"):
            run = run_to_end("test", "--microphone", self._heard, "--to", "null", *size_options())
        assert run.returncode == 6 and "in use by another program" in run.stderr, run.stderr
        assert len(run.stderr.splitlines()) == 1, run.stderr
        return run.stderr.strip()

    def in_step(self) -> str:
        """A simultaneous flash and click are simultaneous in the film."""
        with tempfile.TemporaryDirectory() as folder:
            film = Path(folder, "film.mkv")
            camera, clicking = FlashWriter(self._virtual), ClickPlayer(f"hw:{self._card},0")
            with run_live(
                self._virtual, "--microphone", self._heard, "--style", "plain", "--to", str(film)
            ) as program:
                program.expect_file(film)
                moments = []
                for _ in range(5):
                    time.sleep(1.7)
                    moment = time.monotonic() + 1.0
                    camera.flash(moment)
                    clicking.click(moment)
                    time.sleep(1.3)
                    moments.append(camera.flashed - clicking.clicked)
            camera.end()
            clicking.end()
            flashes, clicks = find_events(film)
        assert len(flashes) == len(moments), f"{len(moments)} flashes, {flashes} in the film"
        late = [
            click - flash + apart
            for flash, apart in zip(flashes, moments, strict=True)
            for click in clicks
            if abs(click - flash) < 1
        ]
        text = ", ".join(f"{1000 * each:+.0f}" for each in late)
        # A slow machine may lose the first picture of a flash.
        assert len(late) > 2 and abs(statistics.median(late)) < MAX_OFFSET_SECONDS, f"sound is {text} ms late"
        return f"sound is {text} ms late"

    def unplugged(self) -> str:
        """Unbind and bind the card: pictures continue, and the sound reconnects."""
        device = next(path.name for path in DRIVER.glob("snd_aloop.*"))
        with tempfile.TemporaryDirectory() as folder:
            film = Path(folder, "film.mkv")
            with run_live(
                "test", "--microphone", self._heard, "--style", "plain", "--to", str(film)
            ) as program:
                program.expect_file(film)
                time.sleep(2)
                (DRIVER / "unbind").write_text(device)
                program.expect("there is silence until it is back")
                time.sleep(4)
                (DRIVER / "bind").write_text(device)
                bound = time.monotonic()
                program.expect("back after")
                seconds = time.monotonic() - bound
                time.sleep(1)
            with av.open(str(film)) as container:
                times = [float(frame.time or 0) for frame in container.decode(video=0)]
            with av.open(str(film)) as container:
                sounds = [float(frame.time or 0) for frame in container.decode(audio=0)]
        stop, gap = (max(np.diff(each)) for each in (times, sounds))
        assert stop < 1 and gap < 0.2, f"pictures stop for {stop:.2f} s, sound for {gap:.2f} s"
        return f"back {seconds:.1f} s after its return; pictures stop for {stop:.2f} s at most, sound never"


class ClickPlayer:
    """Plays silence, and a click on request.

    Attributes:
        clicked: time at which the click is audible, in seconds of `time.monotonic`.
    """

    def __init__(self, device: str) -> None:
        self.clicked = 0.0
        self._moment = float("inf")
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._play, args=(device,), daemon=True)
        self._thread.start()

    def click(self, moment: float) -> None:
        """Play a click at a time after the queued sound, in seconds of `time.monotonic`."""
        self._moment = moment

    def end(self) -> None:
        """Close the device."""
        self._over.set()
        self._thread.join(10)

    def _play(self, device: str) -> None:
        quiet, loud = (_sound(level) for level in (0, 20000))
        with av.open(device, "w", "alsa") as container:
            stream = container.add_stream("pcm_s16le", rate=SOUND_RATE, layout="stereo")
            container.start_encoding()
            number, zero = 0, time.monotonic()
            while not self._over.is_set():
                heard = zero + number * CHUNK_COUNT / SOUND_RATE
                # A bounded queue makes the time of playback predictable.
                self._over.wait(max(0.0, heard - time.monotonic() - QUEUED_SECONDS))
                due = heard >= self._moment
                if due:
                    self.clicked, self._moment = heard, float("inf")
                frame = loud if heard - self.clicked < CLICK_SECONDS else quiet
                frame.pts, frame.time_base, number = number * CHUNK_COUNT, Fraction(1, SOUND_RATE), number + 1
                container.mux(stream.encode(frame))


def _sound(level: int) -> av.AudioFrame:
    samples = np.full((1, 2 * CHUNK_COUNT), level, np.int16)
    frame = av.AudioFrame.from_ndarray(samples, "s16", "stereo")
    frame.sample_rate = SOUND_RATE
    return frame


def find_events(film: Path) -> tuple[list[float], list[float]]:
    """Return the times at which the picture turns bright and the sound loud, in seconds of the film."""
    bright: list[float] = []
    loud: list[float] = []
    with av.open(str(film)) as container:
        for frame in container.decode(video=0, audio=0):
            assert isinstance(frame, av.VideoFrame | av.AudioFrame) and frame.time is not None
            if isinstance(frame, av.VideoFrame):
                if frame.to_ndarray(format="gray").mean() > 120:
                    bright.append(frame.time)
            else:
                samples = frame.to_ndarray()[0, :: 1 if frame.format.is_planar else 2].astype(float)
                places = np.flatnonzero(np.abs(samples) > MIN_CLICK_LEVEL)
                loud += [frame.time + places[0] / frame.sample_rate] if len(places) else []
    return _event_starts(bright), _event_starts(loud)


def _event_starts(moments: list[float]) -> list[float]:
    """Return the times without another one within the previous half second."""
    return [moment for place, moment in enumerate(moments) if place == 0 or moment - moments[place - 1] > 0.5]
