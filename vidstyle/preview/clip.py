"""What a page shows, as frames: a film, a photograph, a folder of pictures, a camera or the demo film."""

from __future__ import annotations

import os
import tempfile
import threading
from collections import Counter, OrderedDict
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Protocol

import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.demo.drawing import FILM_HEIGHT_PX, FILM_RATE, FILM_SECONDS, FILM_WIDTH_PX, film_picture
from vidstyle.errors import InputError
from vidstyle.media.capture.sources import SourceOptions, is_file_name, live_source
from vidstyle.media.read.headers import has_picture_ending
from vidstyle.media.read.sampler import FilmSampler, SampledFrame
from vidstyle.media.read.sequence import is_pattern
from vidstyle.media.resize import letterboxed
from vidstyle.preview.camera_clip import CameraClip, shrunk

CACHED_BYTES = 64 << 20
"""Size of the frames that are kept."""
STEPS_FORWARD = 50
"""Frames ahead up to which a film is decoded on rather than sought in, which begins at a key frame."""
DEFAULT_RATE = Fraction(25)


class Clip(Protocol):
    """Frames by number. Any thread may ask for one.

    Attributes:
        name: for messages and titles.
        source: how a command line names it.
        count: the number of frames; 1 for a photograph and for a camera.
        fps: frames a second.
        size: width and height of the whole frames, upright and with square pixels.
        live: whether frames come from a camera; a number then stands for the newest one.
    """

    name: str
    source: str
    count: int
    fps: float
    size: tuple[int, int]
    live: bool

    def frame(self, number: int, side: int | None = None) -> np.ndarray:
        """A frame, H x W x 3 RGB uint8, which nobody may change.

        Args:
            number: from 0; the last one stands for those after it.
            side: the most pixels on the shorter side; None: full size.

        Raises:
            InputError: it cannot be read.
            DeviceError: the camera has been lost.
        """

    def file(self) -> str | None:
        """What `vidstyle render` reads to get the same: a path or a pattern; None for a camera."""

    def close(self) -> None:
        """Close the file or the camera."""


def open_clip(source: str | os.PathLike[str] | None) -> Clip:
    """The clip that a command line argument names.

    Args:
        source: a film, a photograph, a folder of pictures, a pattern such as "%05d.png", a word that
            `vidstyle live` knows ("camera", "test"), or None for the demo film.

    Raises:
        InputError: it cannot be read.
        DeviceError: there is no such camera.
    """
    if source is None:
        return DemoClip()
    text = str(source)
    if Path(text).is_dir():
        return FilmClip(_pattern_of(Path(text)), name=text)
    if is_pattern(text) or is_file_name(text):
        return FilmClip(text)
    return CameraClip(live_source(text, SourceOptions()))


class FilmClip:
    """A film, a photograph or numbered pictures; see `Clip`.

    A number stands for the frame that is shown in the middle of its interval at a constant rate: in a film
    of constant rate each frame has its number.
    """

    live = False

    def __init__(self, path: str | os.PathLike[str], name: str = "") -> None:
        """`name`: what the path is called, where it is not its own name.

        Raises:
            InputError: it cannot be read.
        """
        self.source = str(path)
        self.name = name or self.source
        self._at: SampledFrame
        self._next: SampledFrame | None
        self._number: int
        self._is_closed = False
        self._lock = threading.Lock()
        self._cache: OrderedDict[tuple[int, int | None], np.ndarray] = OrderedDict()
        self._steps_forward = 1 if is_pattern(path) else STEPS_FORWARD
        self._sampler = FilmSampler(path)
        try:
            self._rate = self._sampler.rate or DEFAULT_RATE
            self.count = self._sampler.count or sum(1 for _ in self._sampler.frames())
            self._seek(0)
            self.fps = float(self._rate)
            height, width = self._shape = self._at.shape
        except BaseException:
            self._sampler.close()
            raise
        self.size = width, height

    def frame(self, number: int, side: int | None = None) -> np.ndarray:
        """See `Clip`."""
        number = min(number, self.count - 1)
        shorter = min(self._shape)
        side = None if side is None or side >= shorter else side
        with self._lock:
            if (number, side) not in self._cache:
                if self._is_closed:
                    raise InputError(self.name, "is closed")
                self._move_to(number)
                self._keep((number, side), self._picture(side))
            self._cache.move_to_end((number, side))
            return self._cache[number, side]

    def file(self) -> str:
        """See `Clip`."""
        return self.source

    def close(self) -> None:
        """See `Clip`."""
        with self._lock:
            self._is_closed = True
            self._sampler.close()

    def _keep(self, key: tuple[int, int | None], picture: np.ndarray) -> None:
        picture.flags.writeable = False
        self._cache[key] = picture
        most = max(2, CACHED_BYTES // picture.nbytes)
        while len(self._cache) > most:
            self._cache.popitem(last=False)

    def _move_to(self, number: int) -> None:
        if not self._number <= number <= self._number + self._steps_forward:
            self._seek(number)
        time = self._time(number)
        while self._next is not None and self._next.time <= time:
            self._at, self._next = self._next, next(self._frames, None)
        self._number = number

    def _seek(self, number: int) -> None:
        self._frames: Iterator[SampledFrame] = self._sampler.frames(
            self._time(number) if number else Fraction(0)
        )
        first = next(self._frames, None)
        if first is None:
            raise InputError(self.name, "no frame could be decoded")
        self._at, self._next = first, next(self._frames, None)
        self._number = number

    def _time(self, number: int) -> Fraction:
        return (number + Fraction(1, 2)) / self._rate

    def _picture(self, side: int | None) -> np.ndarray:
        height, width = self._shape
        longer = max(self._shape) if side is None else round(side * max(self._shape) / min(self._shape))
        picture = self._at.picture(longer)
        if self._at.shape != self._shape:  # pictures of a folder may have other sizes than the first
            factor = longer / max(self._shape)
            picture = letterboxed(picture, max(1, round(width * factor)), max(1, round(height * factor)))
        return to_rgb(picture)


class DemoClip:
    """The film of `vidstyle demo`, drawn frame by frame; see `Clip`."""

    name, source, live = "demo", "film.mp4", False
    count, fps, size = FILM_SECONDS * FILM_RATE, float(FILM_RATE), (FILM_WIDTH_PX, FILM_HEIGHT_PX)

    def __init__(self) -> None:
        self._draw = lru_cache(self.count)(_drawn)
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def frame(self, number: int, side: int | None = None) -> np.ndarray:
        """See `Clip`."""
        return shrunk(self._draw(min(number, self.count - 1)), side)

    def file(self) -> str:
        """See `Clip`; the file is written now, and deleted by `close`."""
        from vidstyle.demo.make_demo import make_film

        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="vidstyle-")
            make_film(Path(self._folder.name) / "demo.mp4")
        return str(Path(self._folder.name) / "demo.mp4")

    def close(self) -> None:
        """See `Clip`."""
        if self._folder is not None:
            self._folder.cleanup()


def _drawn(number: int) -> np.ndarray:
    picture = film_picture(number / FILM_RATE)
    picture.flags.writeable = False
    return picture


def _pattern_of(folder: Path) -> str:
    """The pattern for the pictures in a folder: of the most frequent ending."""
    endings = Counter(path.suffix for path in folder.iterdir() if has_picture_ending(path) and path.is_file())
    if not endings:
        raise InputError(folder, "is a folder without pictures", "name a film or a photograph")
    return str(folder / f"*{endings.most_common(1)[0][0]}")
