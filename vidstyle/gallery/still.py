"""One picture of a film, a photograph or a sequence, for previews."""

from __future__ import annotations

import logging
from contextlib import closing
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader, open_source

MAX_SIDE = 960
"""The longest side of the picture in pixels: styles take seconds at this size."""

log = logging.getLogger("vidstyle")


def read_still(source: str | Path, read: ReadOptions | None = None) -> np.ndarray:
    """One picture of the source, upright, with square pixels, no side above `MAX_SIDE`: H x W x 3 uint8.

    Args:
        source: what `open_reader` opens.
        read: how to read it; without a start, the middle of a film is taken and the first picture of a pipe.

    Raises:
        InputError: it cannot be read, or has no picture at that time.
    """
    read = read or ReadOptions()
    middle = _middle(source, read) if read.start is None and str(source) != "-" else None
    if middle is not None:
        try:
            return _read(source, replace(read, start=middle))
        except InputError:
            log.warning("%s: no picture in the middle of its announced duration: showing its first", source)
    return _read(source, read)


def _middle(source: str | Path, read: ReadOptions) -> Fraction | None:
    """Half of a film's duration; None if it is a single picture."""
    with closing(open_source(source, read)) as opened:
        return opened.duration / 2 if opened.duration and opened.frames != 1 else None


def _read(source: str | Path, read: ReadOptions) -> np.ndarray:
    with open_reader(source, read) as reader:
        color = to_rgb(next(item for item in reader if isinstance(item, Frame)).picture)
        return _reduced(color, round(color.shape[1] * (reader.info.sample_aspect or 1)))


def _reduced(color: np.ndarray, width: int) -> np.ndarray:
    """The picture at this width, so that its pixels are square, then reduced to `MAX_SIDE`."""
    height = color.shape[0]
    factor = min(1, MAX_SIDE / max(width, height))
    size = max(1, round(width * factor)), max(1, round(height * factor))
    smaller = size[0] <= color.shape[1] and size[1] <= height
    return cv2.resize(color, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)
