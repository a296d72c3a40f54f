"""The films on which steadiness is measured: parts of clips, a still scene, a disc that moves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from tools.steadiness.warping import Motion, find_motion
from vidstyle.core.picture import Picture
from vidstyle.core.planes import color_rows
from vidstyle.core.sampling import sample_plane
from vidstyle.core.scene_cuts import SceneCutDetector
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.options import ReadOptions, VideoInfo
from vidstyle.media.read.reader import Reader, open_reader
from vidstyle.renderer import Renderer
from vidstyle.style import Style

RATE = 25
"""Frames a second of the scenes that are made here."""
SPEED = 3
"""Pixels that the disc moves from frame to frame."""


@dataclass(frozen=True)
class Clip:
    """Frames in a row, each H x W x 3 uint8 RGB, and their times in seconds."""

    frames: list[np.ndarray]
    times: list[float]


def read_clip(path: Path, count: int, width: int) -> Clip:
    """Frames from the middle of a film, reduced to a width if they are wider.

    Raises:
        InputError: it cannot be read, or has fewer than two frames there.
    """
    with open_reader(path) as reader:
        start = _start(reader.info, count)
    with open_reader(path, ReadOptions(start=start)) as reader:
        frames = list(islice(_frames(reader), count))
    if len(frames) < 2:
        raise InputError(path, "is a single picture", "give films")
    rgb = [_reduced(_rgb(frame.picture), width) for frame in frames]
    return Clip(rgb, [float(frame.time) for frame in frames])


def restyled(style: Style, clip: Clip, device: str) -> list[np.ndarray]:
    """The frames of a clip in a style, which sees them in a row."""
    with Renderer(style, device) as renderer:
        return [renderer(*frame) for frame in zip(clip.frames, clip.times, strict=True)]


def motions_of(clip: Clip) -> list[Motion | None]:
    """The motion from each frame to the next; None across a cut."""
    detector = SceneCutDetector()
    cuts = [
        detector.is_cut(sample_plane(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)).astype(np.float32) / 255)
        for frame in clip.frames
    ]
    pairs = zip(clip.frames, clip.frames[1:], cuts[1:], strict=False)
    return [None if cut else find_motion(first, second) for first, second, cut in pairs]


def still_scene(photograph: np.ndarray, count: int, noise: float, seed: int = 0) -> Clip:
    """A photograph, H x W x 3 uint8, under another normal noise in each frame, as a sensor's.

    Args:
        noise: standard deviation in levels of 255.
    """
    random = np.random.default_rng(seed)
    noisy = (photograph + random.normal(0, noise, photograph.shape) for _ in range(count))
    return _clip([np.clip(np.rint(frame), 0, 255).astype(np.uint8) for frame in noisy])


def moving_disc(photograph: np.ndarray, count: int) -> tuple[Clip, list[np.ndarray]]:
    """A disc of the mirrored photograph that moves over it, and where its edge is, H x W bool in each frame.

    There is no noise, so that nothing differs but what moves. The edge is as wide on both sides as the way of
    four frames.
    """
    height, width = photograph.shape[:2]
    texture = photograph[::-1, ::-1]
    rows, columns = np.indices((height, width))
    frames, edges = [], []
    for number in range(count):
        shift = SPEED * (number - count // 2)
        distance = np.hypot(rows - height / 2, columns - width / 2 - shift) - height / 4
        disc = (distance <= 0)[..., None]
        frames.append(np.where(disc, np.roll(texture, shift, axis=1), photograph))
        edges.append(np.abs(distance) <= 4 * SPEED)
    return _clip(frames), edges


def _clip(frames: list[np.ndarray]) -> Clip:
    return Clip(frames, [number / RATE for number in range(len(frames))])


def _start(info: VideoInfo, count: int) -> Fraction | None:
    """Where so many frames in the middle begin, in seconds; None where the length is not known."""
    if not info.duration or not info.rate:
        return None
    return max(Fraction(0), info.duration / 2 - count / info.rate / 2)


def _frames(reader: Reader) -> Iterator[Frame]:
    return (item for item in reader if isinstance(item, Frame))


def _rgb(picture: Picture) -> np.ndarray:
    color = color_rows(picture, 0, picture.shape[0])
    return np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)


def _reduced(frame: np.ndarray, width: int) -> np.ndarray:
    if frame.shape[1] <= width:
        return frame
    size = width, round(frame.shape[0] * width / frame.shape[1])
    return cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
