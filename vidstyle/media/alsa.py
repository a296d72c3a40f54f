"""Linux's sound system, ALSA: the microphones it knows, and how they are opened through FFmpeg."""

from __future__ import annotations

import ctypes
import os
import re
import sys
from collections import deque
from functools import cache
from pathlib import Path
from typing import Any

import av

SOUND = Path("/proc/asound")
SETTINGS = Path("/usr/share/alsa")
MAPS = Path("/proc/self/maps")
HARDWARE = "hw:"
CONVERTED = "plughw:"
"""The same device behind a converter, so that one with a single channel or another rate will do."""
MOST_COMPLAINTS = 100


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
    complaints = prepared_alsa()
    complaints.clear()
    if name.startswith(HARDWARE):
        name = CONVERTED + name.removeprefix(HARDWARE)
    try:
        return av.open(name, "r", "alsa", {"sample_rate": str(rate), "channels": "2"})
    except (av.FFmpegError, OSError) as error:
        number = next((number for number in complaints if number), 0)
        raise OSError(number, os.strerror(number) if number else "no such device") from error


@cache
def prepared_alsa() -> deque[int]:
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
    numbers: deque[int] = deque(maxlen=MOST_COMPLAINTS)
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
