"""Samples: render a picture in several styles, label, arrange and encode the results."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import cv2
import numpy as np

from vidstyle.block import Block
from vidstyle.blocks import all_blocks
from vidstyle.core.cores import available_cores
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.style import Step, Style
from vidstyle.style.wiring import wiring_of

LABEL_HEIGHT_PX, BORDER_PX = 24, 4
"""Height of the label above a picture, and width of the border on its other sides, in pixels."""
SHEET_ASPECT = 16 / 10
"""The aspect ratio that the layout of a sheet approximates."""
MAX_SHEET_SIDE = 480
"""The longest side of one picture on a sheet of samples, in pixels."""

_ENCODER_PARAMETERS = {
    ".png": [],
    # Subsampled chroma would wash out coloured dots and strokes.
    ".jpg": [
        *(cv2.IMWRITE_JPEG_QUALITY, 88),
        *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
        *(cv2.IMWRITE_JPEG_OPTIMIZE, 1),
    ],
}


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


def samples_of(picture: np.ndarray, styles: Iterable[Style]) -> Iterator[StyleSample]:
    """Render a picture, H x W x 3 uint8, in each style; yield samples in order. Uses all cores."""
    with ThreadPoolExecutor(available_cores(), thread_name_prefix="vidstyle-gallery") as pool:
        yield from pool.map(lambda style: StyleSample(style, restyled(picture, style)), styles)


def restyled(picture: np.ndarray, style: Style) -> np.ndarray:
    """Render a picture, H x W x 3 uint8, in a style. Uses one thread."""
    source = Picture.from_array(picture)
    with CpuRenderer(replace(style, steady=0.0), threads=1) as renderer:
        color = renderer.run(source, None, source.encoding, rgb=True).color
    assert color is not None
    return np.array(color)


def labelled(picture: np.ndarray, name: str) -> np.ndarray:
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
        (labelled(cv2.resize(each, size, interpolation=cv2.INTER_AREA), name) for name, each in named),
        min(max(1, columns), len(named)),
    )


def encoded(picture: np.ndarray, suffix: str) -> bytes:
    """Encode a picture, H x W x 3 uint8 RGB, as a .png or .jpg file."""
    done, content = cv2.imencode(suffix, picture[..., ::-1], _ENCODER_PARAMETERS[suffix])
    assert done, suffix
    return content.tobytes()
