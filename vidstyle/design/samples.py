"""Thumbnails of blocks on the user's picture, for lists and help."""

from __future__ import annotations

import numpy as np

from vidstyle.blocks import all_blocks
from vidstyle.gallery.style_samples import style_of_block
from vidstyle.gallery.thumbnail import restyle_thumbnail
from vidstyle.preview.encode import encode
from vidstyle.style import SOURCE, Step, Style

TELLING_STEPS = {
    "blend": (Step("gaussian", {"sigma": 8}), Step("blend", {"mode": "screen"})),
    "gaussian": (Step("gaussian", {"sigma": 5}),),
    "soft_threshold": (Step("to_gray"), Step("soft_threshold")),
}
"""Steps that show what a block is for, if its default values alone do not."""


def sample_names() -> list[str]:
    """Return the names of the blocks, and of the untouched picture."""
    return [SOURCE, *all_blocks()]


def block_sample(name: str, picture: np.ndarray | None) -> bytes:
    """Render the thumbnail of a block, or the untouched picture, as JPEG; see `restyle_thumbnail`."""
    return encode(restyle_thumbnail(_style_of(name), picture), "jpeg")


def _style_of(name: str) -> Style:
    if name == SOURCE:
        return Style(SOURCE)
    telling = TELLING_STEPS.get(name)
    return style_of_block(all_blocks()[name]) if telling is None else Style(name, background=telling)
