"""Microphones: audio capture with times on the clock of the video."""

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
from vidstyle.media.audio import LIVE_SAMPLE_RATE, AudioChunk, AudioDecoder, find_audio_stream
from vidstyle.media.capture.camera import CAPTURE_DEMUXERS
from vidstyle.media.capture.input import MAX_STAMP_AGE_SECONDS, lost_source_error
from vidstyle.media.capture.monotonic import Clock

TONE_FILTER = f"sine=frequency=440:beep_factor=2:sample_rate={LIVE_SAMPLE_RATE}"
MIN_CHUNK_SECONDS = 0.02
"""Minimum duration of a chunk of audio."""


@dataclass(frozen=True)
class Microphone:
    """A microphone; see `CaptureSource`.

    Attributes:
        device: the ALSA name on Linux ("default", "hw:1,0"), the system's name elsewhere; part of a name
            listed by `list_microphones`; or "test", a tone with a beep every second.
    """

    device: str
    reconnects: bool = True

    @property
    def name(self) -> str:
        """The name for messages."""
        return f"microphone {self.device}"

    def open(self, stopping: threading.Event, clock: Clock) -> AudioInput:
        """Open the microphone and start capturing.

        Args:
            stopping: when set, the capture ends.
            clock: for timestamps and pacing.

        Raises:
            DeviceError: it is missing or busy; the message lists the available microphones.
        """
        if self.device == "test":
            return AudioInput(av.open(TONE_FILTER, format="lavfi"), self.name, stopping, clock, paced=True)
        try:
            container = _open_device(_resolve_name(self.device))
        except (av.FFmpegError, OSError, ValueError) as error:
            raise DeviceError(self.name, _reason(error), _suggest_microphones()) from error
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
            paced: whether to deliver a generated source in real time.
        """
        self._container, self._name, self._stopping, self._clock = container, name, stopping, clock
        stream = find_audio_stream(container)
        assert stream is not None
        self._decoder = AudioDecoder(stream)
        self._origin = clock.now() if paced else None

    def __iter__(self) -> Iterator[AudioChunk]:
        """Yield chunks of audio until the capture ends.

        Raises:
            InputError: the microphone was lost.
        """
        try:
            for packet in self._join_packets():
                now, wall = self._clock.now(), self._clock.wall()
                for stamp, samples in self._decoder.samples(packet):
                    yield AudioChunk(
                        samples, self._capture_time(stamp, samples.shape[1] / LIVE_SAMPLE_RATE, now, wall)
                    )
                if self._stopping.is_set():
                    return
        except (av.FFmpegError, OSError) as error:
            raise lost_source_error(self._name, error) from error

    def close(self) -> None:
        """Close the microphone; call it after the iteration."""
        self._container.close()

    def _join_packets(self) -> Iterator[av.Packet]:
        """Join packets to at least `MIN_CHUNK_SECONDS`: drivers deliver up to thousands per second."""
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

    def _capture_time(self, stamp: float, seconds: float, now: float, wall: float) -> float:
        """Return the capture time of the first sample of a chunk, in seconds of the clock."""
        if self._origin is None:
            return capture_time(stamp, seconds, now, wall)
        self._clock.wait(self._stopping, max(0.0, self._origin + stamp + seconds - self._clock.now()))
        return self._origin + stamp


def capture_time(stamp: float, seconds: float, now: float, wall: float) -> float:
    """Return the capture time of the first sample of a chunk, by its timestamp if that is on a known clock.

    The chunk arrives now. ALSA uses the time of day (`wall`), other systems the monotonic clock (`now`).

    >>> capture_time(7.5, 0.1, now=8.0, wall=1000.0), capture_time(1.0, 0.1, now=8.0, wall=1000.0)
    (7.5, 7.9)
    """
    ages = (age for age in (wall - stamp, now - stamp) if 0 <= age < MAX_STAMP_AGE_SECONDS)
    return now - next(ages, seconds)


def list_microphones() -> list[tuple[str, str]]:
    """Return the device name and the description of each microphone."""
    if sys.platform in CAPTURE_DEMUXERS:
        found = av.device.enumerate_input_devices(CAPTURE_DEMUXERS[sys.platform])
        return [(each.name, each.description) for each in found if "audio" in each.media_types]
    return list_alsa_microphones()


def _resolve_name(text: str) -> str:
    """Return the device whose name or description contains the text, or the text itself."""
    listed = list_microphones()
    if text in (name for name, _ in listed):
        return text
    return next((name for name, own in listed if text.lower() in own.lower()), text)


def _open_device(name: str) -> av.container.InputContainer:
    if sys.platform in CAPTURE_DEMUXERS:
        system_format = CAPTURE_DEMUXERS[sys.platform]
        return av.open(f"audio={name}" if system_format == "dshow" else f":{name}", "r", system_format)
    return open_alsa(name, LIVE_SAMPLE_RATE)


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number in (errno.EBUSY, errno.EAGAIN):
        return "is in use by another program"
    if number in (errno.EACCES, errno.EPERM):
        return "no permission to open it"
    if not number:
        return "no such microphone"
    return f"cannot be opened: {error_reason(error)}"


def _suggest_microphones() -> str:
    there = [f"{name} ({own})" for name, own in list_microphones()]
    return "available: " + ", ".join(there) if there else "no microphone found"


ALSA_FOLDER = Path("/proc/asound")
ALSA_SETTINGS_FOLDER = Path("/usr/share/alsa")
MEMORY_MAPS_FILE = Path("/proc/self/maps")
HARDWARE_PREFIX = "hw:"
CONVERTING_PREFIX = "plughw:"
"""Prefix of ALSA's converting plug-in, with which mono devices and other sample rates work, too."""
MAX_ALSA_ERRORS = 100


