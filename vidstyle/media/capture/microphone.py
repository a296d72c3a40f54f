"""Microphones: audio capture on the clock of the video."""

from __future__ import annotations

import ctypes
import errno
import os
import re
import sys
import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import av

from vidstyle.errors import DeviceError, error_reason
from vidstyle.media.audio import RATE, AudioChunk, AudioDecoder, audio_stream
from vidstyle.media.capture.camera import SYSTEM_FORMATS
from vidstyle.media.capture.input import MAX_CLOCK_AGE, lost
from vidstyle.media.capture.monotonic import Clock

TONE = f"sine=frequency=440:beep_factor=2:sample_rate={RATE}"
MIN_CHUNK_SECONDS = 0.02
"""Minimum duration of a chunk of audio."""


@dataclass(frozen=True)
class Microphone:
    """A microphone; see `CaptureSource`.

    Attributes:
        device: ALSA's name on Linux ("default", "hw:1,0"), the system's elsewhere; part of a name listed by
            `microphone_list`; or "test", a tone with a beep every second.
    """

    device: str
    reconnects: bool = True

    @property
    def name(self) -> str:
        """The name for messages."""
        return f"microphone {self.device}"

    def open(self, stopping: threading.Event, clock: Clock) -> AudioInput:
        """Open it and start capturing.

        Args:
            stopping: when set, the capture ends.
            clock: for timestamps and pacing.

        Raises:
            DeviceError: missing or busy; the message lists the available microphones.
        """
        if self.device == "test":
            return AudioInput(av.open(TONE, format="lavfi"), self.name, stopping, clock, paced=True)
        try:
            container = _opened(_full_name(self.device))
        except (av.FFmpegError, OSError, ValueError) as error:
            raise DeviceError(self.name, _reason(error), _what_there_is()) from error
        return AudioInput(container, self.name, stopping, clock)


class AudioInput:
    """Captured audio. Iterate over it once, in one thread."""

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        stopping: threading.Event,
        clock: Clock,
        paced: bool = False,
    ) -> None:
        """Read from an open container, which `close` closes.

        Args:
            paced: deliver a generated source no faster than its timestamps.
        """
        self._container, self._name, self._stopping, self._clock = container, name, stopping, clock
        stream = audio_stream(container)
        assert stream is not None
        self._decoder = AudioDecoder(stream)
        self._zero = clock.now() if paced else None

    def __iter__(self) -> Iterator[AudioChunk]:
        """Chunks of audio until it ends.

        Raises:
            InputError: the microphone was lost.
        """
        try:
            for packet in self._pieces():
                now, wall = self._clock.now(), self._clock.wall()
                for stamp, samples in self._decoder.samples(packet):
                    yield AudioChunk(samples, self._taken(stamp, samples.shape[1] / RATE, now, wall))
                if self._stopping.is_set():
                    return
        except (av.FFmpegError, OSError) as error:
            raise lost(self._name, error) from error

    def close(self) -> None:
        """Close it; call it after the iteration."""
        self._container.close()

    def _pieces(self) -> Iterator[av.Packet]:
        """Packets joined to `MIN_CHUNK_SECONDS` or more: drivers deliver up to thousands a second."""
        stream = self._decoder.stream
        context = stream.codec_context
        least = MIN_CHUNK_SECONDS * context.sample_rate * context.channels * context.format.bytes
        waiting: list[av.Packet] = []
        for packet in self._container.demux(stream):
            waiting.append(packet)
            if not context.name.startswith("pcm_"):
                yield waiting.pop()
            elif sum(each.size for each in waiting) >= least or not packet.size:
                joined = av.Packet(b"".join(map(bytes, waiting)))
                joined.stream, joined.pts, joined.time_base = stream, waiting[0].pts, waiting[0].time_base
                yield joined
                waiting = []

    def _taken(self, stamp: float, seconds: float, now: float, wall: float) -> float:
        """Capture time of the first sample of a chunk, in seconds of the clock."""
        if self._zero is None:
            return capture_time(stamp, seconds, now, wall)
        self._clock.wait(self._stopping, max(0.0, self._zero + stamp + seconds - self._clock.now()))
        return self._zero + stamp


def capture_time(stamp: float, seconds: float, now: float, wall: float) -> float:
    """Capture time of the first sample of a chunk that arrives now, by its timestamp if its clock is known.

    ALSA uses the time of day (`wall`), other systems the monotonic clock (`now`).

    >>> capture_time(7.5, 0.1, now=8.0, wall=1000.0), capture_time(1.0, 0.1, now=8.0, wall=1000.0)
    (7.5, 7.9)
    """
    ages = (age for age in (wall - stamp, now - stamp) if 0 <= age < MAX_CLOCK_AGE)
    return now - next(ages, seconds)


