"""Pictures of styles and blocks for lists: a photograph in each."""

from __future__ import annotations

from vidstyle.blocks import all_blocks
from vidstyle.gallery.thumbnail import restyled_thumbnail, thumbnail
from vidstyle.preview.encode import encode
from vidstyle.style import Step, Style, load_style


def style_sample(name: str) -> bytes:
    """A style as JPEG.

    Raises:
        StyleError: it cannot be used.
    """
    return encode(thumbnail(load_style(name)), "jpeg")


def block_sample(name: str) -> bytes:
    """A block at its defaults as JPEG, after the block that saves the picture it needs."""
    block = all_blocks()[name]
    wanted = {block.parameters[each].default for each in block.saved_refs}
    savers = [each for each in all_blocks().values() if each.saves and each.saves in wanted]
    steps = tuple(Step(each.name) for each in (*savers, block))
    return encode(restyled_thumbnail(Style(name, background=steps)), "jpeg")
