"""Films for measuring steadiness: parts of clips, a still scene, a moving disc."""

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

SCENE_RATE = 25
"""Frames per second of the still scene and the moving disc."""
DISC_SPEED_PX = 3
"""Motion of the disc from frame to frame, to the right."""


@dataclass(frozen=True)
class Clip:
    """Successive frames, each H x W x 3 uint8 RGB, and their times in seconds."""

    frames: list[np.ndarray]
    times: list[float]


def read_clip(path: Path, count: int, width: int) -> Clip:
    """Read frames from the middle of a film.

    Args:
        count: number of frames.
        width: maximum width in pixels; wider frames are scaled down.

    Raises:
        InputError: the film cannot be read, or has fewer than two frames.
    """
    with open_reader(path) as reader:
        start = _find_start(reader.info, count)
    with open_reader(path, ReadOptions(start=start)) as reader:
        frames = list(islice(_frames(reader), count))
    if len(frames) < 2:
        raise InputError(path, "is a single picture", "give films")
    rgb = [_scale_down(_to_rgb(frame.picture), width) for frame in frames]
    return Clip(rgb, [float(frame.time) for frame in frames])


def restyle_clip(style: Style, clip: Clip, device: str) -> list[np.ndarray]:
    """Return the frames of a clip in a style, rendered as a film."""
    with Renderer(style, device) as renderer:
        return [renderer(*frame) for frame in zip(clip.frames, clip.times, strict=True)]


def find_motions(clip: Clip) -> list[Motion | None]:
    """Return the motion from each frame to the next; None across a cut."""
    detector = SceneCutDetector()
    cuts = [
        detector.is_cut(sample_plane(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)).astype(np.float32) / 255)
        for frame in clip.frames
    ]
    pairs = zip(clip.frames, clip.frames[1:], cuts[1:], strict=False)
    return [None if cut else find_motion(first, second) for first, second, cut in pairs]


def make_still_scene(photograph: np.ndarray, count: int, noise: float, seed: int = 0) -> Clip:
    """Return a film of a photograph with new normal noise in each frame.

    Args:
        photograph: H x W x 3 uint8.
        count: number of frames.
        noise: standard deviation in levels of 255.
    """
    random = np.random.default_rng(seed)
    noisy = (photograph + random.normal(0, noise, photograph.shape) for _ in range(count))
    return _clip([np.clip(np.rint(frame), 0, 255).astype(np.uint8) for frame in noisy])


def make_moving_disc(photograph: np.ndarray, count: int) -> tuple[Clip, list[np.ndarray]]:
    """Return a film of a disc, cut from the mirrored photograph, that moves over the photograph.

    There is no noise, so only the motion changes pixels.

    Returns:
        The film, and for each frame the pixels around the edge of the disc, H x W bool: four times the motion
        per frame on each side.
    """
    height, width = photograph.shape[:2]
    texture = photograph[::-1, ::-1]
    rows, columns = np.indices((height, width))
    frames, edges = [], []
    for number in range(count):
        shift = DISC_SPEED_PX * (number - count // 2)
        distance = np.hypot(rows - height / 2, columns - width / 2 - shift) - height / 4
        disc = (distance <= 0)[..., None]
        frames.append(np.where(disc, np.roll(texture, shift, axis=1), photograph))
        edges.append(np.abs(distance) <= 4 * DISC_SPEED_PX)
    return _clip(frames), edges


def _clip(frames: list[np.ndarray]) -> Clip:
    return Clip(frames, [number / SCENE_RATE for number in range(len(frames))])


def _find_start(info: VideoInfo, count: int) -> Fraction | None:
    """Return the time in seconds where the middle `count` frames begin; None if the length is unknown."""
    if not info.duration or not info.rate:
        return None
    return max(Fraction(0), info.duration / 2 - count / info.rate / 2)


def _frames(reader: Reader) -> Iterator[Frame]:
    return (item for item in reader if isinstance(item, Frame))


def _to_rgb(picture: Picture) -> np.ndarray:
    color = color_rows(picture, 0, picture.shape[0])
    return np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)


def _scale_down(frame: np.ndarray, width: int) -> np.ndarray:
    if frame.shape[1] <= width:
        return frame
    size = width, round(frame.shape[0] * width / frame.shape[1])
    return cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
