"""Writes a film from generated pictures and sound."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import Protocol

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.media.audio import LIVE_SAMPLE_RATE, AudioChunk
from vidstyle.media.color_tags import default_tags
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo, WriteOptions
from vidstyle.media.write.writer import open_writer


class Samples(Protocol):
    """An array, or an object whose slices are arrays."""

    def __getitem__(self, part: slice, /) -> np.ndarray:
        """Return the samples of a slice with start and stop."""


def write_film(path: Path, pictures: Iterable[Picture], rate: Fraction, sound: Samples) -> None:
    """Write an MP4 with H.264 and AAC.

    Args:
        path: an existing file is replaced.
        pictures: at least one, all of one size and encoding.
        rate: frames per second.
        sound: mono samples, float32, -1..1, 48,000 per second, as long as the pictures.
    """
    pictures = iter(pictures)
    first = next(pictures)
    height, width = first.shape
    info = VideoInfo(width, height, first.encoding, default_tags(first.encoding, height), 1 / rate, rate)
    options = WriteOptions(crf=18, preset="fast", audio="aac", new_sound=True, overwrite=True)
    with open_writer(path, info, options) as writer:
        for number, picture in enumerate(chain([first], pictures)):
            writer.write(Frame(picture, number, 1 / rate))
            start, end = (round(count * LIVE_SAMPLE_RATE / rate) for count in (number, number + 1))
            samples = np.tile(sound[start:end], (2, 1))
            writer.push_audio(AudioChunk(samples, 0), start / LIVE_SAMPLE_RATE)
