"""Generated key frames for the tests of comic layout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box

LANDSCAPE, PORTRAIT, SQUARE, WIDE = (1080, 1920), (1920, 1080), (900, 900), (332, 800)


def random_film(seed: int, count: int, shapes: Sequence[tuple[int, int]] = (LANDSCAPE,)) -> list[KeyFrame]:
    """Return `count` key frames; half of them have one to three faces, which may overlap."""
    random = np.random.default_rng(seed)
    key_frames, scene = [], 0
    for number in range(count):
        height, width = shapes[random.integers(len(shapes))]
        saliency = random_box(random, width, height, 0.2 * np.array([width, height]), 3.0)
        faces = [
            random_box(random, width, height, np.full(2, 0.05 * min(width, height)), 7.0)
            for _ in range(random.integers(1, 4) if random.random() < 0.5 else 0)
        ]
        by_size = tuple(sorted(faces, key=lambda face: -face.area))
        scene += int(random.random() < 0.5)
        key_frames.append(
            KeyFrame(Fraction(number * 3), (height, width), random.random(), saliency, by_size, scene)
        )
    max_importance = max(key_frame.importance for key_frame in key_frames)
    return [replace(key_frame, importance=key_frame.importance / max_importance) for key_frame in key_frames]


def random_box(
    random: np.random.Generator, width: int, height: int, min_size: np.ndarray, max_scale: float
) -> Box:
    """Return a random box within a picture, with 1 to `max_scale` times the size `min_size`."""
    wide, high = min_size * random.uniform(1, max_scale)
    left, top = random.uniform(0, width - wide), random.uniform(0, height - high)
    return Box(left, top, left + wide, top + high)


def even_film(count: int, shape: tuple[int, int] = LANDSCAPE) -> list[KeyFrame]:
    """Return key frames of equal importance, each a separate scene with central saliency."""
    height, width = shape
    middle = Box(width * 0.35, height * 0.3, width * 0.65, height * 0.7)
    return [KeyFrame(Fraction(number), shape, 0.5, middle, (), number) for number in range(count)]
