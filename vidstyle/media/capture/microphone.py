"""Microphones: audio capture on the clock of the video."""

from __future__ import annotations

import ctypes
import errno
import os
import re
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import av

from vidstyle.errors import DeviceError, error_reason
from vidstyle.media.audio import RATE, AudioChunk, AudioDecoder
from vidstyle.media.capture.camera import SYSTEM_FORMATS
from vidstyle.media.capture.input import MAX_CLOCK_AGE, lost

TONE = f"sine=frequency=440:beep_factor=2:sample_rate={RATE}"
MIN_CHUNK_SECONDS = 0.02
"""How long a piece of sound is at least."""


@dataclass(frozen=True)
class Microphone:
    """A microphone that can be opened again and again.

    Attributes:
        device: ALSA's name on Linux ("default", "hw:1,0"), elsewhere the system's; part of a name that
            `microphone_list` gives; or "test", a tone with a beep in every second.
    """

    device: str
    reconnects: bool = True

    @property
    def name(self) -> str:
        """What it is, for people."""
        return f"microphone {self.device}"

    def open(self, stopping: threading.Event) -> AudioInput:
        """Begin to listen.

        Args:
            stopping: ends what was opened.

        Raises:
            DeviceError: missing or busy; the message says what there is.
        """
        if self.device == "test":
            return AudioInput(av.open(TONE, format="lavfi"), self.name, stopping, paced=True)
        try:
            container = _opened(_full_name(self.device))
        except (av.FFmpegError, OSError, ValueError) as error:
            raise DeviceError(self.name, _reason(error), _what_there_is()) from error
        return AudioInput(container, self.name, stopping)


class AudioInput:
    """Captured audio. Iterate over it once, in one thread."""

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        stopping: threading.Event,
        paced: bool = False,
    ) -> None:
        """Begin with an open container, which `close` closes.

        Args:
            paced: it would come at once, and is given out no faster than its stamps say.
        """
        self._container, self._name, self._stopping = container, name, stopping
        self._decoder = AudioDecoder(container)
        self._zero = time.monotonic() if paced else None

    def __iter__(self) -> Iterator[AudioChunk]:
        """Pieces of sound until it ends.

        Raises:
            InputError: it was lost.
        """
        try:
            for packet in self._pieces():
                arrived = time.monotonic()
                for stamp, samples in self._decoder.samples(packet):
                    yield AudioChunk(samples, self._taken(stamp, samples.shape[1] / RATE, arrived))
                if self._stopping.is_set():
                    return
        except (av.FFmpegError, OSError) as error:
            raise lost(self._name, error) from error

    def close(self) -> None:
        """Close it; call it after the iteration."""
        self._container.close()

    def _pieces(self) -> Iterator[av.Packet]:
        """Packets that are worth the trouble: drivers give hundreds or thousands of small ones a second."""
        stream = self._decoder.stream
        assert stream is not None
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

    def _taken(self, stamp: float, seconds: float, arrived: float) -> float:
        """When a piece began, in seconds of `time.monotonic`."""
        if self._zero is not None:
            self._stopping.wait(max(0.0, self._zero + stamp + seconds - time.monotonic()))
            return self._zero + stamp
        # ALSA stamps by the clock on the wall, other systems by the one that we use.
        ages = (age for age in (time.time() - stamp, time.monotonic() - stamp) if 0 <= age < MAX_CLOCK_AGE)
        return arrived - next(ages, seconds)


def microphone_list() -> list[tuple[str, str]]:
    """What to call each microphone, and its own name."""
    if sys.platform in SYSTEM_FORMATS:
        found = av.device.enumerate_input_devices(SYSTEM_FORMATS[sys.platform])
        return [(each.name, each.description) for each in found if "audio" in each.media_types]
    return alsa_microphones()


def _full_name(text: str) -> str:
    """What the system calls the microphone that is named in part, or the text itself."""
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
"""The same device behind a converter, so that one with a single channel or another rate will do."""
MAX_ALSA_ERRORS = 100


def alsa_microphones() -> list[tuple[str, str]]:
    """What to call each sound device that can be heard, and its own name; empty where there is none.

    Such as ("hw:1,0", "HD Webcam C270, USB Audio").
    """
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
    """Open a device by ALSA's name for it.

    Args:
        rate: samples a second to ask for, of two channels.

    Raises:
        OSError: it cannot be opened; `errno` says why if ALSA did, else it is 0: there is no such device.
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
    """Make ALSA ready; returns where the error numbers of its complaints go, which it would print.

    FFmpeg calls every failure an input/output error. The library that comes with PyAV would look for settings
    and plug-ins, among them those of PipeWire and PulseAudio, where it was built.
    """
    if SETTINGS.is_dir():
        os.environ.setdefault("ALSA_CONFIG_DIR", str(SETTINGS))
    machine = getattr(sys.implementation, "_multiarch", "")
    folders = (Path("/usr/lib", machine), Path("/usr/lib64"), Path("/usr/lib"))
    plugins = next((folder / "alsa-lib" for folder in folders if (folder / "alsa-lib").is_dir()), None)
    if plugins is not None:
        os.environ.setdefault("ALSA_PLUGIN_DIR", str(plugins))
    numbers: deque[int] = deque(maxlen=MAX_ALSA_ERRORS)
    for path in re.findall(r"/\S*libasound\S*\.so\S*", MAPS.read_text() if MAPS.exists() else ""):
        _note_errors(ctypes.CDLL(path), numbers)
        break
    return numbers


_kept: list[Any] = []
"""What ALSA calls must stay where it is."""


def _note_errors(library: Any, numbers: deque[int]) -> None:
    text, number = ctypes.c_char_p, ctypes.c_int
    kind = ctypes.CFUNCTYPE(None, text, number, text, number, text)
    _kept.append(kind(lambda file, line, function, error, words: numbers.append(error)))
    library.snd_lib_error_set_handler(_kept[-1])
