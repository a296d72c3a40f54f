"""Samples: render a picture in several styles, label, arrange and encode the results."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np

from vidstyle.block import Block
from vidstyle.blocks import all_blocks
from vidstyle.core.machine.cores import available_cores
from vidstyle.core.scene_cuts import SceneCuts
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.media.picture_bytes import jpeg_bytes, png_bytes
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.regions.still_faces import NO_FACES, KnownFaces, StillFaces
from vidstyle.renderer import restyle_array
from vidstyle.style import Step, Style
from vidstyle.style.wiring import wiring_of

LABEL_HEIGHT_PX, BORDER_PX = 24, 4
"""Height of the label above a picture, and width of the border on its other sides, in pixels."""
SHEET_ASPECT = 16 / 10
"""The aspect ratio that the layout of a sheet approximates."""
MAX_SHEET_SIDE = 480
"""The longest side of one picture on a sheet of samples, in pixels."""
JPEG_QUALITY = 88


@dataclass(frozen=True)
class StyleSample:
    """A picture in a style; H x W x 3 uint8."""

    style: Style
    picture: np.ndarray


def style_of_block(block: Block) -> Style:
    """Return a style with one block at its defaults, after the blocks whose saved pictures it reads."""
    step = Step(block.name)
    wanted = set(wiring_of(step).reads.values())
    savers = [other for other in map(Step, all_blocks()) if wanted & set(wiring_of(other).saves)]
    return Style(block.name, background=(*savers, step))


def samples_of(
    picture: np.ndarray, styles: Iterable[Style], whole: np.ndarray | None = None
) -> Iterator[StyleSample]:
    """Render a picture in each style; yield samples in order. Uses all cores.

    Args:
        picture: H x W x 3 uint8.
        styles: the styles.
        whole: the picture at its full size, in which faces are found, if `picture` is a reduced copy.
    """
    whole = picture if whole is None else whole
    faces, side = StillFaces().find("picture", lambda: whole), min(whole.shape[:2])

    def sample(style: Style) -> StyleSample:
        return StyleSample(style, restyle_picture(picture, style, faces, side))

    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-gallery") as pool:
        yield from pool.map(sample, styles)


def restyle_picture(
    picture: np.ndarray, style: Style, faces: KnownFaces = NO_FACES, seen_side: float = math.inf
) -> np.ndarray:
    """Render a picture, H x W x 3 uint8, in a style, with focus on these faces. Uses one thread.

    `seen_side`: see `FrameRequest`; by default, it shows the style rather than a small picture.
    """

    def open_backend(style: Style, cuts: SceneCuts | None) -> CpuRenderer:
        return CpuRenderer(style, threads=1)

    with MaskRenderer(style, lambda: FocusRenderer(style, open_backend, faces)) as renderer:
        return restyle_array(renderer, picture, seen_side=seen_side)


def label_picture(picture: np.ndarray, name: str) -> np.ndarray:
    """Return the picture, H x W x 3 uint8, with a white border and its name above."""
    framed = cv2.copyMakeBorder(
        picture, LABEL_HEIGHT_PX, BORDER_PX, BORDER_PX, BORDER_PX, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )
    at = (BORDER_PX, LABEL_HEIGHT_PX - 8)
    return cv2.putText(framed, name, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)


def sheet_of(pictures: Iterable[np.ndarray], columns: int) -> np.ndarray:
    """Arrange pictures of one size in rows of `columns`; H x W x 3 uint8."""
    pictures = list(pictures)
    pictures += [np.full_like(pictures[0], 255)] * (-len(pictures) % columns)
    rows = (pictures[first : first + columns] for first in range(0, len(pictures), columns))
    return np.vstack([np.hstack(row) for row in rows])


def sheet_of_samples(named: Sequence[tuple[str, np.ndarray]]) -> np.ndarray:
    """Arrange labelled, reduced pictures of one size on a sheet of about `SHEET_ASPECT`."""
    height, width = named[0][1].shape[:2]
    factor = min(1, MAX_SHEET_SIDE / max(height, width))
    size = max(1, round(width * factor)), max(1, round(height * factor))
    columns = round((len(named) * SHEET_ASPECT * (size[1] + LABEL_HEIGHT_PX) / size[0]) ** 0.5)
    return sheet_of(
        (label_picture(cv2.resize(each, size, interpolation=cv2.INTER_AREA), name) for name, each in named),
        min(max(1, columns), len(named)),
    )


def encode_picture(picture: np.ndarray, suffix: str) -> bytes:
    """Encode a picture, H x W x 3 uint8 RGB, as a .png or .jpg file."""
    return png_bytes(picture) if suffix == ".png" else jpeg_bytes(picture, JPEG_QUALITY, optimized=True)


def jpeg_address(picture: np.ndarray) -> str:
    """Return a "data:" address for a page that contains the picture, H x W x 3 uint8 RGB."""
    return f"data:image/jpeg;base64,{b64encode(encode_picture(picture, '.jpg')).decode('ascii')}"
