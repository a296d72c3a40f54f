"""The trials of `camera_check.py` that are about sound, on ALSA's loopback card (snd-aloop).

What is played on the card's first device is heard on its second, as if a microphone stood by.
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
from live_program import Flashing, finished, sized, started

from vidstyle.media.capture.microphone import prepare_alsa

DRIVER = Path("/sys/bus/platform/drivers/snd_aloop")
CARD = "Loopback"
SOUND_RATE = 48000
PIECE = 480
"""Samples that are played at once: a hundredth of a second."""
CLICK = 0.1
"""Seconds that a click takes."""
AHEAD = 0.5
"""Seconds that sound is given to the card before it is heard; the machine may be that slow."""
LOUD = 10000
"""Of 16-bit samples, as films of this kind hold them."""
IN_STEP = 0.08
"""Seconds by which sound and picture may differ: films are lip-synchronous up to about this."""


class Microphones:
    """The trials; each returns what it found, and fails by an assertion."""

    def __init__(self, virtual: str) -> None:
        cards = Path("/proc/asound/cards").read_text().splitlines() if Path("/proc/asound").is_dir() else []
        prepare_alsa()
        numbers = [line.split()[0] for line in cards if f"[{CARD}" in line]
        self._virtual = virtual
        self._card = numbers[0] if numbers else ""

    def all(self) -> tuple[Callable[[], str], ...]:
        """In their order."""
        return (self.missing, self.busy, self.in_step, self.unplugged)

    @property
    def _heard(self) -> str:
        assert self._card, "there is no card to play to and to hear"
        return f"hw:{self._card},1"

    def missing(self) -> str:
        """A microphone that is not there."""
        run = finished("test", "--microphone", "hw:77", "--to", "null")
        assert run.returncode == 6 and self._heard in run.stderr and len(run.stderr.splitlines()) == 1, (
            run.stderr
        )
        return run.stderr.strip()

    def busy(self) -> str:
        """A microphone that another program has."""
        with av.open(f"{self._heard},0", format="alsa"), av.open(f"{self._heard},1", format="alsa"):
            run = finished("test", "--microphone", self._heard, "--to", "null", *sized())
        assert run.returncode == 6 and "in use by another program" in run.stderr, run.stderr
        assert len(run.stderr.splitlines()) == 1, run.stderr
        return run.stderr.strip()

    def in_step(self) -> str:
        """A flash before the camera and a click before the microphone are at one moment in the film."""
        with tempfile.TemporaryDirectory() as folder:
            film = Path(folder, "film.mkv")
            camera, clicking = Flashing(self._virtual), Clicking(f"hw:{self._card},0")
            with started(
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
            flashes, clicks = flashes_and_clicks(film)
        assert len(flashes) == len(moments), f"{len(moments)} flashes, {flashes} in the film"
        late = [
            click - flash + apart
            for flash, apart in zip(flashes, moments, strict=True)
            for click in clicks
            if abs(click - flash) < 1
        ]
        text = ", ".join(f"{1000 * each:+.0f}" for each in late)
        # A slow machine may lose the first picture of a flash.
        assert len(late) > 2 and abs(statistics.median(late)) < IN_STEP, f"sound is {text} ms late"
        return f"sound is {text} ms late"

    def unplugged(self) -> str:
        """The card is taken away and put back: pictures go on, and the sound comes back."""
        device = next(path.name for path in DRIVER.glob("snd_aloop.*"))
        with tempfile.TemporaryDirectory() as folder:
            film = Path(folder, "film.mkv")
            with started(
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


class Clicking:
    """Plays silence, and a click when it is told to.

    Attributes:
        clicked: when it was to be heard, in seconds of `time.monotonic`.
    """

    def __init__(self, device: str) -> None:
        self.clicked = 0.0
        self._moment = float("inf")
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._play, args=(device,), daemon=True)
        self._thread.start()

    def click(self, moment: float) -> None:
        """Click at this moment, which is far enough away to be put before it into what is played."""
        self._moment = moment

    def end(self) -> None:
        """Let go of the device."""
        self._over.set()
        self._thread.join(10)

    def _play(self, device: str) -> None:
        quiet, loud = (_sound(level) for level in (0, 20000))
        with av.open(device, "w", "alsa") as container:
            stream = container.add_stream("pcm_s16le", rate=SOUND_RATE, layout="stereo")
            container.start_encoding()
            number, zero = 0, time.monotonic()
            while not self._over.is_set():
                heard = zero + number * PIECE / SOUND_RATE
                # No more is put in than is heard soon, so that it is known when it is heard.
                self._over.wait(max(0.0, heard - time.monotonic() - AHEAD))
                due = heard >= self._moment
                if due:
                    self.clicked, self._moment = heard, float("inf")
                frame = loud if heard - self.clicked < CLICK else quiet
                frame.pts, frame.time_base, number = number * PIECE, Fraction(1, SOUND_RATE), number + 1
                container.mux(stream.encode(frame))


def _sound(level: int) -> av.AudioFrame:
    samples = np.full((1, 2 * PIECE), level, np.int16)
    frame = av.AudioFrame.from_ndarray(samples, "s16", "stereo")
    frame.sample_rate = SOUND_RATE
    return frame


def flashes_and_clicks(film: Path) -> tuple[list[float], list[float]]:
    """When the picture turns bright and the sound loud, in seconds of the film."""
    bright: list[float] = []
    loud: list[float] = []
    with av.open(str(film)) as container:
        for frame in container.decode(video=0, audio=0):
            assert frame.time is not None
            if isinstance(frame, av.VideoFrame):
                if frame.to_ndarray(format="gray").mean() > 120:
                    bright.append(frame.time)
            else:
                samples = frame.to_ndarray()[0, :: 1 if frame.format.is_planar else 2].astype(float)
                places = np.flatnonzero(np.abs(samples) > LOUD)
                loud += [frame.time + places[0] / frame.sample_rate] if len(places) else []
    return _beginnings(bright), _beginnings(loud)


def _beginnings(moments: list[float]) -> list[float]:
    """The moments that have none within half a second before them."""
    return [moment for place, moment in enumerate(moments) if place == 0 or moment - moments[place - 1] > 0.5]
