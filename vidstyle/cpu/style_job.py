"""What a process must know to restyle pictures of one layout."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.cpu.scheduling.schedule import schedule
from vidstyle.cpu.scheduling.sweeps import Schedule
from vidstyle.style import Style
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle
from vidstyle.style.resolve import resolve

MAX_PLANS = 8
"""Styles and layouts of pictures that a process keeps ready."""


@dataclass(frozen=True)
class StyleJob:
    """A style for pictures of one layout; see `lower` for the arguments."""

    style: Style
    layout: PictureLayout
    target: Encoding
    rgb: bool

    def packed(self) -> bytes:
        """Return the argument of `plan`."""
        return pickle.dumps(self)


@lru_cache(MAX_PLANS)
def plan(packed: bytes) -> tuple[LoweredStyle, Schedule]:
    """Return the lowered style and the schedule of a job."""
    job: StyleJob = pickle.loads(packed)
    steps = resolve(job.style, *job.layout.shape)
    lowered = lower(job.style, steps, job.layout, job.target, job.rgb)
    return lowered, schedule(lowered)


def blank_picture(packed: bytes) -> Picture:
    """Return a picture of zeros in the layout of a job."""
    job: StyleJob = pickle.loads(packed)
    (height, width), encoding = job.layout.shape, job.layout.encoding
    if job.layout.planes == "color":
        return Picture(encoding, color=np.zeros((height, width, 3), encoding.dtype))
    luma = np.zeros((height, width), encoding.dtype)
    if job.layout.planes == "gray":
        return Picture(encoding, luma)
    blue, red = np.zeros((2, *encoding.chroma_shape(height, width)), encoding.dtype)
    return Picture(encoding, luma, (blue, red))
