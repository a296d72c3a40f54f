"""The subjects of a benchmark: blocks, styles, and their input picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vidstyle.block import Block
from vidstyle.blocks import all_blocks
from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.resample import resample
from vidstyle.demo.drawing import film_picture
from vidstyle.errors import UsageError, suggest
from vidstyle.gallery.style_samples import style_of_block
from vidstyle.style import Style, load_style, style_names

PICTURE_SECONDS = 1.3
"""Time of the picture in the demo film, which shows faces, letters and hills."""


@dataclass(frozen=True)
class Subject:
    """A style to measure.

    Attributes:
        kind: whether it is a single block.
        on: the input of the block: "luma", "RGB", or "planes" for each plane separately; "" for a style.
    """

    kind: Literal["block", "style"]
    name: str
    style: Style
    on: str = ""


def subjects(styles: Sequence[str] = (), blocks: Sequence[str] = ()) -> list[Subject]:
    """Return the named subjects; by default all blocks and all styles except `plain`.

    Raises:
        StyleError: a style is missing or invalid.
        UsageError: a block does not exist.
    """
    if not styles and not blocks:
        return [*_blocks(all_blocks()), *_styles(style_names())]
    return [*_blocks(blocks), *_styles(styles)]


def film_picture_at(width: int, height: int) -> Picture:
    """Return a picture of the demo film at this size, 4:2:0, 8 bit."""
    drawn = resample(film_picture(PICTURE_SECONDS).astype(np.float32), (height, width), "bicubic")
    return convert(Picture.from_array(np.rint(drawn).clip(0, 255).astype(np.uint8)), Encoding())


def _blocks(names: Iterable[str]) -> list[Subject]:
    for name in names:
        if name not in all_blocks():
            raise UsageError(name, f"there is no block '{name}'", suggest(name, all_blocks()))
    blocks = (all_blocks()[name] for name in names)
    return [Subject("block", block.name, style_of_block(block), _works_on(block)) for block in blocks]


def _styles(names: Iterable[str]) -> list[Subject]:
    styles = (load_style(name) for name in names)
    return [Subject("style", style.name, style) for style in styles if not style.is_plain]


def _works_on(block: Block) -> str:
    return "planes" if block.kind == "resize" else "luma" if block.on == "luma" else "RGB"
