"""Clips for pages: frames of a film, a photograph, a folder of pictures, a camera or the example."""

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
from vidstyle.demo.drawing import FILM_HEIGHT_PX, FILM_RATE, FILM_SECONDS, FILM_WIDTH_PX
from vidstyle.demo.photograph import photograph_picture
from vidstyle.errors import InputError
from vidstyle.media.capture.sources import SourceOptions, is_file_name, resolve_source
from vidstyle.media.read.file_structure.headers import has_picture_ending
from vidstyle.media.read.sampler import FilmSampler, SampledFrame
from vidstyle.media.read.sequence import is_pattern
from vidstyle.media.resize import letterbox_picture
from vidstyle.preview.camera_clip import CameraClip, shrink

CACHED_BYTES = 64 << 20
"""Size of the frame cache."""
STEPS_FORWARD = 50
"""Up to this many frames ahead, decode on instead of seeking, which starts at a key frame."""
DEFAULT_RATE = Fraction(25)


class Clip(Protocol):
    """Random access to frames by number; thread-safe.

    Attributes:
        name: the name for messages and titles.
        source: the name for the command line.
        count: the number of frames; 1 for a photograph and for a camera.
        fps: frames per second.
        size: width and height of the whole frames, upright and with square pixels.
        live: whether it is a camera; any number then means the newest frame.
    """

    name: str
    source: str
    count: int
    fps: float
    size: tuple[int, int]
    live: bool

    def __hash__(self) -> int: ...

    def frame(self, number: int, side: int | None = None) -> np.ndarray:
        """Return a frame, H x W x 3 RGB uint8, read-only.

        Args:
            number: from 0; numbers beyond the end return the last frame.
            side: maximum shorter side in pixels; None: full size.

        Raises:
            InputError: the frame cannot be read.
            DeviceError: the camera was lost.
        """

    def glance(self, number: int, side: int) -> np.ndarray:
        """Return a frame with approximate colours, but at once: no kernel is compiled for it.

        Args and errors are those of `frame`; pictures of a folder keep their shape.
        """

    def file(self) -> str | None:
        """Return the equivalent input of `vidstyle render`: a path or a pattern; None for a camera."""

    def close(self) -> None:
        """Close the file or the camera."""


def open_clip(source: str | os.PathLike[str] | None) -> Clip:
    """Open the clip for a command-line argument.

    Args:
        source: a film, a photograph, a folder of pictures, a pattern such as "%05d.png", a word that
            `vidstyle live` knows ("camera", "test"), or None for the example.

    Raises:
        InputError: the source cannot be read.
        DeviceError: the camera does not exist.
    """
    if source is None:
        return DemoClip()
    text = str(source)
    if Path(text).is_dir():
        return FilmClip(_pattern_of(Path(text)), name=text)
    if is_pattern(text) or is_file_name(text):
        return FilmClip(text)
    return CameraClip(resolve_source(text, SourceOptions()))


class FilmClip:
    """A film, a photograph or numbered pictures; see `Clip`.

    A number selects the frame shown in the middle of its interval at a constant rate. In a film of constant
    rate, each frame therefore has one number.
    """

    live = False

    def __init__(self, path: str | os.PathLike[str], name: str = "") -> None:
        """`name`: the display name, if it differs from the path.

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
        self._sampler = _open_sampler(path)
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

    def glance(self, number: int, side: int) -> np.ndarray:
        """See `Clip`."""
        with self._lock:
            if self._is_closed:
                raise InputError(self.name, "is closed")
            self._move_to(min(number, self.count - 1))
            height, width = self._at.shape
            return self._at.glance(round(side * max(width, height) / min(width, height)))

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
        if self._at.shape != self._shape:  # pictures of a folder may differ in size
            factor = longer / max(self._shape)
            picture = letterbox_picture(
                picture, max(1, round(width * factor)), max(1, round(height * factor))
            )
        return to_rgb(picture)


def _open_sampler(path: str | os.PathLike[str]) -> FilmSampler:
    """Open a film or a picture; errors name the kind that its extension promises."""
    try:
        return FilmSampler(path)
    except InputError as error:
        if not has_picture_ending(Path(path)):
            raise
        reason = error.reason.replace("not a readable video", "not a readable picture")
        raise InputError(error.subject, reason, error.remedy) from error


class DemoClip:
    """The example that is shown until a file is opened; see `Clip`."""

    name, source, live = "demo", "film.mp4", False
    count, fps, size = FILM_SECONDS * FILM_RATE, float(FILM_RATE), (FILM_WIDTH_PX, FILM_HEIGHT_PX)

    def __init__(self) -> None:
        self._draw = lru_cache(self.count)(_draw_frame)
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def frame(self, number: int, side: int | None = None) -> np.ndarray:
        """See `Clip`."""
        return shrink(self._draw(min(number, self.count - 1)), side)

    def glance(self, number: int, side: int) -> np.ndarray:
        """See `Clip`."""
        return self.frame(number, side)

    def file(self) -> str:
        """See `Clip`; write the file now and delete it in `close`."""
        from vidstyle.demo.make_demo import make_film

        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="vidstyle-")
            make_film(Path(self._folder.name) / "demo.mp4", draw=photograph_picture)
        return str(Path(self._folder.name) / "demo.mp4")

    def close(self) -> None:
        """See `Clip`."""
        if self._folder is not None:
            self._folder.cleanup()


def _draw_frame(number: int) -> np.ndarray:
    picture = photograph_picture(number / FILM_RATE)
    picture.flags.writeable = False
    return picture


def _pattern_of(folder: Path) -> str:
    """Return the pattern for the pictures in a folder, by the most frequent extension."""
    endings = Counter(path.suffix for path in folder.iterdir() if has_picture_ending(path) and path.is_file())
    if not endings:
        raise InputError(folder, "is a folder without pictures", "name a film or a photograph")
    return str(folder / f"*{endings.most_common(1)[0][0]}")
