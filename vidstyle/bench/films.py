"""Benchmark of films: decoding, style, smoothing and encoding separately, and the whole `render`."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from statistics import median

from vidstyle.bench.subjects import Subject
from vidstyle.core.picture import Picture
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader, open_reader
from vidstyle.media.write.writer import WriteOptions, Writer, open_writer
from vidstyle.pipeline.render import render
from vidstyle.renderer import open_renderer
from vidstyle.style import Style

WARMUP_FRAMES = 2
"""Frames before timing starts, while kernels may be compiled."""


@dataclass(frozen=True)
class FilmTimes:
    """Seconds per frame of a film in one style.

    Attributes:
        steady: additional time for temporal smoothing.
        whole: time of the whole pipeline, including startup.
    """

    name: str
    decode: float
    style: float
    steady: float
    encode: float
    whole: float


class FilmBench:
    """The first frames of a film.

    Args:
        frames: the number of frames.

    Raises:
        InputError: the film cannot be read, or is too short.
    """

    def __init__(self, film: Path, frames: int, clock: Callable[[], float] = time.perf_counter) -> None:
        self._film, self._clock = film, clock
        with open_reader(film) as reader:
            self.info = reader.info
            began = clock()
            self._frames = list(islice(_frames(reader), frames))
            self._decode = (clock() - began) / max(1, len(self._frames))
        if len(self._frames) <= WARMUP_FRAMES:
            raise InputError(film, f"has {len(self._frames)} frames", "give a longer film")

    def run(self, subjects: Sequence[Subject], device: str = "auto") -> Iterator[FilmTimes]:
        """Measure each style in turn.

        Raises:
            DeviceError: the device does not exist.
            StyleError: a style is invalid.
        """
        for subject in subjects:
            with tempfile.TemporaryDirectory() as folder:
                writer = open_writer(Path(folder) / "film.mp4", self.info, WriteOptions())
                loose, results = self._style(replace(subject.style, steady=0.0), device, writer)
                steady = self._style(subject.style, device, writer)[0] if subject.style.steady else loose
                encode = self._encode(results, writer)
                done = render(self._film, Path(folder) / "whole.mp4", subject.style, device=device,
                              frames=len(self._frames))  # fmt: skip
            whole = done.elapsed / done.frames
            yield FilmTimes(subject.name, self._decode, loose, steady - loose, encode, whole)

    def _style(self, style: Style, device: str, writer: Writer) -> tuple[float, list[Picture]]:
        """Return the median of the seconds per frame, and the results."""
        renderer, results, times = open_renderer(style, device, announce=False), [], []
        try:
            for frame in self._frames:
                began, target = self._clock(), (writer.encoding, writer.wants_rgb)
                results.append(renderer.run(frame.picture, float(frame.time), *target))
                times.append(self._clock() - began)
            return median(times[WARMUP_FRAMES:]), results
        finally:
            renderer.close()

    def _encode(self, results: Sequence[Picture], writer: Writer) -> float:
        began = self._clock()
        for frame, picture in zip(self._frames, results, strict=True):
            writer.write(replace(frame, picture=picture, native=None))
        writer.finish()
        return (self._clock() - began) / len(results)


def _frames(reader: Reader) -> Iterator[Frame]:
    return (item for item in reader if isinstance(item, Frame))