def list_alsa_microphones() -> list[tuple[str, str]]:
    """Return ALSA name and description of each capture device: ("hw:1,0", "HD Webcam C270, USB Audio")."""
    try:
        cards, devices = (ALSA_FOLDER / "cards").read_text(), (ALSA_FOLDER / "pcm").read_text()
    except OSError:
        return []
    names = dict(re.findall(r"^ *(\d+) \[.*?\]: .*? - (.*)$", cards, re.MULTILINE))
    found = []
    for line in devices.splitlines():
        number, _, name, *ways = (part.strip() for part in line.split(":"))
        card, device = (str(int(part)) for part in number.split("-"))
        if any(way.startswith("capture") for way in ways):
            found.append((f"{HARDWARE_PREFIX}{card},{device}", f"{names.get(card, 'card ' + card)}, {name}"))
    return found


def open_alsa(name: str, rate: int) -> av.container.InputContainer:
    """Open a device by its ALSA name.

    Args:
        name: ALSA name of the device.
        rate: sample rate to request, in stereo.

    Raises:
        OSError: it cannot be opened; `errno` is ALSA's, or 0 if there is no such device.
    """
    complaints = prepare_alsa()
    complaints.clear()
    if name.startswith(HARDWARE_PREFIX):
        name = CONVERTING_PREFIX + name.removeprefix(HARDWARE_PREFIX)
    try:
        return av.open(name, "r", "alsa", {"sample_rate": str(rate), "channels": "2"})
    except (av.FFmpegError, OSError) as error:
        number = next((number for number in complaints if number), 0)
        raise OSError(number, os.strerror(number) if number else "no such device") from error


@cache
def prepare_alsa() -> deque[int]:
    """Set up ALSA; return the list that receives the error numbers that it would otherwise print.

    FFmpeg reports every failure as an input/output error. The ALSA library in PyAV would search for its
    configuration and plug-ins (PipeWire, PulseAudio) in the folders of its build machine.
    """
    if ALSA_SETTINGS_FOLDER.is_dir():
        os.environ.setdefault("ALSA_CONFIG_DIR", str(ALSA_SETTINGS_FOLDER))
    machine = getattr(sys.implementation, "_multiarch", "")
    folders = (Path("/usr/lib", machine), Path("/usr/lib64"), Path("/usr/lib"))
    plugins = next((folder / "alsa-lib" for folder in folders if (folder / "alsa-lib").is_dir()), None)
    if plugins is not None:
        os.environ.setdefault("ALSA_PLUGIN_DIR", str(plugins))
    numbers: deque[int] = deque(maxlen=MAX_ALSA_ERRORS)
    loaded = os.fsdecode(MEMORY_MAPS_FILE.read_bytes()) if MEMORY_MAPS_FILE.exists() else ""
    if library := re.search("/.*libasound.*[.]so.*", loaded):  # up to the end of the line: paths have spaces
        _record_errors(ctypes.CDLL(library[0]), numbers)
    return numbers


_callbacks: list[Any] = []
"""Callbacks of ALSA, to which it holds no reference."""


def _record_errors(library: Any, numbers: deque[int]) -> None:
    text, number = ctypes.c_char_p, ctypes.c_int
    kind = ctypes.CFUNCTYPE(None, text, number, text, number, text)
    _callbacks.append(kind(lambda file, line, function, error, words: numbers.append(error)))
    library.snd_lib_error_set_handler(_callbacks[-1])
