"""Generated films of several shots for the tests of comic pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cache
from pathlib import Path

import av
import cv2
import numpy as np
from media import frame_from_rgb, photograph

RATE = 25
SIZE = (256, 144)
PLACES = [
    (name, across, down)
    for across, down in [(0.3, 0.3), (0.7, 0.7), (0.3, 0.75), (0.7, 0.25)]
    for name in ("astronaut", "rocket", "coffee", "chelsea")
]
"""Dissimilar views: photographs, and relative positions of the center, 0..1."""

Place = tuple[str, float, float]


@cache
def _wide(name: str) -> np.ndarray:
    """Return a photograph so large that a frame shows less than half of it in each direction."""
    still = photograph(name)
    scale = 2.2 * max(SIZE[0] / still.shape[1], SIZE[1] / still.shape[0])
    size = round(still.shape[1] * scale), round(still.shape[0] * scale)
    return cv2.resize(still, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC)


def view(place: Place, across: float = 0, down: float = 0, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Return the view at a place, shifted by pixels, H x W x 3 uint8."""
    name, x, y = place
    wide = _wide(name)
    middle = x * (wide.shape[1] - 1) + across, y * (wide.shape[0] - 1) + down
    move = np.array([[1, 0, SIZE[0] / 2 - middle[0]], [0, 1, SIZE[1] / 2 - middle[1]]])
    seen = cv2.warpAffine(wide, move, SIZE, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return seen if size == SIZE else cv2.resize(seen, size, interpolation=cv2.INTER_CUBIC)


def shot(place: Place, frames: int, speed: float = 0.7, start: float = 0) -> list[np.ndarray]:
    """Return a shot that pans slowly from a place, `speed` pixels per frame."""
    return [view(place, start + speed * number, speed * number / 3) for number in range(frames)]


def dissolve(before: list[np.ndarray], after: list[np.ndarray], frames: int) -> list[np.ndarray]:
    """Join two shots with a dissolve of `frames` frames."""
    mixed = [
        cv2.addWeighted(old, 1 - share, new, share, 0)
        for old, new, share in zip(
            before[-frames:], after[:frames], np.linspace(0, 1, frames + 2)[1:-1], strict=True
        )
    ]
    return [*before[:-frames], *mixed, *after[frames:]]


def add_flash(frames: list[np.ndarray], number: int) -> list[np.ndarray]:
    """Replace two frames by a flash: a white frame and a bright one."""
    lit = [np.full_like(frames[number], 255), cv2.convertScaleAbs(frames[number + 1], alpha=0.4, beta=150)]
    return [*frames[:number], *lit, *frames[number + 2 :]]


def make_whip_pan(place: Place, frames: int, pixels: float, whip: int = 7) -> list[np.ndarray]:
    """Return a still shot with a whip pan of `whip` blurred frames in its middle."""
    step = pixels / whip
    turning = [
        np.mean([view(place, step * (number + part / 8)) for part in range(8)], axis=0)
        for number in range(whip)
    ]
    still = (frames - whip) // 2
    blurred = [np.rint(light).astype(np.uint8) for light in turning]
    return [*shot(place, still, 0), *blurred, *shot(place, frames - whip - still, 0, pixels)]


def small_luma(rgb: np.ndarray) -> np.ndarray:
    """Return luma as the shot detection reads it, 72 x 128 float32, 0..1."""
    luma = cv2.resize(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), (128, 72), interpolation=cv2.INTER_AREA)
    return luma.astype(np.float32) / 255


def write_film(
    path: Path, frames: Iterable[np.ndarray], rate: int = RATE, options: dict[str, str] | None = None
) -> Path:
    """Write a film of frames, H x W x 3 uint8 with even sides, and a key frame every second."""
    with av.open(str(path), "w") as container:
        usual = {"preset": "ultrafast", "crf": "16", "g": str(rate), "sc_threshold": "0"}
        video = container.add_stream("libx264", rate=Fraction(rate), options=usual | (options or {}))
        for number, rgb in enumerate(frames):
            if number == 0:
                video.height, video.width, video.pix_fmt = *rgb.shape[:2], "yuv420p"
            frame = frame_from_rgb(rgb)
            frame.pts, frame.time_base = number, Fraction(1, rate)
            container.mux(video.encode(frame))
        container.mux(video.encode(None))
    return path


def story(shots: int, frames: int) -> Iterator[np.ndarray]:
    """Yield `shots` shots of `frames` frames each, with cuts between them."""
    for number in range(shots):
        yield from shot(PLACES[number], frames)
