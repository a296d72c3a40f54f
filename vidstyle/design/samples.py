"""Thumbnails of styles and blocks for lists."""

from __future__ import annotations

from vidstyle.blocks import all_blocks
from vidstyle.gallery.style_samples import style_of_block
from vidstyle.gallery.thumbnail import restyle_thumbnail
from vidstyle.preview.encode import encode


def block_sample(name: str) -> bytes:
    """Render the thumbnail of a block with default values as JPEG."""
    return encode(restyle_thumbnail(style_of_block(all_blocks()[name])), "jpeg")
