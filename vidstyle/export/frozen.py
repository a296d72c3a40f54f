"""Measurements of a film, percentiles and colours, frozen from a few of its frames."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.core.color.film_colors import MAX_SIDE_PX, FilmColors
from vidstyle.core.convert import to_rgb
from vidstyle.core.picture import Picture
from vidstyle.core.sampling import sample_plane
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader, open_source
from vidstyle.style import Style
from vidstyle.style.mask_declarations import BACKDROP, fixed_mask_level
from vidstyle.style.resolve import masks_read

MEASURED_FRAMES = 8
"""Number of frames measured in a film."""


def frozen_percentiles(style: Style, pictures: Iterable[np.ndarray]) -> dict[str, tuple[float, ...]]:
    """Return the mean percentiles of the measured steps of a style, by step name in plans.

    Args:
        pictures: H x W x 3 uint8.
    """
    with CpuRenderer(replace(style, steady=0.0)) as renderer:
        taken = [renderer.measured(_with_fixed_masks(style, each)) for each in pictures]
    means = {step: np.mean([each[step] for each in taken], axis=0) for step in taken[0]}
    return {f"{layer} {number}": tuple(map(float, mean)) for (layer, number), mean in means.items()}


def _with_fixed_masks(style: Style, color: np.ndarray) -> Picture:
    """Return a picture with the masks that an exported style has."""
    levels = {name: round(255 * fixed_mask_level(name)) for name in masks_read(style)}
    masks = {
        name: np.full(color.shape if name == BACKDROP else color.shape[:2], level, np.uint8)
        for name, level in levels.items()
    }
    return replace(Picture.from_array(color), masks=masks)


def freeze_colors(plan: dict[str, Any], pictures: Iterable[np.ndarray]) -> None:
    """Fill the film colour textures of a plan with the main colours of pictures, H x W x 3 uint8."""
    combined = Picture.from_array(np.concatenate([sample_plane(each, MAX_SIDE_PX) for each in pictures]))
    for texture in plan["textures"].values():
        if "film" in texture:
            table = np.empty(texture["size"][1::-1], np.float32)
            FilmColors().follow(combined, None, table)
            texture["data"] = b64encode(table.tobytes()).decode("ascii")


def frames_of(film: Path) -> Iterator[np.ndarray]:
    """Yield evenly spaced frames of a film, H x W x 3 uint8: the middles of `MEASURED_FRAMES` equal parts.

    Raises:
        InputError: the film cannot be read.
    """
    with closing(open_source(film, ReadOptions())) as opened:
        parts = MEASURED_FRAMES if opened.duration and opened.frames != 1 else 1
        length = opened.duration or Fraction(0)
    for part in range(parts):
        start = length * (2 * part + 1) / (2 * parts) if parts > 1 else None
        with open_reader(film, ReadOptions(start=start)) as reader:
            yield from (to_rgb(item.picture) for item in _first(reader))


def _first(items: Iterable[object]) -> Iterator[Frame]:
    """Yield the first frame, if any; the announced duration may be too long."""
    yield from [
        item for _, item in zip(range(1), (each for each in items if isinstance(each, Frame)), strict=False)
    ]


def usual_picture(width: int, height: int) -> np.ndarray:
    """Return a substitute for a film: all tones from near black to near white, in muted colours.

    Returns:
        H x W x 3 uint8.
    """
    tones = np.linspace(0.05, 0.9, width)[None, :, None]
    turns = 2 * np.pi * (np.linspace(0, 1, height)[:, None, None] + np.array([0, 1, 2]) / 3)
    return (255 * np.clip(tones + 0.08 * np.cos(turns), 0, 1)).astype(np.uint8)
