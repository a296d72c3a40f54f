"""Thumbnails of blocks for lists and help."""

from __future__ import annotations

from vidstyle.blocks import all_blocks
from vidstyle.gallery.style_samples import style_of_block
from vidstyle.gallery.thumbnail import restyle_thumbnail
from vidstyle.preview.encode import encode
from vidstyle.style import SOURCE, Style


def sample_names() -> list[str]:
    """Return the names of the blocks, and of the untouched picture."""
    return [SOURCE, *all_blocks()]


def block_sample(name: str) -> bytes:
    """Render the thumbnail of a block with default values, or the untouched picture, as JPEG."""
    style = Style(SOURCE) if name == SOURCE else style_of_block(all_blocks()[name])
    return encode(restyle_thumbnail(style), "jpeg")