def microphone_list() -> list[tuple[str, str]]:
    """The device name and the description of each microphone."""
    if sys.platform in SYSTEM_FORMATS:
        found = av.device.enumerate_input_devices(SYSTEM_FORMATS[sys.platform])
        return [(each.name, each.description) for each in found if "audio" in each.media_types]
    return alsa_microphones()


def _full_name(text: str) -> str:
    """The device whose name or description contains the text, or the text itself."""
    listed = microphone_list()
    if text in (name for name, _ in listed):
        return text
    return next((name for name, own in listed if text.lower() in own.lower()), text)


def _opened(name: str) -> av.container.InputContainer:
    if sys.platform in SYSTEM_FORMATS:
        system_format = SYSTEM_FORMATS[sys.platform]
        return av.open(f"audio={name}" if system_format == "dshow" else f":{name}", "r", system_format)
    return open_alsa(name, RATE)


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number in (errno.EBUSY, errno.EAGAIN):
        return "is in use by another program"
    if number in (errno.EACCES, errno.EPERM):
        return "no permission to open it"
    if not number:
        return "no such microphone"
    return f"cannot be opened: {error_reason(error)}"


def _what_there_is() -> str:
    there = [f"{name} ({own})" for name, own in microphone_list()]
    return "there is " + ", ".join(there) if there else "there is no microphone here"


SOUND = Path("/proc/asound")
SETTINGS = Path("/usr/share/alsa")
MAPS = Path("/proc/self/maps")
HARDWARE = "hw:"
PLUG = "plughw:"
"""ALSA's converting plug-in, so that mono devices and other sample rates work, too."""
MAX_ALSA_ERRORS = 100


def alsa_microphones() -> list[tuple[str, str]]:
    """ALSA name and description of each capture device: ("hw:1,0", "HD Webcam C270, USB Audio")."""
    try:
        cards, devices = (SOUND / "cards").read_text(), (SOUND / "pcm").read_text()
    except OSError:
        return []
    names = dict(re.findall(r"^ *(\d+) \[.*?\]: .*? - (.*)$", cards, re.MULTILINE))
    found = []
    for line in devices.splitlines():
        number, _, name, *ways = (part.strip() for part in line.split(":"))
        card, device = (str(int(part)) for part in number.split("-"))
        if any(way.startswith("capture") for way in ways):
            found.append((f"{HARDWARE}{card},{device}", f"{names.get(card, 'card ' + card)}, {name}"))
    return found


def open_alsa(name: str, rate: int) -> av.container.InputContainer:
    """Open a device by its ALSA name.

    Args:
        name: of the device.
        rate: sample rate to request, in stereo.

    Raises:
        OSError: it cannot be opened; `errno` is ALSA's, or 0 if there is no such device.
    """
    complaints = prepare_alsa()
    complaints.clear()
    if name.startswith(HARDWARE):
        name = PLUG + name.removeprefix(HARDWARE)
    try:
        return av.open(name, "r", "alsa", {"sample_rate": str(rate), "channels": "2"})
    except (av.FFmpegError, OSError) as error:
        number = next((number for number in complaints if number), 0)
        raise OSError(number, os.strerror(number) if number else "no such device") from error


@cache
def prepare_alsa() -> deque[int]:
    """Set up ALSA; returns the list that receives the error numbers that it would otherwise print.

    FFmpeg reports every failure as an input/output error. The ALSA library in PyAV would look for its
    configuration and plug-ins (PipeWire, PulseAudio) where it was built.
    """
    if SETTINGS.is_dir():
        os.environ.setdefault("ALSA_CONFIG_DIR", str(SETTINGS))
    machine = getattr(sys.implementation, "_multiarch", "")
    folders = (Path("/usr/lib", machine), Path("/usr/lib64"), Path("/usr/lib"))
    plugins = next((folder / "alsa-lib" for folder in folders if (folder / "alsa-lib").is_dir()), None)
    if plugins is not None:
        os.environ.setdefault("ALSA_PLUGIN_DIR", str(plugins))
    numbers: deque[int] = deque(maxlen=MAX_ALSA_ERRORS)
    loaded = os.fsdecode(MAPS.read_bytes()) if MAPS.exists() else ""
    if library := re.search("/.*libasound.*[.]so.*", loaded):  # up to the end of the line: paths have spaces
        _note_errors(ctypes.CDLL(library[0]), numbers)
    return numbers


_kept: list[Any] = []
"""Keeps the callback of ALSA alive."""


def _note_errors(library: Any, numbers: deque[int]) -> None:
    text, number = ctypes.c_char_p, ctypes.c_int
    kind = ctypes.CFUNCTYPE(None, text, number, text, number, text)
    _kept.append(kind(lambda file, line, function, error, words: numbers.append(error)))
    library.snd_lib_error_set_handler(_kept[-1])
